from __future__ import annotations

import inspect
import pickle
import re
import signal

import pytest

from robotcore import errors
from robotcore.errors import (
    MAX_EXCEPTION_TEXT,
    BehaviourError,
    DescriptionError,
    DeviceClosedError,
    DeviceError,
    DeviceGroupError,
    Interrupted,
    RobotcoreError,
    StaleSampleError,
    UnknownNameError,
    suggestion,
)

BRANCH = re.compile(r"^ *(?P<stem>[│├└─ ]*)(?P<name>\w+)(?: \((?P<builtin>\w+)\))? *(?P<meaning>.*)$")
DEFINED = {
    name: kind
    for name, kind in vars(errors).items()
    if inspect.isclass(kind)
    and issubclass(kind, BaseException)
    and kind.__module__ == errors.__name__
    and name[0] != "_"
}


def _drawn() -> dict[str, tuple[str | None, str | None, str]]:
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
    assert set(_drawn()) == set(DEFINED)


@pytest.mark.parametrize("name", DEFINED)
def test_the_tree_draws_each_error_with_its_bases(name: str) -> None:
    parent, builtin, _ = _drawn()[name]
    drawn = {base for base in (parent, builtin) if base} or {"Exception"}
    assert {base.__name__ for base in DEFINED[name].__bases__ if base.__name__[0] != "_"} <= drawn
    assert drawn <= {base.__name__ for base in DEFINED[name].__mro__}


TOLD = [
    (name, int(found[1])) for name, (*_, valuess) in _drawn().items() if (found := re.search(r"exit (\d)$", valuess))
]


@pytest.mark.parametrize("name, status", TOLD)
def test_the_tree_tells_the_exit_status_of_a_branch(name: str, status: int) -> None:
    below = [kind for kind in DEFINED.values() if issubclass(kind, DEFINED[name])]
    assert {kind.exit_status for kind in below if issubclass(kind, RobotcoreError)} == {status}


def test_interrupted_passes_every_except_exception() -> None:
    assert not issubclass(Interrupted, Exception)
    assert Interrupted(15).exit_status == 143
    assert str(Interrupted(2)) == "interrupted by SIGINT"


def test_an_unknown_name_is_answered_by_the_nearest() -> None:
    assert str(UnknownNameError("app", "gren-search", ["green-search", "mark-green"])) == (
        "unknown app 'gren-search'. Did you mean 'green-search'?"
    )


def test_where_nothing_is_near_all_are_listed() -> None:
    assert suggestion("zzz", ["b", "a"]) == "There are: a, b."
    assert suggestion("zzz", []) == "There are: none."


def test_a_description_error_says_file_key_fault_and_remedy() -> None:
    error = DescriptionError("r.toml", "body.mass_kg", "is missing", "Add the key")
    assert str(error) == "r.toml: body.mass_kg: is missing. Add the key"
    assert str(DescriptionError("r.toml", "", "is no TOML", "Mend it")) == "r.toml: is no TOML. Mend it"


def test_a_group_tells_every_failure_by_name() -> None:
    failures = [DeviceError("left", "no current"), DeviceError("eye", "no picture")]
    error = DeviceGroupError("closing rover", failures)
    assert str(error) == "closing rover: 2 device(s) failed\n  - left: no current\n  - eye: no picture"
    assert error.failures == tuple(failures)


def test_a_stale_sample_says_how_old_and_how_old_it_may_be() -> None:
    assert str(StaleSampleError("nose", 1.25, 1.0)).startswith(
        "nose: the newest sample is 1.250 s old, the limit is 1.000 s"
    )


def test_what_an_app_raised_keeps_its_traceback() -> None:
    cause = KeyError("speed")
    error = BehaviourError.raised_by(dict, cause)
    assert str(error) == "dict raised KeyError: 'speed'"
    assert error.__cause__ is cause


class _UnreadableError(Exception):
    def __str__(self) -> str:
        raise ValueError


@pytest.mark.parametrize("cause", [_UnreadableError(), RuntimeError("x" * 20_000_000)])
def test_an_app_whose_exception_has_no_text_or_endless_text_gives_a_short_error(cause: Exception) -> None:
    error = BehaviourError.raised_by(dict, cause)
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
def test_another_process_can_be_reported_of_it(error: BaseException) -> None:
    valuess = pickle.loads(pickle.dumps(error))  # noqa: S301  our own
    assert type(valuess) is type(error)
    assert str(valuess) == str(error)
    assert valuess.__dict__.keys() == error.__dict__.keys()
