from __future__ import annotations

import json
import subprocess
from typing import Any

from tests.system.guest.bench import EDGES_A_SECOND, MOTOR_LINES, TOUR, run_command
from tests.system.guest.chip import Chip
from tests.system.guest.models import Disc, Wheels, echo_module


def run_app(command: list[str]) -> dict[str, Any]:
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.stdout, run.stderr
    result = json.loads(run.stdout)
    assert isinstance(result, dict)
    return result


def outputs(chip: Chip) -> list[int]:
    """Return the levels of both motors' lines."""
    return [chip.level(gpio) for lines in MOTOR_LINES.values() for gpio in lines]


def wheels(chip: Chip) -> Wheels:
    discs = {MOTOR_LINES["left"][0]: Disc(chip, 5, 6), MOTOR_LINES["right"][0]: Disc(chip, 20, 21)}
    return Wheels(chip, discs, EDGES_A_SECOND)


def test_an_app_with_motors_encoders_sonar_and_camera_succeeds_and_leaves_every_line_low(chip: Chip) -> None:
    with echo_module(chip, 1.0), wheels(chip):
        result = run_app(run_command(TOUR, "bench"))
    assert (result["outcome"], result["exit_status"]) == ("success", 0), result["reason"]
    assert outputs(chip) == [0, 0, 0, 0]


def test_a_wheel_that_does_not_turn_stops_the_run_and_every_motor(chip: Chip) -> None:
    with echo_module(chip, 1.0):
        result = run_app(run_command(TOUR, "bench"))
    assert (result["outcome"], result["exit_status"]) == ("stopped", 4), result["reason"]
    assert "left_motor" in result["reason"]
    assert outputs(chip) == [0, 0, 0, 0]
