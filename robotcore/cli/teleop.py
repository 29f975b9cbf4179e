"""``robotcore teleop`` runs the app `teleop`, with which a person drives a robot."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import Any

import click

from robotcore.cli import run
from robotcore.cli.command_classes import RunCommand
from robotcore.cli.options import merge_options
from robotcore.errors import Interrupted, RobotcoreError, UsageError

APP = "teleop"
TIMEOUT_S = 3600.0


class TeleopCommand(RunCommand):
    """The command, whose JSON answer names the app."""

    def build_failure_answer(
        self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted
    ) -> dict[str, Any]:
        return super().build_failure_answer({**parameters, "app": APP}, error)


def _drive(**values: Any) -> Any:
    """Drive a robot by hand: by web page, keys or gamepad.

    With --view, drive from the web page whose link is printed. With --keys, drive by the keys of this terminal. Without
    them, drive by the gamepad in the robot's file. The robot stands until a person drives. A simulator follows real
    time. Ctrl-C ends the run. The other options are those of `robotcore run`.
    """
    if not values["keys"] and values["view"] is None:
        _require_gamepad(values)
    assert run.command.callback
    return run.command.callback(**{**values, "app": APP, "realtime": True})


def _require_gamepad(values: Mapping[str, Any]) -> None:
    from robotcore.hal.backend import load_backend

    options = merge_options(values["options"], host=values["host"], port=values["port"])
    robot = load_backend(values["backend"]).load_robot(values["robot"], options)
    if not robot.first_of("gamepad"):
        raise UsageError(
            f"the robot {robot.name!r} has no gamepad. Add --view to drive from a web page, or --keys to drive by the "
            "keys of the terminal",
            kind="no-way-to-drive",
            robot=robot.name,
        )


def _list_parameters() -> list[click.Parameter]:
    """Return the parameters of `robotcore run` without its app, and with a longer time limit."""
    parameters = [copy(each) for each in run.command.params if each.name != "app"]
    for each in parameters:
        if each.name == "timeout_s":
            each.default = TIMEOUT_S
    return parameters


command = TeleopCommand(APP, params=_list_parameters(), callback=_drive, help=_drive.__doc__)
