"""A rover of null devices, some of which fail."""

from __future__ import annotations

from robotcore.hal.clock import Clock
from robotcore.hal.devices import Encoder
from robotcore.hal.robot import Robot
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.layers import assemble
from robotcore.runtime.layers.base import Layer
from tests.robotcore.fakes import UNHURRIED, NullEncoder, Rig

TICK_S = 0.05


def layers(*specs: str, clock: Clock, seed: int = 1) -> list[Layer]:
    """Return the layers of faults on a rover with all devices open."""
    names = [device.name for device in UNHURRIED.devices]
    return [fault.layer(clock, seed) for fault in plan_faults(specs, UNHURRIED, names)]


def build_rig(*specs: str, seed: int = 1) -> Rig:
    """Return a rover without encoders under the layers of a run with these faults."""
    rig = Rig(description=UNHURRIED)
    faults = layers(*specs, clock=rig.clock, seed=seed)
    rig._assembled = assemble(rig.raw, UNHURRIED, rig.rate_hz, seed=seed, faults=faults)
    return rig


class Odometer:
    """A rover's left encoder alone, through the layers of faults."""

    def __init__(self, *specs: str) -> None:
        rig = Rig(description=UNHURRIED)
        self.inner = NullEncoder(rig.clock, "left_encoder")
        faults = layers(*specs, clock=rig.clock)
        assembled = assemble(Robot("rig", rig.clock, [self.inner]), UNHURRIED, 20, faults=faults)
        self._clock, self._robot = assembled.clock, assembled.robot

    def turn(self, angle: float) -> None:
        """Turn the wheel by an angle within one tick."""
        self.inner.angle += angle
        self._clock.sleep_until(self._clock.now() + TICK_S)

    @property
    def angle(self) -> float:
        encoder = self._robot["left_encoder"]
        assert isinstance(encoder, Encoder)
        return encoder.read().angle
