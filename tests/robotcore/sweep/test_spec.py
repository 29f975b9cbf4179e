"""Sweeps, seeds and command lines."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest

from robotcore import RunRequest
from robotcore.cli.run import command
from robotcore.errors import UsageError
from robotcore.sweep import Sweep
from robotcore.sweep.spec import format_command, parse_seeds
from tests.texts import Raises

SEARCH = RunRequest("green-search")


@pytest.mark.parametrize(
    "text, seeds",
    [("3", (3,)), ("1-4", (1, 2, 3, 4)), ("1,5,9-11", (1, 5, 9, 10, 11)), (" 2 , 1-3 ", (2, 1, 3)), ("0-0", (0,))],
)
def test_seeds_are_read_from_numbers_and_ranges(text: str, seeds: tuple[int, ...]) -> None:
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize("text", ["", "a", "1-", "-3", "1..4", "1,,2", "1.5", "4-1", "9" * 19])
def test_a_text_that_is_no_seed_is_refused(text: str, raises: Raises) -> None:
    with raises(UsageError, "bad-seed", seeds=text):
        parse_seeds(text)


@pytest.mark.parametrize("text", ["0-9999999999999", "1-600000,1-600000"])
def test_a_range_that_would_fill_the_memory_is_refused(text: str, raises: Raises) -> None:
    with raises(UsageError, "too-many-seeds", seeds=text):
        parse_seeds(text)


def test_each_combination_has_one_request() -> None:
    sweep = Sweep(RunRequest("a", rate_hz=10.0), ("kinematic", "pybullet"), ("open", "arena"), (1, 2))
    requests = list(sweep.requests())
    assert len(requests) == len(set(map(repr, requests))) == len(sweep) == 8
    assert [request.seed for request in requests] == [1] * 4 + [2] * 4
    assert {request.rate_hz for request in requests} == {10.0}


@pytest.mark.parametrize("sweep", [Sweep(SEARCH, ()), Sweep(SEARCH, worlds=()), Sweep(SEARCH, seeds=())])
def test_an_empty_sweep_is_refused(sweep: Sweep, raises: Raises) -> None:
    with raises(UsageError, "empty-sweep"):
        sweep.check()


def test_a_backend_without_worlds_is_refused(raises: Raises) -> None:
    with raises(UsageError, "no-simulator", backend="mock"):
        Sweep(RunRequest("avoid-obstacles"), ("mock",), ("open",)).check()


def test_two_worlds_with_one_name_are_refused(tmp_path: Path, raises: Raises) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('name = "open"\n[floor]\nlength_m = 6.0\nwidth_m = 6.0\n')
    with raises(UsageError, "ambiguous-world-name", name="open", worlds=["open", str(file)]):
        Sweep(RunRequest("avoid-obstacles"), worlds=("open", str(file))).check()


@pytest.mark.parametrize(
    "fields",
    [
        {"backend": "pybullet", "robot": "lookout", "world": "arena", "seed": 0, "rate_hz": 1 / 3, "timeout_s": 7.0},
        {"settings": {"speed_m_s": 0.3, "name": "a b'c"}, "options": {"note": "$HOME; rm"}},
        {"app": "my apps/odd.py:Odd", "gui": True, "realtime": True},
        {"app": "odd.py", "judge": "my apps/judge.py:Strict"},
        {"faults": ("camera drop=0.2 after=5", "loop stall=0.3")},
    ],
)
def test_a_command_can_be_parsed_into_the_same_request(fields: dict[str, Any]) -> None:
    request = RunRequest(**{"app": "green-search", **fields})
    program, run, *arguments = shlex.split(format_command(request))
    assert (program, run) == ("robotcore", "run")
    read = command.make_context("run", arguments).params
    for name in fields:
        got, expected = read[name], getattr(request, name)
        if isinstance(expected, dict):
            assert dict(got) == {key: str(value) for key, value in expected.items()}
        else:
            assert got == expected
