from __future__ import annotations

import shlex
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore import RunRequest
from robotcore.cli.run import command
from robotcore.sweep.command import command_of


def test_only_what_is_not_the_default_is_said() -> None:
    assert command_of(RunRequest("green-search", seed=3)) == "robotcore run green-search --seed 3"


@pytest.mark.parametrize(
    "asked",
    [
        {"backend": "pybullet", "robot": "lookout", "world": "arena", "seed": 0, "rate_hz": 12.5, "timeout_s": 7.0},
        {"settings": {"speed_m_s": 0.3, "name": "a b'c"}, "options": {"note": "$HOME; rm"}},
        {"app": "my apps/odd.py:Odd", "gui": True, "realtime": True},
        {"app": "odd.py", "judge": "my apps/judge.py:Strict"},
        {"faults": ("camera drop=0.2 after=5", "loop stall=0.3")},
    ],
)
def test_the_command_line_reads_back_the_same_request(asked: dict[str, Any]) -> None:
    request = RunRequest(**{"app": "green-search", **asked})
    program, run, *arguments = shlex.split(command_of(request))
    assert (program, run) == ("robotcore", "run")
    read = command.make_context("run", arguments).params
    for name in asked:
        got, expected = read[name], getattr(request, name)
        if isinstance(expected, dict):
            assert dict(got) == {key: str(value) for key, value in expected.items()}
        else:
            assert got == expected


@given(st.floats(min_value=0, exclude_min=True, allow_infinity=False))
def test_a_number_keeps_its_digits(number: float) -> None:
    arguments = shlex.split(command_of(RunRequest("green-search", timeout_s=number)))[2:]
    assert command.make_context("run", arguments).params["timeout_s"] == number
