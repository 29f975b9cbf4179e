"""A message of a session names the arguments of `robotcore.open`, and not the options of the command line."""

from __future__ import annotations

from inspect import signature

import pytest

import robotcore
from robotcore.cli.run import command
from robotcore.errors import UsageError
from robotcore.interactive.arguments import ARGUMENTS, name_arguments

MESSAGES = {
    "Choose another --backend": "Choose another backend",
    "Use --backend mujoco or pybullet": 'Use backend="mujoco" or pybullet',
    "Leave --gui out, or use --rate 12.5.": "Leave gui=True out, or use rate_hz=12.5.",
    "--rate is 0.1 Hz": "rate_hz is 0.1 Hz",
    "--port /dev/x or --host": 'options={"port": "/dev/x"} or options={"host": …}',
    "--option file=RUN.mcap": 'options={"file": "RUN.mcap"}',
    "End it: robotcore stop, without --backend": "End it: robotcore stop, without --backend",
    "robotcore doctor --robot FILE.toml; or --backend virtualpi": (
        'robotcore doctor --robot FILE.toml; or backend="virtualpi"'
    ),
    "pip install --force-reinstall mujoco": "pip install --force-reinstall mujoco",
}


@pytest.mark.parametrize("message", MESSAGES)
def test_option_becomes_an_argument(message: str) -> None:
    error = UsageError(message, kind="some", value=3)
    assert name_arguments(error) is error
    assert str(error) == MESSAGES[message]
    assert (error.kind, error.fields) == ("some", {"value": 3})


def test_each_argument_exists() -> None:
    parameters = set(signature(robotcore.open).parameters)
    arguments = {name.partition("=")[0] for name in ARGUMENTS.values()} - {"robot.show()"}
    assert arguments <= parameters


def test_each_option_exists() -> None:
    known = {option for parameter in command.params for option in parameter.opts}
    assert {option.partition(" ")[0] for option in ARGUMENTS} <= known
