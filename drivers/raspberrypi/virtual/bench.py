"""Where a virtual robot is wired up: on the other end of each device's pins, a model, with the simulator behind it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from drivers.raspberrypi.ranging.sound import speed_of_sound
from drivers.raspberrypi.virtual.discs import Disc, QuadratureDisc, SlottedDisc
from drivers.raspberrypi.virtual.echo import VirtualEcho
from drivers.raspberrypi.virtual.pins import VirtualPin, VirtualPins
from drivers.raspberrypi.virtual.wheels import phase_and_enable, two_inputs
from robotcore.clock import MIN_PHYSICS_RATE_HZ, SteppedClock
from robotcore.hardware import Fitting
from robotcore.robot import Robot


class Bench:
    """Connects the pins of devices to the devices that a simulator opened; an echo may be lost on the way."""

    def __init__(self, simulated: Robot, pins: VirtualPins, is_lost: Callable[[], bool]) -> None:
        self._simulated, self._pins, self._is_lost = simulated, pins, is_lost
        self._discs: list[Disc] = []

    def connect(self, fitting: Fitting) -> None:
        """Put a model on the other end of a device's pins."""
        _MODELS[fitting.driver.name](self, fitting, self._simulated.devices[fitting.name])

    def start(self) -> None:
        """From now on, let discs turn with every step of the physics."""
        if self._discs:
            clock = self._simulated.clock
            step = clock.step if isinstance(clock, SteppedClock) else 1 / MIN_PHYSICS_RATE_HZ
            clock.every(step, self._turn, "discs")

    def _turn(self) -> None:
        for disc in self._discs:
            disc.turn()

    def _pin(self, number: int) -> VirtualPin:
        pin: VirtualPin = self._pins.pin(number)
        return pin

    def _h_bridge(self, fitting: Fitting, motor: Any) -> None:
        told: Any = fitting.settings
        enable = None if told.enable is None else self._pin(told.enable)
        two_inputs(motor, told.model.velocity, self._pin(told.forward), self._pin(told.backward), enable)

    def _phase_enable(self, fitting: Fitting, motor: Any) -> None:
        told: Any = fitting.settings
        phase_and_enable(motor, told.model.velocity, self._pin(told.phase), self._pin(told.enable))

    def _quadrature(self, fitting: Fitting, encoder: Any) -> None:
        told: Any = fitting.settings
        self._discs.append(QuadratureDisc(encoder, _radians(fitting), self._pin(told.a), self._pin(told.b)))

    def _pulses(self, fitting: Fitting, encoder: Any) -> None:
        told: Any = fitting.settings
        self._discs.append(SlottedDisc(encoder, _radians(fitting), self._pin(told.pin)))

    def _hc_sr04(self, fitting: Fitting, sensor: Any) -> None:
        told: Any = fitting.settings
        pins = self._pin(told.trigger), self._pin(told.echo)
        VirtualEcho(self._simulated.clock, sensor, *pins, speed_of_sound(told.air_temperature_c), self._is_lost)


_MODELS: Mapping[str, Callable[[Bench, Fitting, Any], None]] = {
    "h-bridge": Bench._h_bridge,
    "phase-enable": Bench._phase_enable,
    "quadrature": Bench._quadrature,
    "pulses": Bench._pulses,
    "hc-sr04": Bench._hc_sr04,
}


def _radians(fitting: Fitting) -> float:
    """Return how far a wheel turns from one edge of its encoder to the next."""
    told: Any = fitting.settings
    return math.tau / int(told.edges_per_turn(fitting.told))


def is_on_pins(fitting: Fitting) -> bool:
    """Return whether there is a model of the device; any other is the simulator's own."""
    return fitting.driver.name in _MODELS
