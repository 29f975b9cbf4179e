"""A buzzer, which plays tones."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Sequence
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import Field

from robotcore.description import DeviceDescription
from robotcore.geometry import to_float
from robotcore.hal.device import Actuator, build_invalid_command
from robotcore.hal.device_test import YES_OR_NO, DeviceTest, Question
from robotcore.hal.kind import Kind, assert_limited, assert_refused
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState

__all__ = ["KIND", "Buzzer", "BuzzerDescription"]

SILENCE = 0.0
"""The frequency of no tone, in Hz."""

MIN_FREQUENCY_HZ = 20.0
"""The frequency of the lowest tone that a person hears, in Hz."""


class BuzzerDescription(DeviceDescription):
    """A buzzer, which plays tones.

    >>> BuzzerDescription(kind="buzzer", name="horn", max_frequency_hz=4000.0)
    BuzzerDescription(kind='buzzer', name='horn', max_frequency_hz=4000.0)
    """

    kind: Literal["buzzer"]
    max_frequency_hz: Annotated[float, Field(ge=MIN_FREQUENCY_HZ, le=20_000)] = 5000.0
    """The frequency of the highest tone, in Hz."""

    def arguments(self) -> dict[str, Any]:
        return {"max_frequency": self.max_frequency_hz}


class Buzzer(Actuator[float], ABC):
    """A buzzer. It is silent when a run begins and after it has ended.

    ``max_frequency`` is the frequency of the highest tone, in Hz.

    >>> from robotcore.hal.kind import build_actuator
    >>> from robotcore.kinds.buzzer import BuzzerDescription
    >>> played = []
    >>> buzzer = build_actuator(BuzzerDescription(kind="buzzer", name="horn"), played.append)
    >>> buzzer.play(440.0), buzzer.play(90_000.0)
    (440.0, 5000.0)
    >>> buzzer.stop()
    >>> played
    [440.0, 5000.0, 0.0]
    """

    kind = "buzzer"
    command_unit = "Hz"
    safe_command = SILENCE

    def __init__(self, name: str, *, max_frequency: float) -> None:
        super().__init__(name)
        self.max_frequency = max_frequency

    def play(self, frequency: float) -> float:
        """Play a tone until the next command, and return the frequency that was sent, in Hz.

        A frequency of 0 is silence. Others are limited to `MIN_FREQUENCY_HZ` and ``max_frequency``.

        Raises InvalidCommandError if it is negative, NaN or infinite, and DeviceError if the buzzer fails.
        """
        return self.send(to_float(frequency))

    def _limit(self, command: float) -> float:
        if not (math.isfinite(command) and command >= 0):
            remedy = "Give 0 for silence, or a frequency"
            raise build_invalid_command(self.name, f"a tone of {command} Hz", remedy=remedy)
        return SILENCE if command == SILENCE else max(MIN_FREQUENCY_HZ, min(command, self.max_frequency))


def simulate(buzzer: BuzzerDescription, state: SimulationState) -> Callable[[float], None]:
    """Return a function that stores the frequency of the tone that the buzzer plays, in Hz."""
    return partial(state.indicator_commands.__setitem__, buzzer.name)


def check_commands(_robot: Robot, buzzer: Buzzer) -> None:
    """Check that a buzzer refuses a frequency without a meaning, and limits others."""
    assert_refused(buzzer, math.nan, math.inf, -1.0)
    limits = {1.0: MIN_FREQUENCY_HZ, 2 * buzzer.max_frequency: buzzer.max_frequency, SILENCE: SILENCE}
    assert_limited(buzzer, limits)


TONE_HZ, TONE_S = 880.0, 0.5
"""The tone that a test plays, and its duration in seconds."""


def test_buzzers(test: DeviceTest, buzzers: Sequence[Any]) -> None:
    """Play a tone, and ask the person whether it sounds."""
    for buzzer in buzzers:
        device = test.robot.devices[buzzer.name]
        assert isinstance(device, Buzzer)
        test.repeat(partial(device.play, TONE_HZ), TONE_S)
        heard = Question("tone", f"Does {buzzer.name} play a tone now?", YES_OR_NO, partial(_hear, buzzer.name))
        answer = test.ask(buzzer.name, heard)
        device.stop()
        if answer == "y":
            test.confirm(buzzer.name, f"plays a tone of {TONE_HZ:g} Hz")
        elif answer == "n":
            test.fail(buzzer.name, "plays no tone", "Check its wires and its pin", "buzzer-dead")
        else:
            test.skip(buzzer.name, "no person has heard it")


def _hear(name: str, state: SimulationState) -> str:
    return "y" if state.indicator_commands.get(name, SILENCE) > SILENCE else "n"


KIND = Kind(
    "a buzzer, which plays tones",
    BuzzerDescription,
    Buzzer,
    simulate=simulate,
    rules=(check_commands,),
    is_optional=True,
    test_devices=test_buzzers,
)
"""The kind `buzzer`, which the entry point of this name refers to."""
