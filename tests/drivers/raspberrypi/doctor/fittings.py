"""Devices that are connected somewhere."""

from __future__ import annotations

from robotcore.description import AnyDevice, StrictModel, load_robot
from robotcore.hal.devices import Device
from robotcore.hardware import Connection, DeviceDriver, Fitting, Host


class Plugged(DeviceDriver[AnyDevice, StrictModel]):
    """Is on the wires that it is made with."""

    name = "plugged"
    summary = "for tests"
    described = StrictModel
    settings = StrictModel

    def __init__(self, wires: tuple[Connection, ...], notes: tuple[str, ...]) -> None:
        self._wires, self._notes = wires, notes

    def open(self, told: AnyDevice, settings: StrictModel, host: Host) -> Device:
        raise NotImplementedError

    def connections(self, settings: StrictModel) -> tuple[Connection, ...]:
        return self._wires

    def notes(self, told: AnyDevice, settings: StrictModel) -> tuple[str, ...]:
        return self._notes


class Fed(Plugged):
    """Takes 3.3 V from the board."""

    supply = ("3.3 V", "ground")


def fitting(name: str, *wires: Connection, notes: tuple[str, ...] = (), kind: type[Plugged] = Plugged) -> Fitting:
    """Return a device of the rover's on these wires."""
    told = next(device for device in load_robot("rover").devices if device.name == name)
    return Fitting(told, kind(wires, notes), StrictModel())
