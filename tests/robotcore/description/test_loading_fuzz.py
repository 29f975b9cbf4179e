"""Whatever is in a file: it loads, or is refused with a UsageError in a line for each fault."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robotcore.description import load_any, load_robot, load_world
from robotcore.errors import UsageError

SHIPPED = resources.files("robotcore.description")
TEXTS = [
    SHIPPED.joinpath(folder, f"{name}.toml").read_text(encoding="utf-8")
    for folder, name in (("robots", "rover"), ("robots", "lookout"), ("worlds", "arena"), ("worlds", "open"))
]
VALUES = [
    "0", "-1", "1e308", "-1e308", "1e-320", "nan", "inf", "true", '""', '"x"', "[]", "[1]", "{}", "[[1], {}]",
    "1979-05-27", "'''a\nb'''", "9" * 400, '"\\u0000"', "[0, 0]", "[3, 1]", "{ x_m = 1, z_m = 2 }", '"\\n"',
]  # fmt: skip
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


@st.composite
def mutations(draw: st.DrawFn) -> str:
    """Return a shipped description with some lines taken out, doubled, moved or given another value."""
    lines = draw(st.sampled_from(TEXTS)).splitlines()
    for _ in range(draw(st.integers(1, 4))):
        index = draw(st.integers(0, len(lines) - 1))
        change = draw(st.sampled_from(["delete", "double", "move", "value", "key"]))
        key, _, value = lines[index].partition("=")
        if change == "delete":
            del lines[index]
        elif change == "double":
            lines.insert(draw(st.integers(0, len(lines))), lines[index])
        elif change == "move":
            lines.insert(draw(st.integers(0, len(lines) - 1)), lines.pop(index))
        elif change == "value" and value:
            lines[index] = f"{key}= {draw(st.sampled_from(VALUES))}"
        elif change == "key" and value:
            lines[index] = f"{draw(st.sampled_from(['x_m', 'kind', 'name', 'body', chr(34) * 2]))} ={value}"
    return "\n".join(lines)


@pytest.mark.parametrize("load", [load_any, load_robot, load_world])
@QUICK
@given(content=st.binary(max_size=200))
def test_any_bytes_load_or_are_refused_in_a_line_a_fault(
    tmp_path: Path, load: Callable[[str], object], content: bytes
) -> None:
    check(tmp_path, content, load)


@pytest.mark.parametrize("load", [load_any, load_robot, load_world])
@QUICK
@given(text=mutations())
def test_a_mangled_description_loads_or_is_refused_in_a_line_a_fault(
    tmp_path: Path, load: Callable[[str], object], text: str
) -> None:
    check(tmp_path, text.encode(), load)
