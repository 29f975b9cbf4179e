"""The wiring of a virtual robot: connect each device's pins to a model, and the model to the simulator."""

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
"""The settings of the devices that `VirtualWiring.connect` supports."""

SIMULATED = (CameraSettings, TimeOfFlightSettings)
"""The settings of devices that are not on pins. The simulator's own devices replace them."""

HEARD_M = 4.3
"""The distance of the farthest wall that an HC-SR04 measures, in metres."""


class VirtualWiring:
    """Connects pins to the devices of a simulator.

    is_lost: returns, for each ultrasonic echo, whether it is lost.
    """

    def __init__(self, simulated: Robot, pins: VirtualPins, is_lost: Callable[[], bool]) -> None:
        self._simulated, self._pins, self._is_lost = simulated, pins, is_lost

    def connect(self, binding: DeviceBinding) -> bool:
        """Connect a device's pins to a model; return False if there is no model for it."""
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
        """Update a disc in every physics step of the simulator."""
        clock = self._simulated.clock
        step = clock.step if isinstance(clock, SteppedClock) else 1 / MIN_PHYSICS_RATE_HZ
        clock.every(step, disc.update, "disc")


def find_unmodelled(bindings: Iterable[DeviceBinding]) -> list[DeviceBinding]:
    """Return the devices without a model, which the simulator's own devices replace.

    Batteries are left out, because a simulator has none.
    """
    return [
        binding
        for binding in bindings
        if not isinstance(binding.settings, MODELLED) and not isinstance(binding.description, BatteryDescription)
    ]


def describe_hardware(binding: DeviceBinding) -> AnyDevice:
    """Return the description of a device's hardware, for the simulator.

    The encoder's counts are all its edges. The ultrasonic module also measures walls beyond ``max_range_m``.
    """
    match binding.settings, binding.description:
        case EncoderSettings() as settings, EncoderDescription() as description:
            return description.model_copy(update={"counts_per_turn": settings.edges_per_turn(description)})
        case UltrasonicSettings(), description:
            return description.model_copy(update={"max_range_m": HEARD_M})
    return binding.description
