"""Device drivers without hardware: one that records opening and closing, and one on a board with pins."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import EntryPoint
from typing import Annotated, Any, ClassVar

import pytest
from pydantic import Field

from robotcore import plugins as registry
from robotcore.description import AnyDevice, MotorDescription, RobotDescription, StrictModel, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device
from robotcore.hal.robot import Robot
from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware import Connection, DeviceBinding, DeviceDriver, Host, bind_devices


class NoSettings(StrictModel):
    """The settings of a driver that needs none."""


class RecordedDevice(Device):
    """A device that records its closing."""

    def __init__(self, name: str, calls: list[str]) -> None:
        super().__init__(name)
        self._calls = calls

    def _release(self) -> None:
        self._calls.append(f"close {self.name}")


class RecordingDriver(DeviceDriver[Any, NoSettings]):
    """Opens any device except those named in ``dead``, and records the calls."""

    name = "recording"
    summary = "for tests"
    described = StrictModel
    settings = NoSettings

    def __init__(self, *dead: str) -> None:
        self.calls: list[str] = []
        self._dead = dead

    def open(self, description: AnyDevice, settings: NoSettings, host: Host) -> Device:
        self.calls.append(f"open {description.name} beside {', '.join(host.opened) or 'nothing'}")
        if description.name in self._dead:
            raise DeviceError(description.name, "does not answer")
        return RecordedDevice(description.name, self.calls)


def bind(driver: RecordingDriver, robot: RobotDescription) -> list[DeviceBinding]:
    return [DeviceBinding(description, driver, NoSettings()) for description in robot.devices]


def host(opened: dict[str, Device]) -> Host:
    return Host(load_robot("rover"), SteppedClock(20, lambda _steps: None), opened=opened)


class PlugSettings(StrictModel):
    """The settings of a plug. Several devices can share a ``bus``, but not a ``pin``."""

    pin: Annotated[int, Field(ge=1, le=9, description="the number of a hole, 1 to 9")]
    spare: int | None = None
    bus: int | None = None


class Plug(DeviceDriver[Any, PlugSettings]):
    """A driver for any device."""

    name = "plug"
    summary = "for tests"
    described: ClassVar[type[StrictModel]] = StrictModel
    settings = PlugSettings
    aliases = ("banana", "jack-42")

    def open(self, description: Any, settings: PlugSettings, host: Host) -> Device:
        raise NotImplementedError

    def check(self, description: Any, settings: PlugSettings, robot: RobotDescription) -> None:
        if settings.pin == 9:
            raise ValueError("hole 9 is blocked; take another hole")

    def connections(self, settings: PlugSettings) -> Sequence[Connection]:
        wires = [Connection("pin", "hole", str(settings.pin))]
        wires += [Connection("spare", "hole", str(settings.spare))] if settings.spare else []
        wires += [Connection("bus", "rail", str(settings.bus), is_shared=True)] if settings.bus else []
        return wires

    def notes(self, description: Any, settings: PlugSettings) -> Sequence[str]:
        return ("Push it in all the way.",)


class MotorPlug(Plug):
    """A driver for motors only."""

    name = "motor-plug"
    described = MotorDescription


class PlugBoard(Backend):
    """A board with nine holes. Its wiring shows two pads."""

    name = "plugboard"
    summary = "for tests"

    def open(self, setup: Setup) -> Robot:
        raise NotImplementedError

    def check(self, robot: RobotDescription) -> str:
        return f"{len(bind_devices(robot, self.name))} plugs"

    def wiring(self, robot: RobotDescription) -> Wiring:
        bindings = bind_devices(robot, self.name)
        pads = (Pad(1, "GPIO 1", PadKind.SIGNAL), Pad(2, "ground", PadKind.GROUND))
        wires = [
            Wire(binding.name, binding.driver.name, wire.signal, str(wire), (int(wire.where),))
            for binding in bindings
            for wire in binding.connections
        ]
        return Wiring(pads, wires, [(binding.name, note) for binding in bindings for note in binding.notes])


def register(monkeypatch: pytest.MonkeyPatch, **broken: str) -> None:
    """Register the board and its drivers. ``broken`` maps the names of further drivers to their entry points."""
    drivers = {"plug": f"{__name__}:Plug", "motor-plug": f"{__name__}:MotorPlug", **broken}
    groups = (registry.APPS, registry.BACKENDS, registry.DEVICES, registry.FAULTS)
    points = {group: dict(registry._points(group)) for group in groups}
    points[registry.DEVICES] = {name: EntryPoint(name, value, registry.DEVICES) for name, value in drivers.items()}
    points[registry.BACKENDS]["plugboard"] = EntryPoint("plugboard", f"{__name__}:PlugBoard", registry.BACKENDS)
    monkeypatch.setattr("robotcore.plugins._points", points.get)


def robot_file(section: str) -> str:
    """Return a robot's file with a motor, a camera, a display, and ``section`` at its end."""
    body = "length_m = 0.2\nwidth_m = 0.2\nheight_m = 0.1\nclearance_m = 0.01\nmass_kg = 1.0\n"
    eye = "mount = { z_m = 0.1 }\nwidth_px = 320\nheight_px = 240\nhorizontal_fov_rad = 1.0\n"
    return (
        f'name = "post"\n[body]\n{body}\n'
        '[[devices]]\nkind = "motor"\nname = "neck"\nmax_velocity_rad_s = 1.0\n'
        f'[[devices]]\nkind = "camera"\nname = "eye"\n{eye}'
        f'[[devices]]\nkind = "display"\nname = "screen"\n{section}'
    )


NECK = '[plugboard.neck]\ndriver = "motor-plug"\npin = 1\n'
EYE = '[plugboard.eye]\ndriver = "plug"\npin = 2\n'
