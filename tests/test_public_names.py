"""Each public name has a docstring, and each public class and function has an example that `test_examples.py` runs.

An exception may have the example of its base. A constant has a sentence below its assignment.
"""

from __future__ import annotations

import ast
import builtins
import dataclasses
import doctest
import inspect
import re
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from docs.generator.public_names import (
    MODULES,
    find_assignments,
    is_defined_in_robotcore,
    list_public_names,
    parse_module,
)


def find_mistake(module: str, name: str) -> str:
    """Return what a public name lacks; ``""`` if it lacks nothing."""
    value = getattr(import_module(module), name)
    if isinstance(value, ModuleType):
        return "" if value.__doc__ else "a docstring"
    if is_defined_in_robotcore(value) and (
        inspect.isclass(value) or inspect.isroutine(value) or hasattr(value, "__wrapped__")
    ):
        return _find_lack(value)
    return "" if _is_documented(module, name) else "a sentence below its assignment"


def _find_lack(value: Any) -> str:
    own = vars(value).get("__doc__") if inspect.isclass(value) else value.__doc__
    if not own:
        return "a docstring"
    is_exception = inspect.isclass(value) and issubclass(value, BaseException)
    docs = [base.__doc__ for base in value.__mro__ if is_defined_in_robotcore(base)] if is_exception else [own]
    return "" if any(doc and doctest.DocTestParser().get_examples(doc) for doc in docs) else "an example"


def list_undocumented_parameters(value: Any) -> list[str]:
    """Return the parameters of a function, or of a class's own ``__init__``, that the docstring does not name."""
    call: Any = vars(value).get("__init__") if inspect.isclass(value) else value
    if not inspect.isroutine(inspect.unwrap(call)) or getattr(call, "__qualname__", "").startswith("Protocol"):
        return []
    doc = f"{value.__doc__} {call.__doc__ or ''}"
    names = [name for name in inspect.signature(call).parameters if name not in {"self", "args", "kwargs"}]
    return [name for name in names if not re.search(rf"\b{name}\b", doc)]


def list_unknown_names(doc: str, known: str) -> list[str]:
    """Return the names that the examples of a docstring use and neither import nor define.

    known: the name that the docstring documents, which a reader has imported.
    """
    nodes = [node for each in doctest.DocTestParser().get_examples(doc) for node in ast.walk(ast.parse(each.source))]
    bound = {known, "__name__", "__file__", *dir(builtins)}
    for node in nodes:
        match node:
            case ast.Name(id=name, ctx=ast.Store()) | ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                bound.add(name)
            case ast.arg(arg=name) | ast.ExceptHandler(name=str(name)):
                bound.add(name)
            case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
                bound |= {(each.asname or each.name).partition(".")[0] for each in aliases}
    used = [node.id for node in nodes if isinstance(node, ast.Name)]
    return [name for name in dict.fromkeys(used) if name not in bound]


def _is_documented(module: str, name: str) -> bool:
    """Return whether a string follows the assignment of a name, in its module or in the module of its import."""
    if name in (assignments := find_assignments(module)):
        return assignments[name]
    sources = [
        node.module
        for node in ast.walk(parse_module(module))
        if isinstance(node, ast.ImportFrom) and node.module and any(each.name == name for each in node.names)
    ]
    return any(source.startswith("robotcore") and _is_documented(source, name) for source in sources)


@pytest.mark.parametrize("module", MODULES)
def test_each_public_name_has_a_docstring_and_an_example(module: str) -> None:
    assert import_module(module).__doc__
    lacks = {name: find_mistake(module, name) for name in list_public_names(module)}
    assert {name: lack for name, lack in lacks.items() if lack} == {}


@pytest.mark.parametrize("module", MODULES)
def test_docstrings_name_the_parameters(module: str) -> None:
    values = {name: getattr(import_module(module), name) for name in list_public_names(module)}
    called = {
        name: value for name, value in values.items() if is_defined_in_robotcore(value) and not _has_fields(value)
    }
    missing = {name: list_undocumented_parameters(value) for name, value in called.items() if callable(value)}
    assert {name: parameters for name, parameters in missing.items() if parameters} == {}


def _has_fields(value: Any) -> bool:
    """Return whether the fields of a class, which have docstrings of their own, are its parameters."""
    is_record = dataclasses.is_dataclass(value) or hasattr(value, "model_fields")
    return is_record or (inspect.isclass(value) and issubclass(value, (tuple, BaseException)))


@pytest.mark.parametrize("module", MODULES)
def test_examples_import_all_other_names(module: str) -> None:
    values = {name: getattr(import_module(module), name) for name in list_public_names(module)}
    docs = {name: value.__doc__ for name, value in values.items() if is_defined_in_robotcore(value) and value.__doc__}
    unknown = {name: list_unknown_names(doc, name) for name, doc in docs.items()}
    assert {name: names for name, names in unknown.items() if names} == {}


def test_a_name_that_an_example_does_not_import_is_found() -> None:
    lines = ("from math import pi", "def double(x):", "    return pi * x", "double(radius), Motor, print")
    example = "".join(f">>> {line}\n" if line[0] != " " else f"... {line}\n" for line in lines)
    assert list_unknown_names(f"A motor.\n\n{example}", "Motor") == ["radius"]


def test_no_public_example_is_skipped() -> None:
    parts = [getattr(import_module(module), name) for module in MODULES for name in list_public_names(module)]
    examples = [each for part in parts for each in doctest.DocTestParser().get_examples(part.__doc__ or "")]
    assert examples
    assert not [each.source for each in examples if doctest.SKIP in each.options]


def test_each_module_is_on_one_page() -> None:
    assert len(MODULES) == len(set(MODULES))


NEW_NAME = "a_new_module"
NEW_MODULE = '''
"""A module."""

from dataclasses import dataclass
from enum import Enum

LIMIT = 3

SPEED = 0.2
"""The speed in m/s."""


class Wheel:
    """A wheel."""

    def turn(self):
        """Turn.

        >>> Wheel().turn()
        """


class Tyre(Wheel):
    """A tyre.

    >>> Tyre().turn()
    """


class Flat(Exception):
    pass


@dataclass
class Size:
    width: float


class Side(Enum):
    """A side."""

    LEFT = 1


def drive():
    """Drive.

    >>> drive()
    """


def stop():
    """Stop."""


def _brake():
    pass
'''


def test_new_names_without_docstring_or_example_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / f"{NEW_NAME}.py").write_text(NEW_MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(
        f"{__name__}.is_defined_in_robotcore", lambda value: getattr(value, "__module__", "") == NEW_NAME
    )
    lacks = {name: find_mistake(NEW_NAME, name) for name in list_public_names(NEW_NAME)}
    assert {name: lack for name, lack in lacks.items() if lack} == {
        "LIMIT": "a sentence below its assignment",
        "Wheel": "an example",
        "Flat": "a docstring",
        "Size": "an example",
        "Side": "an example",
        "stop": "an example",
    }


def test_a_parameter_that_the_docstring_does_not_name_is_found() -> None:
    def drive(speed: float, turn_rate: float) -> None:
        """Drive.

        speed: the speed in m/s.
        """

    class Wheel:
        """A wheel."""

        def __init__(self, radius: float) -> None:
            self.radius = radius

    assert list_undocumented_parameters(drive) == ["turn_rate"]
    assert list_undocumented_parameters(Wheel) == ["radius"]
