"""A file with any content loads, or raises a UsageError with a line for each mistake."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from copy import deepcopy
from functools import reduce
from importlib import resources
from operator import getitem
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from robotcore.description import RobotDescription, load_any, load_robot, load_world
from robotcore.errors import DescriptionError, UsageError
from robotcore.hal.backend import load_backend

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SHIPPED = resources.files("robotcore.description")
TEXTS = [
    SHIPPED.joinpath(folder, f"{name}.toml").read_text(encoding="utf-8")
    for folder, name in (("robots", "rover"), ("robots", "lookout"), ("worlds", "arena"), ("worlds", "open"))
]
TABLES = [tomllib.loads(text) for text in TEXTS]
QUICK = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def check(tmp_path: Path, content: bytes, load: Callable[[str], object]) -> None:
    file = tmp_path / "fuzzed.toml"
    file.write_bytes(content)
    try:
        load(str(file))
    except UsageError as error:
        others = getattr(error, "others", ())
        assert str(error).count("\n") == len(others)  # noqa: PT017  both ends are right: it loads, or says why not


@pytest.mark.slow
@pytest.mark.parametrize("load", [load_any, load_robot, load_world])
@QUICK
@given(content=st.binary(max_size=200))
def test_random_bytes_load_or_are_refused_with_a_line_for_each_mistake(
    tmp_path: Path, load: Callable[[str], object], content: bytes
) -> None:
    check(tmp_path, content, load)


WORDS = st.text(st.characters(codec="utf-8"), max_size=20) | st.sampled_from(
    ["\x1b]0;x\x07", "\x7f", "\u202e", "x" * 5000]
)
NUMBERS = st.integers(-(10**40), 10**40) | st.floats() | st.sampled_from([10**400, 5e-324, 1e308, -0.0])
ANYTHING = st.recursive(
    WORDS | NUMBERS | st.booleans(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=4),
    max_leaves=6,
)
LIMIT_S = 1.0
"""The limit of the processor time, which does not depend on the load of the machine."""


def find_paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths of all items in a table, as keys and list indices."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*path, key)
        yield from find_paths(item, (*path, key))


@st.composite
def tables(draw: st.DrawFn) -> dict[str, Any]:
    """Return the table of a shipped file in which some values are replaced or some keys are added."""
    table: dict[str, Any] = deepcopy(draw(st.sampled_from(TABLES)))
    for _ in range(draw(st.integers(1, 3))):
        *outer, key = draw(st.sampled_from(list(find_paths(table))))
        around = reduce(getitem, outer, table)
        if isinstance(around, dict) and draw(st.booleans()):
            around[draw(WORDS)] = draw(ANYTHING)
        else:
            around[key] = draw(ANYTHING)
    return table


def format_toml(value: Any) -> str:
    """Return a value as TOML, with inline tables."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {format_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(format_toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value).replace("\x7f", "\\u007f")


@pytest.mark.slow
@pytest.mark.usefixtures("_imported_drivers")
@settings(QUICK, max_examples=200)
@given(table=tables())
@example(table={**TABLES[0], "serial": {**TABLES[0]["serial"], "right_encoder": []}})
def test_description_with_random_values_loads_or_is_refused_in_time(tmp_path: Path, table: dict[str, Any]) -> None:
    file = tmp_path / "fuzzed.toml"
    file.write_text("\n".join(f"{json.dumps(key)} = {format_toml(value)}" for key, value in table.items()))
    begun = os.times().user
    with suppress(DescriptionError):
        load_and_check(str(file))
    assert os.times().user - begun < LIMIT_S


@pytest.fixture(scope="module")
def _imported_drivers() -> None:
    load_and_check("rover")


def load_and_check(name: str) -> None:
    described = load_any(name)
    if isinstance(described, RobotDescription):
        for section in described.backends:
            load_backend(section).check(described)
