"""Files and numbers that are too large are refused quickly."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from robotcore.description import load_any, load_world
from robotcore.description.loading import MAX_DOTS, MAX_ENTRIES, MAX_FILE_BYTES, read_table
from robotcore.description.validation import MAX_FILE_ERRORS
from robotcore.errors import UsageError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.faults.spec import MAX_INJECTED_FAULTS, read_specs
from tests.robotcore.description.files import ARENA, ROVER, find_errors, replace
from tests.texts import CheckText, Raises

SOON_S = 10.0
"""The time limit of a test on a busy machine, in seconds. Without the limits of the code, each test takes minutes."""

BALL = '[[targets]]\nname = "b{0}"\nradius_m = 0.01\ncolour = "red"\nx_m = {1}\ny_m = {2}\n'
OPEN = 'name = "big"\n[floor]\nlength_m = 90\nwidth_m = 90\n[start]\nx_m = -40\n'


def test_file_that_is_too_large_is_not_read(tmp_path: Path, raises: Raises) -> None:
    file = tmp_path / "sparse.toml"
    file.touch()
    os.truncate(file, 30 * 2**30)
    with raises(UsageError, "file-too-large", bytes=30 * 2**30, limit=MAX_FILE_BYTES):
        load_any(str(file))


@pytest.mark.parametrize(
    "content, key",
    [
        (ROVER + '[[devices]]\nkind="display"\n' * MAX_ENTRIES, "devices"),
        (ROVER + "".join(f"[z{number}]\n" for number in range(MAX_ENTRIES + 1)), ""),
    ],
    ids=["list", "file"],
)
def test_too_long_list_is_reported_by_its_key(tmp_path: Path, check_text: CheckText, content: str, key: str) -> None:
    (error,) = find_errors(tmp_path, content)
    assert (error.key, error.kind) == (key, "too-many-entries")
    check_text(error)


LONG_KEY = ".".join("a" * 5_000)


@pytest.mark.parametrize(
    "content",
    [
        f"{LONG_KEY} = 1",
        f"[{LONG_KEY}]",
        LONG_KEY.replace(".", " . ") + " = 1",
        LONG_KEY.replace("a", '"."') + " = 1",
    ],
    ids=["key", "table", "spaces", "quotes"],
)
def test_key_of_many_dots_is_not_parsed(tmp_path: Path, content: str) -> None:
    clock = MonotonicClock()
    (error,) = find_errors(tmp_path, content)
    assert clock.now() < SOON_S / 10
    assert error.kind == "too-many-dots"


def test_dots_in_strings_comments_and_numbers_are_not_counted(tmp_path: Path) -> None:
    dots = "a." * (MAX_DOTS + 1)
    numbers = "0.1, " * (MAX_DOTS + 1)
    file = tmp_path / "my.toml"
    strings = f"one = '{dots}'\ntwo = \"{dots}\" # {dots}\nthree = '''\n{dots}'''\n"
    file.write_text(f"# {dots}\n{strings}four = [{numbers}]\n")
    assert read_table(str(file)).keys() == {"one", "two", "three", "four"}


@pytest.mark.parametrize(
    "text",
    ["x" * 2**19, '\\"' * 2**18, "a" + " " * 2**19, "x='''" + "''a" * 2**17],
    ids=["letters", "escapes", "spaces", "string"],
)
def test_search_for_long_keys_is_quick_in_a_file_that_is_not_toml(tmp_path: Path, text: str) -> None:
    clock = MonotonicClock()
    assert find_errors(tmp_path, text)[0].kind == "not-toml"
    assert clock.now() < SOON_S


def test_file_that_takes_all_memory_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(text: str) -> None:
        raise MemoryError(text)

    monkeypatch.setattr("robotcore.description.loading.tomllib.loads", refuse)
    assert find_errors(tmp_path, "x = 1")[0].kind == "nested-too-deep"


def test_largest_world_is_checked_quickly(tmp_path: Path) -> None:
    clock, file = MonotonicClock(), tmp_path / "my.toml"
    balls = (BALL.format(number, number % 32 * 0.1, number // 32 * 0.1) for number in range(MAX_ENTRIES))
    file.write_text(OPEN + "".join(balls))
    assert len(load_world(str(file)).targets) == MAX_ENTRIES
    assert clock.now() < SOON_S


def test_only_the_first_errors_are_reported(tmp_path: Path) -> None:
    clock = MonotonicClock()
    found = find_errors(tmp_path, OPEN + "".join(BALL.format(number, 0, 0) for number in range(MAX_ENTRIES)))
    assert clock.now() < SOON_S
    assert len(found) == MAX_FILE_ERRORS + 1
    assert found[-1].kind == "too-many-mistakes"


def test_number_of_injected_faults_is_limited(tmp_path: Path) -> None:
    file = tmp_path / "faults.toml"
    file.write_text('[[fault]]\ntarget = "camera"\neffect = "drop"\nvalue = 0.2\n' * (MAX_INJECTED_FAULTS + 1))
    with pytest.raises(UsageError):
        read_specs([str(file)])
    assert len(read_specs(["camera drop=0.2"] * MAX_INJECTED_FAULTS)) == MAX_INJECTED_FAULTS


def test_long_texts_of_a_file_are_cut_in_messages(tmp_path: Path) -> None:
    for content in (
        replace(ROVER, 'name = "rover"', f'name = "{"x" * 100_000}"'),
        replace(ROVER, 'kind = "camera"', f'kind = "{"x" * 100_000}"'),
        f"{'x' * 100_000} = 1\n{ROVER}",
        replace(ARENA, 'colour = "green"', f'colour = "{"x" * 100_000}"'),
        f"{'x' * 100_000}",
    ):
        assert all(len(str(error)) < 1000 for error in find_errors(tmp_path, content))
