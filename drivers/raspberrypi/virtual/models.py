"""Models of hardware on the other end of virtual pins: encoder discs, an ultrasonic module, motor boards."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial

from drivers.raspberrypi.virtual.pins import VirtualPin
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Encoder, Motor, RangeSensor

QUADRATURE = ((1, 1), (0, 1), (0, 0), (1, 0))
"""The levels of a and b, one edge after the other; forward, a leads."""


class Disc(ABC):
    """Turns with a wheel, and gives an edge each time that ``radians`` have passed."""

    def __init__(self, encoder: Encoder, radians: float) -> None:
        self._encoder, self._radians = encoder, radians
        self._at = 0

    def turn(self) -> None:
        """Give the edges that have passed since the last turn."""
        to = round(self._encoder.read().angle / self._radians)
        step = 1 if to > self._at else -1
        while self._at != to:
            self._at += step
            self._show(self._at)

    @abstractmethod
    def _show(self, edge: int) -> None:
        """Set the channels to what they are after so many edges; backward they are counted down."""


class QuadratureDisc(Disc):
    """Two channels, a quarter of a cycle apart: they tell the direction."""

    def __init__(self, encoder: Encoder, radians: float, a: VirtualPin, b: VirtualPin) -> None:
        super().__init__(encoder, radians)
        self._a, self._b = a, b
        self._show(0)

    def _show(self, edge: int) -> None:
        a, b = QUADRATURE[edge % len(QUADRATURE)]
        self._a.drive(a)
        self._b.drive(b)


class SlottedDisc(Disc):
    """One channel, which goes up and down whatever the direction."""

    def __init__(self, encoder: Encoder, radians: float, pin: VirtualPin) -> None:
        super().__init__(encoder, radians)
        self._pin = pin
        self._show(0)

    def _show(self, edge: int) -> None:
        self._pin.drive(edge % 2)


BURST_S = 450e-6
"""From the end of the trigger to the rise of the echo: the burst is sent, eight cycles at 40 kHz, and some more."""
SILENCE_S = 38e-3
"""The pulse of an HC-SR04 that heard nothing. Source: its data sheet."""


class VirtualEcho:
    """Answers each trigger by what the simulator's ``sensor`` hears at that instant.

    An echo that ``is_lost``, as one that glances off, is silence to the module. Edges come in the step after they are
    due, and tell when they were.
    """

    def __init__(
        self,
        clock: Clock,
        sensor: RangeSensor,
        trigger: VirtualPin,
        echo: VirtualPin,
        speed_of_sound: float,
        is_lost: Callable[[], bool],
    ) -> None:
        self._clock, self._sensor = clock, sensor
        self._trigger, self._echo = trigger, echo
        self._speed, self._is_lost = speed_of_sound, is_lost
        self._is_busy = False
        echo.drive(0)
        trigger.on_change(self._on_trigger)

    def _on_trigger(self) -> None:
        if not (self._trigger.state or self._is_busy):
            self._is_busy = True
            self._send()

    def _send(self) -> None:
        rises = self._clock.now() + BURST_S
        distance = math.inf if self._is_lost() else self._sensor.read().distance
        falls = rises + (SILENCE_S if math.isinf(distance) else 2 * distance / self._speed)
        self._call_at(rises, partial(self._echo.drive, 1, rises))
        self._call_at(falls, partial(self._end, falls))

    def _end(self, at: float) -> None:
        self._is_busy = False
        self._echo.drive(0, at)

    def _call_at(self, at: float, edge: Callable[[], None]) -> None:
        if self._clock.now() == 0:  # the robot is being opened: no time can pass, and drivers want a first sample
            edge()
        else:
            self._clock.call_at(at, edge)


Velocity = Callable[[float], float]
"""What a motor turns at, in rad/s, at a duty from -1 to 1."""


def wire_two_inputs(
    motor: Motor, velocity: Velocity, forward: VirtualPin, backward: VirtualPin, enable: VirtualPin | None = None
) -> None:
    """Put an H-bridge on an input for each direction, both alike brake, and perhaps one that lets it work."""

    def duty() -> float:
        return float(forward.state) - float(backward.state) if enable is None or enable.state else 0.0

    _turn_on_change(duty, motor, velocity, *(pin for pin in (forward, backward, enable) if pin is not None))


def wire_phase_and_enable(motor: Motor, velocity: Velocity, phase: VirtualPin, enable: VirtualPin) -> None:
    """Put an H-bridge on an input for the duty, and one that is high to go backward."""
    _turn_on_change(lambda: float(-enable.state if phase.state else enable.state), motor, velocity, phase, enable)


def _turn_on_change(duty: Callable[[], float], motor: Motor, velocity: Velocity, *pins: VirtualPin) -> None:
    """Turn a motor by what its pins ask for, as soon as one of them changes."""
    for pin in pins:
        pin.on_change(lambda: motor.set_velocity(velocity(duty())))
