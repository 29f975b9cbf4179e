"""A light of one colour, or of red, green and blue."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

from robotcore.description import DeviceDescription
from robotcore.geometry import to_float
from robotcore.hal.device import Actuator, build_invalid_command
from robotcore.hal.device_test import IN_OTHER_ORDER, INVERTED, DeviceTest, Question
from robotcore.hal.kind import Kind, assert_limited, assert_refused
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState

__all__ = ["KIND", "Led", "LedDescription"]

Brightness = tuple[float, float, float]
"""The brightness of red, green and blue, each from 0 to 1."""

OFF: Brightness = (0.0, 0.0, 0.0)


class LedDescription(DeviceDescription):
    """A light of one colour, or of red, green and blue.

    >>> LedDescription(kind="led", name="lamp", is_rgb=True)
    LedDescription(kind='led', name='lamp', is_rgb=True)
    """

    kind: Literal["led"]
    is_rgb: bool = False
    """Whether the light has red, green and blue. Otherwise it shows the brightest of the three."""

    def arguments(self) -> dict[str, Any]:
        return {"is_rgb": self.is_rgb}


class Led(Actuator[Brightness], ABC):
    """A light. It is off when a run begins and after it has ended.

    ``is_rgb`` is whether it has red, green and blue.

    >>> from robotcore.hal.kind import build_actuator
    >>> from robotcore.kinds.led import LedDescription
    >>> shown = []
    >>> led = build_actuator(LedDescription(kind="led", name="lamp"), shown.append)
    >>> led.set_brightness(0.5), led.set_colour(2.0, 0.0, 0.0)
    (0.5, (1.0, 0.0, 0.0))
    >>> led.close()
    >>> shown
    [(0.5, 0.5, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    """

    kind = "led"
    safe_command = OFF

    def __init__(self, name: str, *, is_rgb: bool = False) -> None:
        super().__init__(name)
        self.is_rgb = is_rgb

    def set_brightness(self, brightness: float) -> float:
        """Set the brightness, 0 to 1, and return the brightness that was sent.

        Raises InvalidCommandError if it is NaN or infinite, and DeviceError if the light fails.
        """
        return max(self.send((to_float(brightness),) * 3))

    def set_colour(self, red: float, green: float, blue: float) -> Brightness:
        """Set the brightness of each colour, 0 to 1, and return the brightness that was sent.

        Raises InvalidCommandError if one is NaN or infinite, and DeviceError if the light fails.
        """
        return self.send((to_float(red), to_float(green), to_float(blue)))

    def _limit(self, command: Brightness) -> Brightness:
        if not all(map(math.isfinite, command)):
            raise build_invalid_command(self.name, f"the brightness {command}", remedy="Give numbers from 0 to 1")
        red, green, blue = (max(0.0, min(each, 1.0)) for each in command)
        return red, green, blue


def simulate(led: LedDescription, state: SimulationState) -> Callable[[Brightness], None]:
    """Return a function that stores the brightness that a simulated person sees."""
    return partial(state.indicator_commands.__setitem__, led.name)


def check_commands(_robot: Robot, led: Led) -> None:
    """Check that a light refuses a brightness that is not a number, and limits others."""
    assert_refused(led, (math.nan, 0.0, 0.0), (0.0, 0.0, math.inf))
    assert_limited(led, {(2.0, -1.0, 0.5): (1.0, 0.0, 0.5)})


COLOURS = {"r": "red", "g": "green", "b": "blue"}
"""The colours of a light, by what a person types. Their order is that of `Brightness`."""

SHOW_S = 0.3
"""The time after which a light is certainly on, in seconds."""


def test_lights(test: DeviceTest, lights: Sequence[Any]) -> None:
    """Show darkness and each colour, and ask the person what the light shows."""
    for light in lights:
        answer = _ask_colour(test, light, OFF, "off")
        if answer is None:
            test.skip(light.name, "no person has seen it")
            continue
        is_inverted = answer != "n"
        if is_inverted:
            text = "is on when it should be off"
            test.correct(light.name, text, INVERTED, remedy="Check its wires", kind="light-inverted")
        _test_colours(test, light, is_inverted=is_inverted)
        test.robot.devices[light.name].stop()  # type: ignore[attr-defined]  # an actuator


def _test_colours(test: DeviceTest, light: LedDescription, *, is_inverted: bool) -> None:
    shown = list(COLOURS) if light.is_rgb else ["w"]
    seen: list[str | None] = []
    for index, key in enumerate(shown):
        on = [float(index == number or not light.is_rgb) for number in range(3)]
        red, green, blue = (1 - each for each in on) if is_inverted else on
        seen.append(_ask_colour(test, light, (red, green, blue), COLOURS.get(key, "on")))
    dead = [COLOURS.get(key, "light") for key, answer in zip(shown, seen, strict=True) if answer == "n"]
    if None in seen:
        test.skip(light.name, "no person has seen all of its colours")
    elif dead:
        text = f"stays dark: {', '.join(dead)}" if light.is_rgb else "stays dark"
        test.fail(light.name, text, "Check its wires, its resistors and its pins", "light-dead")
    elif not light.is_rgb or seen == shown:
        if not is_inverted:
            test.confirm(light.name, "shows its colours" if light.is_rgb else "lights up")
    elif sorted(str(each) for each in seen) == sorted(shown):
        names = ", ".join(f"{COLOURS[str(b)]} for {COLOURS[a]}" for a, b in zip(shown, seen, strict=True) if a != b)
        # The pin of a colour is that at which this colour was seen.
        order = [seen.index(key) for key in shown]
        remedy = "Correct the pins of its colours"
        test.correct(light.name, f"shows {names}", IN_OTHER_ORDER, order, remedy=remedy, kind="light-order")
    else:
        text = f"shows {', '.join(COLOURS.get(str(each), 'another colour') for each in seen)} for red, green, blue"
        test.fail(light.name, text, "Check its wires", "light-mixed")


def _ask_colour(test: DeviceTest, light: LedDescription, command: Brightness, meant: str) -> str | None:
    """Return the colour that a person sees: r, g, b, w for light without a colour or of another one, n for darkness."""
    device = test.robot.devices[light.name]
    assert isinstance(device, Led)
    test.repeat(partial(device.send, command), SHOW_S)

    def answer(state: SimulationState) -> str:
        shown: Brightness = state.indicator_commands.get(light.name, OFF)
        lit = [key for key, brightness in zip(COLOURS, shown, strict=True) if brightness > 0.5]
        return lit[0] if len(lit) == 1 and light.is_rgb else "w" if lit else "n"

    colours = COLOURS if light.is_rgb else {}
    choices = {**colours, "w": "white or another colour" if light.is_rgb else "on", "n": "dark"}
    text = f"What does {light.name} show now?"
    answered = test.ask(light.name, Question(meant, text, choices, answer))
    return None if answered is None else str(answered)


KIND = Kind(
    "a light of one colour, or of red, green and blue",
    LedDescription,
    Led,
    simulate=simulate,
    rules=(check_commands,),
    is_optional=True,
    test_devices=test_lights,
)
"""The kind `led`, which the entry point of this name refers to."""
