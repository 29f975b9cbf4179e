"""One device, and how it is connected."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robotcore.description import AnyDevice, Described
from robotcore.errors import DeviceError, RobotcoreError
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device
from robotcore.hardware.connections import Connection
from robotcore.hardware.driver import DeviceDriver, Host


@dataclass(frozen=True)
class Fitting:
    """One device: what it is, which driver opens it, and how it is connected."""

    told: AnyDevice
    driver: DeviceDriver[Any, Any]
    settings: Described

    @property
    def name(self) -> str:
        return self.told.name

    @property
    def connections(self) -> tuple[Connection, ...]:
        return tuple(self.driver.connections(self.settings))

    @property
    def warnings(self) -> tuple[str, ...]:
        return tuple(self.driver.warnings(self.settings))

    @property
    def notes(self) -> tuple[str, ...]:
        """What whoever connects it must know, at last what may do harm."""
        return (*self.driver.notes(self.told, self.settings), *self.warnings)

    def open(self, host: Host) -> Device:
        """Open the device; raises DeviceError, for what its driver has not translated too."""
        try:
            return self.driver.open(self.told, self.settings, host)
        except RobotcoreError:
            raise
        except ImportError as error:
            raise DeviceError(self.name, f"a library is not installed ({error}). {self.driver.remedy}") from error
        except Exception as error:
            raise DeviceError(self.name, f"{type(error).__name__}: {error}".removesuffix(": ")) from error

    def cutoffs(self, host: Host) -> tuple[CutoffSpec, ...]:
        """Return how another process stops the device; see `DeviceDriver.cutoffs`."""
        return tuple(self.driver.cutoffs(self.told, self.settings, host))
