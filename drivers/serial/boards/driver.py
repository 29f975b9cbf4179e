"""What the drivers of devices on a serial line have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, TypeVar

from drivers.serial.boards.settings import PortSettings
from robotcore.description import Described
from robotcore.hardware import Connection, DeviceDriver

ToldT = TypeVar("ToldT", bound=Described)
SettingsT = TypeVar("SettingsT", bound=PortSettings)


class SerialDriver(DeviceDriver[ToldT, SettingsT]):
    """A driver of one of a board's devices; ``what`` is the one, such as "motor", that no other device may be."""

    modules = ("serial",)
    remedy = "pip install 'robotcore[serial]'"
    what: ClassVar[str]

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        return settings.at(self.what)
