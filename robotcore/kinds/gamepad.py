"""A gamepad, with which a person drives a robot."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from robotcore.description import DeviceDescription
from robotcore.description.types import StrictModel
from robotcore.errors import Mistake
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState

__all__ = ["KIND", "Gamepad", "GamepadDescription", "GamepadSample", "ScriptedInput"]

AXES = ("left_x", "left_y", "right_x", "right_y")
"""The axes of the sticks, from -1 to 1."""

TRIGGERS = ("left_trigger", "right_trigger")
"""The triggers, from 0 to 1."""

LEAST = dict.fromkeys(AXES, -1.0) | dict.fromkeys(TRIGGERS, 0.0)
"""The least value of each axis and trigger. The greatest is 1."""

Axis = Annotated[float, Field(ge=-1, le=1)]
Trigger = Annotated[float, Field(ge=0, le=1)]
Number = Annotated[float, Unit("")]
Flag = Annotated[bool, Unit("")]


class ScriptedInput(StrictModel):
    """The input of a simulated gamepad from a time on. An axis that is left out is 0, and a button is released.

    >>> ScriptedInput(at_s=0.5, left_y=1.0, south=True).model_dump(exclude_defaults=True)
    {'at_s': 0.5, 'left_y': 1.0, 'south': True}
    """

    at_s: Annotated[float, Field(ge=0, le=1e6)]
    """The time since the start of the run, in seconds."""
    left_x: Axis = 0.0
    left_y: Axis = 0.0
    right_x: Axis = 0.0
    right_y: Axis = 0.0
    left_trigger: Trigger = 0.0
    right_trigger: Trigger = 0.0
    south: bool = False
    east: bool = False
    north: bool = False
    west: bool = False
    left_shoulder: bool = False
    right_shoulder: bool = False
    left_stick: bool = False
    right_stick: bool = False
    select: bool = False
    start: bool = False
    mode: bool = False
    dpad_up: bool = False
    dpad_down: bool = False
    dpad_left: bool = False
    dpad_right: bool = False


class GamepadDescription(DeviceDescription):
    """A gamepad. The script is the input of a simulated one.

    >>> script = [{"at_s": 0.5, "left_y": 1.0}, {"at_s": 2.5, "south": True}]
    >>> [entry.at_s for entry in GamepadDescription(kind="gamepad", name="pad", script=script).script]
    [0.5, 2.5]
    """

    kind: Literal["gamepad"]
    script: tuple[ScriptedInput, ...] = ()
    """The input of a simulated gamepad. Each entry holds until the time of the next one."""

    @model_validator(mode="after")
    def _require_order(self) -> GamepadDescription:
        times = [entry.at_s for entry in self.script]
        for before, after in pairwise(times):
            if before >= after:
                problem = f"script: at_s is {after:g} in the entry after that of {before:g}"
                raise Mistake(problem, "Sort the entries by at_s, each with another time", kind="script-order")
        return self


@dataclass(frozen=True, slots=True)
class GamepadSample:
    """A sample of a gamepad. The buttons are named by their place, because each maker prints other signs on them.

    >>> from dataclasses import fields
    >>> at_rest = dict.fromkeys((field.name for field in fields(GamepadSample)), False)
    >>> GamepadSample(**{**at_rest, "left_y": 0.5, "south": True, "time": 1.25, "sequence": 25})
    GamepadSample left_y 0.50, south at 1.25 s
    """

    left_x: Number
    """The left stick, from -1 to 1, positive to the right."""
    left_y: Number
    """The left stick, from -1 to 1, positive away from the person."""
    right_x: Number
    """The right stick, from -1 to 1, positive to the right."""
    right_y: Number
    """The right stick, from -1 to 1, positive away from the person."""
    left_trigger: Number
    """The left trigger, from 0 to 1."""
    right_trigger: Number
    """The right trigger, from 0 to 1."""
    south: Flag
    """The lowest of the four buttons on the right: A, or a cross."""
    east: Flag
    """The right one of the four buttons: B, or a circle."""
    north: Flag
    """The highest of the four buttons: Y, or a triangle."""
    west: Flag
    """The left one of the four buttons: X, or a square."""
    left_shoulder: Flag
    """The button above the left trigger."""
    right_shoulder: Flag
    """The button above the right trigger."""
    left_stick: Flag
    """Whether the left stick is pressed."""
    right_stick: Flag
    """Whether the right stick is pressed."""
    select: Flag
    """The left button in the middle."""
    start: Flag
    """The right button in the middle."""
    mode: Flag
    """The button with the maker's sign."""
    dpad_up: Flag
    """Whether the directional pad is pressed up, away from the person."""
    dpad_down: Flag
    """Whether the directional pad is pressed down, towards the person."""
    dpad_left: Flag
    """Whether the directional pad is pressed to the left."""
    dpad_right: Flag
    """Whether the directional pad is pressed to the right."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""

    def format_values(self) -> str:
        """Return the axes that are not 0, and the names of the pressed buttons."""
        values = {name: value for name, value in asdict(self).items() if value and name not in ("time", "sequence")}
        texts = (name if value is True else f"{name} {value:.2f}" for name, value in values.items())
        return ", ".join(texts) or "at rest"


BUTTONS = tuple(each.name for each in fields(GamepadSample) if each.name not in (*AXES, *TRIGGERS, "time", "sequence"))


class Gamepad(Sensor[GamepadSample]):
    """A gamepad, with which a person drives a robot.

    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.gamepad import AXES, BUTTONS, TRIGGERS, GamepadDescription, GamepadSample
    >>> values = {**dict.fromkeys((*AXES, *TRIGGERS), 0.0), **dict.fromkeys(BUTTONS, False), "left_y": 0.5}
    >>> pad = build_sensor(
    ...     GamepadDescription(kind="gamepad", name="pad"), lambda: GamepadSample(**values, time=0.0, sequence=0)
    ... )
    >>> pad.read().left_y, pad.format_sample(pad.read())
    (0.5, 'left_y 0.50')
    """

    kind = "gamepad"

    def limit_sample(self, sample: GamepadSample) -> GamepadSample:
        limited = {name: max(least, min(getattr(sample, name), 1.0)) for name, least in LEAST.items()}
        return replace(sample, **limited)


def simulate(gamepad: GamepadDescription, _state: SimulationState) -> Callable[[float, int], GamepadSample]:
    """Return a function that takes a sample: the entry of the script for the present time."""
    times = [entry.at_s for entry in gamepad.script]
    inputs = [_list_values(entry) for entry in (ScriptedInput(at_s=0.0), *gamepad.script)]
    return lambda time, sequence: GamepadSample(**inputs[bisect_right(times, time)], time=time, sequence=sequence)


def _list_values(entry: ScriptedInput) -> dict[str, Any]:
    return entry.model_dump(exclude={"at_s"})


def _find_invalid_axis(sample: GamepadSample) -> str:
    """Return the name of the first axis or trigger out of its limits; ``""`` if there is none."""
    return next((name for name, least in LEAST.items() if not least <= getattr(sample, name) <= 1.0), "")


def validate_sample(_gamepad: GamepadDescription, sample: GamepadSample) -> GamepadSample:
    """Return a scripted sample. Raises ValueError if an axis or a trigger is out of its limits."""
    if _find_invalid_axis(sample):
        raise ValueError("a mapping with axes from -1 to 1 and triggers from 0 to 1")
    return sample


def check_limits(_robot: Robot, gamepad: Gamepad) -> None:
    """Check that the axes are from -1 to 1, and the triggers from 0 to 1."""
    sample = gamepad.read()
    invalid = _find_invalid_axis(sample)
    assert not invalid, (
        f"{gamepad.name} returned {invalid} = {getattr(sample, invalid)}. Return axes from -1 to 1, and triggers "
        "from 0 to 1"
    )


KIND = Kind(
    "a gamepad, with which a person drives",
    GamepadDescription,
    Gamepad,
    GamepadSample,
    simulate,
    rules=(check_limits,),
    validate_sample=validate_sample,
)
"""The kind `gamepad`, which the entry point of this name refers to."""
