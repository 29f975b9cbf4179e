from __future__ import annotations

import inspect
import pickle
import re
import signal
from collections.abc import Callable
from enum import Enum

import pytest

import robotcore
from robotcore import errors
from robotcore.errors import (
    MAX_EXCEPTION_TEXT,
    BehaviourError,
    DescriptionError,
    DeviceClosedError,
    DeviceError,
    DeviceGroupError,
    Interrupted,
    Mistake,
    RobotcoreError,
    StaleSampleError,
    UnknownNameError,
)
from robotcore.text import suggestion
from tests.texts import CheckText

BRANCH = re.compile(r"^ *(?P<stem>[│├└─ ]*)(?P<name>\w+)(?: \((?P<builtin>\w+)\))? *(?P<meaning>.*)$")
DEFINED = {
    name: kind
    for name, kind in vars(errors).items()
    if inspect.isclass(kind)
    and issubclass(kind, BaseException)
    and kind.__module__ == errors.__name__
    and name[0] != "_"
}


def _parse_tree() -> dict[str, tuple[str | None, str | None, str]]:
    """Return the tree of the module's docstring: each name's parent, builtin and meaning."""
    tree: dict[str, tuple[str | None, str | None, str]] = {}
    parents: dict[int, str] = {}
    assert errors.__doc__
    for line in errors.__doc__.splitlines()[2:]:
        if (match := BRANCH.match(line)) and match["name"] in DEFINED:
            depth = len(match["stem"]) // 4
            parents[depth] = match["name"]
            tree[match["name"]] = (parents.get(depth - 1), match["builtin"], match["meaning"])
    return tree


def test_every_error_is_in_the_drawn_tree() -> None:
    assert set(_parse_tree()) == set(DEFINED)


def test_the_tree_draws_each_error_with_its_bases() -> None:
    for name, kind in DEFINED.items():
        parent, builtin, _ = _parse_tree()[name]
        drawn = {base for base in (parent, builtin) if base} or {"Exception"}
        assert {base.__name__ for base in kind.__bases__ if base.__name__[0] != "_"} <= drawn, name
        assert drawn <= {base.__name__ for base in kind.__mro__}, name


STATUSES = [
    (name, int(found[1]))
    for name, (*_, meaning) in _parse_tree().items()
    if (found := re.search(r"exit (\d)$", meaning))
]


def test_tree_has_the_exit_status_of_a_branch() -> None:
    for name, status in STATUSES:
        below = [kind for kind in DEFINED.values() if issubclass(kind, DEFINED[name])]
        assert {kind.exit_status for kind in below if issubclass(kind, RobotcoreError)} == {status}, name


def test_interrupted_passes_every_except_exception(check_text: CheckText) -> None:
    assert not issubclass(Interrupted, Exception)
    assert Interrupted(15).exit_status == 143
    check_text(Interrupted(2))


def test_texts_of_errors(check_text: CheckText) -> None:
    check_text(UnknownNameError("app", "gren-search", ["green-search", "mark-green"]))
    check_text(suggestion("zzz", ["b", "a"]))
    check_text(suggestion("zzz", []))
    check_text(DescriptionError("r.toml", "body.mass_kg", "is missing", "Add the key"))
    check_text(DescriptionError("r.toml", "", "is not TOML", "Correct it"))
    check_text(StaleSampleError("nose", 1.25, 1.0))
    check_text(StaleSampleError("nose", -1e9, 1.0))


def test_unknown_name_has_a_kind_of_its_own() -> None:
    error = UnknownNameError("random fault", "gren-search", ["green-search"])
    assert (error.kind, error.name) == ("unknown-random-fault", "gren-search")


def test_description_error_for_several_mistakes_has_a_line_for_each() -> None:
    error = DescriptionError.of_all(
        "r.toml", [Mistake("is missing", "Add it", kind="missing-key", key="a"), Mistake("is 1", "Take 2", key="b")]
    )
    assert (error.key, error.kind, error.others[0].key, error.others[0].kind) == (
        "a",
        "missing-key",
        "b",
        "description",
    )
    assert str(error).splitlines() == ["r.toml: a: is missing. Add it", "r.toml: b: is 1. Take 2"]


def test_group_has_every_failure(check_text: CheckText) -> None:
    failures = [DeviceError("left", "no current"), DeviceError("eye", "no picture")]
    error = DeviceGroupError("closing rover", failures)
    assert error.failures == tuple(failures)
    check_text(error)


def test_exception_of_an_app_is_the_cause(check_text: CheckText) -> None:
    cause = KeyError("speed")
    error = BehaviourError.from_exception(dict, cause)
    assert error.__cause__ is cause
    check_text(error)


def _import_wrong_name() -> None:
    from robotcore import Behavior  # noqa: F401


@pytest.mark.parametrize(
    "fail, name",
    [
        (lambda: robotcore.Status.RUNING, "RUNNING"),  # type: ignore[attr-defined]
        (lambda: robotcore.Role.drive, "DRIVE"),  # type: ignore[attr-defined]
        (lambda: robotcore.Behavior, "Behaviour"),
        (_import_wrong_name, "Behaviour"),
    ],
)
def test_wrong_name_of_an_attribute_has_a_suggestion(fail: Callable[[], object], name: str) -> None:
    with pytest.raises((AttributeError, ImportError)) as raised:
        fail()
    assert str(BehaviourError.from_exception(dict, raised.value)).endswith(f". Did you mean {name!r}?")


class _UnreadableError(Exception):
    def __str__(self) -> str:
        raise ValueError


@pytest.mark.parametrize("cause", [_UnreadableError(), RuntimeError("x" * 20_000_000)])
def test_exception_without_text_or_with_a_huge_text_gives_a_short_error(cause: Exception) -> None:
    error = BehaviourError.from_exception(dict, cause)
    assert len(str(error)) < 2 * MAX_EXCEPTION_TEXT
    assert error.__cause__ is cause


@pytest.mark.parametrize(
    "error",
    [
        UnknownNameError("app", "gren", ["green"]),
        DescriptionError("a.toml", "body", "is missing", "Add it"),
        DeviceError("eye", "no picture"),
        DeviceClosedError("eye"),
        DeviceGroupError("closing rover", [DeviceError("eye", "no picture")]),
        StaleSampleError("nose", 2.0, 1.0),
        Interrupted(signal.SIGTERM),
    ],
    ids=lambda error: type(error).__name__,
)
def test_error_survives_pickling(error: BaseException) -> None:
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301  our own
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert copy.__dict__.keys() == error.__dict__.keys()


class _LineError(DeviceError):
    kind = "line"


class _Unit(Enum):
    VOLT = "V"


def _pickled(error: RobotcoreError) -> RobotcoreError:
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301  our own
    assert isinstance(copy, RobotcoreError)
    return copy


def test_pickled_error_of_another_module_keeps_its_text_kind_and_fields() -> None:
    copy = _pickled(_LineError("cells", "the voltage is too low", kind="line-low", volts=6.2, unit=_Unit.VOLT))
    assert (type(copy), str(copy)) == (DeviceError, "cells: the voltage is too low")
    assert copy.kind == "line-low"
    assert copy.fields == {"volts": 6.2, "unit": "_Unit.VOLT"}


def test_pickled_error_of_another_module_keeps_the_kind_of_its_class() -> None:
    copy = _pickled(_LineError("cells", "does not answer"))
    assert (copy.kind, dict(copy.fields)) == ("line", {})
