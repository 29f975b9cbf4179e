"""The wiring of a virtual robot: a model on the other end of each device's pins, with the simulator behind it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from drivers.raspberrypi.cameras.source import CameraSettings
from drivers.raspberrypi.encoders import EncoderSettings, PulsesSettings, QuadratureSettings
from drivers.raspberrypi.motors.boards import HBridgeSettings, PhaseEnableSettings
from drivers.raspberrypi.ranging.timeofflight import TimeOfFlightSettings
from drivers.raspberrypi.ranging.ultrasonic import UltrasonicSettings, speed_of_sound
from drivers.raspberrypi.virtual.models import (
    Disc,
    QuadratureDisc,
    SlottedDisc,
    VirtualEcho,
    VirtualPins,
    wire_phase_and_enable,
    wire_two_inputs,
)
from robotcore.description import AnyDevice, BatteryDescription, EncoderDescription
from robotcore.hal.clock import MIN_PHYSICS_RATE_HZ, SteppedClock
from robotcore.hal.devices import Encoder, Motor, RangeSensor
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceBinding

MODELLED = (HBridgeSettings, PhaseEnableSettings, QuadratureSettings, PulsesSettings, UltrasonicSettings)
"""What `Bench.connect` knows, by the settings of its driver."""

SIMULATED = (CameraSettings, TimeOfFlightSettings)
"""Ours that are on no pins: the simulator's own device is meant to stand in."""

HEARD_M = 4.3
"""The farthest wall that an HC-SR04 hears."""


class VirtualWiring:
    """Connects pins to the devices that a simulator opened; an echo may be lost on the way."""

    def __init__(self, simulated: Robot, pins: VirtualPins, is_lost: Callable[[], bool]) -> None:
        self._simulated, self._pins, self._is_lost = simulated, pins, is_lost

    def connect(self, fitting: DeviceBinding) -> bool:
        """Put a model on the other end of a device's pins; return whether there is one."""
        pin = self._pins.pin
        match fitting.settings, fitting.description, self._simulated.devices[fitting.name]:
            case HBridgeSettings() as on, _, Motor() as motor:
                enable = None if on.enable is None else pin(on.enable)
                wire_two_inputs(motor, on.model.velocity, pin(on.forward), pin(on.backward), enable)
            case PhaseEnableSettings() as on, _, Motor() as motor:
                wire_phase_and_enable(motor, on.model.velocity, pin(on.phase), pin(on.enable))
            case QuadratureSettings() as on, EncoderDescription() as description, Encoder() as encoder:
                self._turn(QuadratureDisc(encoder, math.tau / on.edges_per_turn(description), pin(on.a), pin(on.b)))
            case PulsesSettings() as on, EncoderDescription() as description, Encoder() as encoder:
                self._turn(SlottedDisc(encoder, math.tau / on.edges_per_turn(description), pin(on.gpio)))
            case UltrasonicSettings() as on, _, RangeSensor() as sensor:
                speed = speed_of_sound(on.air_temperature_c)
                VirtualEcho(self._simulated.clock, sensor, pin(on.trigger), pin(on.echo), speed, self._is_lost)
            case _:
                return False
        return True

    def _turn(self, disc: Disc) -> None:
        """Let a disc turn with every step of the physics."""
        clock = self._simulated.clock
        step = clock.step if isinstance(clock, SteppedClock) else 1 / MIN_PHYSICS_RATE_HZ
        clock.every(step, disc.turn, "disc")


def find_unmodelled(fittings: Iterable[DeviceBinding]) -> list[DeviceBinding]:
    """Return the devices for which the simulator's own stand in: their drivers do not run. It has no battery."""
    return [
        fitting
        for fitting in fittings
        if not isinstance(fitting.settings, MODELLED) and not isinstance(fitting.description, BatteryDescription)
    ]


def describe_hardware(fitting: DeviceBinding) -> AnyDevice:
    """Return a device as its hardware is, which tells more than is described.

    Each edge of an encoder, and walls beyond the maximum, for which an ultrasonic module has echoes too.
    """
    match fitting.settings, fitting.description:
        case EncoderSettings() as settings, EncoderDescription() as description:
            return description.model_copy(update={"counts_per_turn": settings.edges_per_turn(description)})
        case UltrasonicSettings(), description:
            return description.model_copy(update={"max_range_m": HEARD_M})
    return fitting.description
