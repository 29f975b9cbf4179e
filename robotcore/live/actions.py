"""The actions of the viewers: the server checks them, and the run executes them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from robotcore.geometry import to_number

if TYPE_CHECKING:  # the process of the page imports this module, and starts faster without the runtime
    from robotcore.runtime.observer import RunContext

PRESS_REASON = "the e-stop was pressed on the live page"

MIN_SPEED, MAX_SPEED = 0.05, 100.0
"""The least and the greatest speed of simulated time that a viewer can choose, in seconds per second."""

MAX_STEPS = 100
MAX_NUMBERS = 8
"""The greatest number of numbers in a command to an actuator."""

MAX_NAME_CHARACTERS = 100


def read_action(message: dict[str, Any]) -> dict[str, Any]:
    """Return the action in a viewer's message, with checked values. Raises ValueError for any other message.

    ``sent`` of a command that moves something is the time on the viewer's clock, in ms.
    """
    match message:
        case {"type": "drive", "linear": linear, "angular": angular, "sent": sent}:
            ratios = {"linear": _read_ratio(linear), "angular": _read_ratio(angular)}
            return {"type": "drive", **ratios, "sent": _read_number(sent)}
        case {"type": "actuate", "device": str(device), "value": [*numbers], "sent": sent} if (
            len(device) <= MAX_NAME_CHARACTERS and 0 < len(numbers) <= MAX_NUMBERS
        ):
            values = [_read_number(each) for each in numbers]
            return {"type": "actuate", "device": device, "value": values, "sent": _read_number(sent)}
        case {"type": "pace", "speed": speed} if speed is None or MIN_SPEED <= _read_number(speed) <= MAX_SPEED:
            return {"type": "pace", "speed": speed}
        case {"type": "pace", "is_paused": bool(is_paused)}:
            return {"type": "pace", "is_paused": is_paused}
        case {"type": "pace", "steps": int(steps)} if 0 < steps <= MAX_STEPS:
            return {"type": "pace", "steps": int(steps)}
        case {"type": "release"}:
            return {"type": "release"}
    raise ValueError("not an action of the page")


def execute_action(run: RunContext, action: dict[str, Any]) -> None:
    """Execute an action that `read_action` returned, or a press of the e-stop.

    Raises the errors of `OperatorInput` and of `PaceControl` for an action that the run refuses.
    """
    match action:
        case {"type": "estop"}:
            run.emergency.press(PRESS_REASON)
        case {"type": "drive", "linear": linear, "angular": angular} if run.operator:
            drive = run.robot.drive
            run.operator.drive(linear * drive.max_linear, angular * drive.max_angular)
        case {"type": "actuate", "device": device, "value": value} if run.operator:
            run.operator.command(device, value)
        case {"type": "release"} if run.operator:
            run.operator.release()
        case {"type": "pace", "speed": speed} if run.pace:
            run.pace.speed = math.inf if speed is None else speed
        case {"type": "pace", "is_paused": is_paused} if run.pace:
            (run.pace.pause if is_paused else run.pace.resume)()
        case {"type": "pace", "steps": steps} if run.pace and run.pace.is_paused:
            run.pace.step(steps)


def _read_number(value: object) -> float:
    if not math.isfinite(number := to_number(value)):
        raise ValueError("not a finite number")
    return number


def _read_ratio(value: object) -> float:
    """Return the ratio of a velocity to the greatest one, from -1 to 1."""
    if abs(share := _read_number(value)) > 1:
        raise ValueError("not from -1 to 1")
    return share
