"""A button is pressed by a person, in a simulation by a fault."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, RunRequest, Status
from robotcore.kinds import Button
from tests.robotcore.description.files import ROVER

DEVICES = """
[[devices]]
kind = "button"
name = "go"

[[devices]]
kind = "buzzer"
name = "horn"
"""


class Await(Behaviour):
    needs: ClassVar = {Button, "horn"}

    def step(self, robot: Robot) -> Status:
        (button,) = robot.all(Button)
        return Status.SUCCESS if button.read().is_pressed else Status.RUNNING


def test_fault_presses_the_button(tmp_path: Path) -> None:
    file = tmp_path / "buttons.toml"
    file.write_text(
        ROVER + '\n[[devices]]\nkind = "button"\nname = "go"\n\n[[devices]]\nkind = "buzzer"\nname = "horn"\n'
    )
    request = RunRequest(Await, robot=str(file), world="open", timeout_s=2.0)
    assert robotcore.run(request).outcome is Outcome.TIMEOUT
    pressed = RunRequest(Await, robot=str(file), world="open", timeout_s=2.0, faults=("go stuck=1 after=1",))
    result = robotcore.run(pressed)
    assert result.outcome is Outcome.SUCCESS
    assert result.sim_time_s == pytest.approx(1.0)
