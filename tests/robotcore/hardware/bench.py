"""Device drivers that keep a diary, and a robot that names them."""

from __future__ import annotations

from typing import Any

from robotcore.description import AnyDevice, RobotDescription, StrictModel, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device
from robotcore.hardware import DeviceDriver, Fitting, Host


class NoSettings(StrictModel):
    """Nothing to tell."""


class Noted(Device):
    """Writes down when it is closed."""

    def __init__(self, name: str, diary: list[str]) -> None:
        super().__init__(name)
        self._diary = diary

    def _release(self) -> None:
        self._diary.append(f"close {self.name}")


class NotingDriver(DeviceDriver[Any, NoSettings]):
    """Opens whatever there is, but for what is ``dead``."""

    name = "noting"
    summary = "for tests"
    described = StrictModel
    settings = NoSettings

    def __init__(self, *dead: str) -> None:
        self.diary: list[str] = []
        self._dead = dead

    def open(self, told: AnyDevice, settings: NoSettings, host: Host) -> Device:
        self.diary.append(f"open {told.name} beside {', '.join(host.opened) or 'nothing'}")
        if told.name in self._dead:
            raise DeviceError(told.name, "does not answer")
        return Noted(told.name, self.diary)


def fitted(driver: NotingDriver, robot: RobotDescription) -> list[Fitting]:
    return [Fitting(told, driver, NoSettings()) for told in robot.devices]


def host(opened: dict[str, Device]) -> Host:
    return Host(load_robot("rover"), SteppedClock(20, lambda _steps: None), opened=opened)
