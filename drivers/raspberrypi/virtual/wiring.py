"""The wiring of a virtual robot, which connects pins by models of hardware to the devices of a simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from drivers.raspberrypi.cameras.source import CameraSettings
from drivers.raspberrypi.encoders import EncoderSettings, PulsesSettings, QuadratureSettings
from drivers.raspberrypi.motors.boards import HBridgeSettings, PhaseEnableSettings
from drivers.raspberrypi.ranging.time_of_flight_driver import TimeOfFlightSettings
from drivers.raspberrypi.ranging.ultrasonic_driver import UltrasonicSettings, speed_of_sound
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
"""The settings of the devices that have a model."""

SIMULATED = (CameraSettings, TimeOfFlightSettings)
"""The settings of devices that are not on pins. The simulator's own devices replace these devices."""

MAX_ECHO_M = 4.3
"""The distance of the farthest wall whose echo an HC-SR04 receives, in metres."""


class VirtualWiring:
    """Connects pins to the devices of a simulator.

    is_lost: called for each ultrasonic echo; returns whether the echo is lost.
    """

    def __init__(self, simulated: Robot, pins: VirtualPins, is_lost: Callable[[], bool]) -> None:
        self._simulated, self._pins, self._is_lost = simulated, pins, is_lost

    def connect(self, binding: DeviceBinding) -> bool:
        """Connect a device's pins to a model; return whether there is a model of the device."""
        pin = self._pins.pin
        match binding.settings, binding.description, self._simulated.devices[binding.name]:
            case HBridgeSettings() as on, _, Motor() as motor:
                enable = None if on.enable is None else pin(on.enable)
                wire_two_inputs(motor, on.model.velocity, pin(on.forward), pin(on.backward), enable)
            case PhaseEnableSettings() as on, _, Motor() as motor:
                wire_phase_and_enable(motor, on.model.velocity, pin(on.phase), pin(on.enable))
            case QuadratureSettings() as on, EncoderDescription() as description, Encoder() as encoder:
                self._schedule(QuadratureDisc(encoder, math.tau / on.edges_per_turn(description), pin(on.a), pin(on.b)))
            case PulsesSettings() as on, EncoderDescription() as description, Encoder() as encoder:
                self._schedule(SlottedDisc(encoder, math.tau / on.edges_per_turn(description), pin(on.gpio)))
            case UltrasonicSettings() as on, _, RangeSensor() as sensor:
                speed = speed_of_sound(on.air_temperature_c)
                VirtualEcho(self._simulated.clock, sensor, pin(on.trigger), pin(on.echo), speed, self._is_lost)
            case _:
                return False
        return True

    def _schedule(self, disc: Disc) -> None:
        # in every physics step of the simulator
        clock = self._simulated.clock
        step = clock.step if isinstance(clock, SteppedClock) else 1 / MIN_PHYSICS_RATE_HZ
        clock.every(step, disc.update, "disc")


def find_unmodelled(bindings: Iterable[DeviceBinding]) -> list[DeviceBinding]:
    """Return the devices without a model, which the simulator's own devices replace.

    The result has no batteries, because simulators have none.
    """
    return [
        binding
        for binding in bindings
        if not isinstance(binding.settings, MODELLED) and not isinstance(binding.description, BatteryDescription)
    ]


def describe_hardware(binding: DeviceBinding) -> AnyDevice:
    """Return the description of a device's hardware, for the simulator.

    An encoder's counts are all of its edges. An ultrasonic module also measures walls beyond its ``max_range_m``.
    """
    match binding.settings, binding.description:
        case EncoderSettings() as settings, EncoderDescription() as description:
            return description.model_copy(update={"counts_per_turn": settings.edges_per_turn(description)})
        case UltrasonicSettings(), description:
            return description.model_copy(update={"max_range_m": MAX_ECHO_M})
    return binding.description
