"""A wheel on mock pins, between a motor board and an encoder, simulated step by step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.description import RobotDescription, load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device
from robotcore.hardware import DeviceContext, bind_devices, open_devices
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.motor import Motor

FORWARD, BACKWARD, A, B = 17, 27, 5, 6
MODEL: Mapping[str, float] = {"dead_band": 0.1, "forward_rad_s": 14.0, "backward_rad_s": 14.0}
H_BRIDGE: Mapping[str, Any] = {"driver": "h-bridge", "forward": FORWARD, "backward": BACKWARD, "model": dict(MODEL)}
QUADRATURE: Mapping[str, Any] = {"driver": "quadrature", "a": A, "b": B}


class Rig:
    """The left wheel of a rover, with its motor and encoder on mock pins.

    wheel: the true model of the motor, if it differs from the described one.
    slots: the cycles of the encoder in a turn.
    """

    def __init__(
        self,
        motor: Mapping[str, Any] = H_BRIDGE,
        encoder: Mapping[str, Any] = QUADRATURE,
        *,
        slots: int = 240,
        wheel: Mapping[str, float] | None = None,
        pins: Any = None,
        pin_class: type[MockPWMPin] = MockPWMPin,
        names: Sequence[str] = ("left_encoder", "left_motor"),
    ) -> None:
        self.pins = pins or MockFactory(pin_class=pin_class)
        self.clock = SteppedClock(50.0, self._advance)
        self.wheel = MotorModel(**{**MODEL, **(wheel or {})})
        self.angle = self.velocity = 0.0
        self.on_step: Callable[[], object] = lambda: None
        self._slots = slots
        robot = rover({"left_motor": motor, "left_encoder": encoder}, slots)
        self.opened: dict[str, Device] = {}
        self.host = DeviceContext(robot, self.clock, self.pins, self.opened)
        self.bindings = {binding.name: binding for binding in bind_devices(robot, "raspberrypi", names)}
        open_devices(self.bindings.values(), self.host, self.opened)

    @property
    def motor(self) -> Motor:
        motor = self.opened["left_motor"]
        assert isinstance(motor, Motor)
        return motor

    @property
    def encoder(self) -> Encoder:
        encoder = self.opened["left_encoder"]
        assert isinstance(encoder, Encoder)
        return encoder

    def duty(self) -> float:
        """Return the duty of the motor's pins, forward positive."""
        return float(self.pins.pin(FORWARD).state) - float(self.pins.pin(BACKWARD).state)

    def pass_time(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)

    def close(self) -> None:
        for device in reversed(list(self.opened.values())):
            device.close()

    def _advance(self, steps: int) -> None:
        for _ in range(steps):
            target = self.wheel.velocity(self.duty())
            self.velocity += (target - self.velocity) * (1 - math.exp(-self.clock.step / 0.05))
            self.turn_to(self.angle + self.velocity * self.clock.step)
            self.on_step()

    def turn_to(self, angle: float) -> None:
        """Turn the wheel to this angle in rad, edge by edge. At the angle 0, both channels are high."""
        edge_rad = math.tau / self._slots / 4
        edge, to = round(self.angle / edge_rad), round(angle / edge_rad)
        while edge != to:
            edge += 1 if to > edge else -1
            a, b = ((True, True), (False, True), (False, False), (True, False))[edge % 4]
            _drive(self.pins.pin(A), a)
            _drive(self.pins.pin(B), b)
        self.angle = angle


def rover(section: Mapping[str, Any], counts_per_turn: int = 960) -> RobotDescription:
    """Return the rover with these tables, and with this resolution of its encoders."""
    description = load_robot("rover")
    devices = [
        device.model_copy(update={"counts_per_turn": counts_per_turn}) if device.kind == "encoder" else device
        for device in description.devices
    ]
    return description.model_copy(update={"devices": tuple(devices), "backends": {"raspberrypi": dict(section)}})


def _drive(pin: Any, is_high: bool) -> None:
    pin.drive_high() if is_high else pin.drive_low()
