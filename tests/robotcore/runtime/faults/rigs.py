"""A rover of null devices, some of which fail."""

from __future__ import annotations

from robotcore.description import DeviceDescription, RobotDescription
from robotcore.hal.clock import Clock
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.layers import assemble
from robotcore.runtime.layers.base import Layer
from tests.robotcore.fakes import UNHURRIED, Rig

TICK_S = 0.05


def layers(*specs: str, clock: Clock, seed: int = 1) -> list[Layer]:
    """Return the layers of faults on a rover with all devices open."""
    names = [device.name for device in UNHURRIED.devices]
    return [fault.layer(clock, seed) for fault in plan_faults(specs, UNHURRIED, names)]


def build_rover(*devices: DeviceDescription) -> RobotDescription:
    """Return the description of a rover with further devices."""
    return UNHURRIED.model_copy(update={"devices": (*UNHURRIED.devices, *devices)})


def build_rig(*specs: str, seed: int = 1) -> Rig:
    """Return a rover without encoders under the layers of a run with these faults."""
    rig = Rig(description=UNHURRIED)
    faults = layers(*specs, clock=rig.clock, seed=seed)
    rig._assembled = assemble(rig.raw, UNHURRIED, rig.rate_hz, seed=seed, faults=faults)
    return rig
