"""A robot: its devices by name and by role, its drive, its clock."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum
from types import TracebackType
from typing import NoReturn

from robotcore.errors import DeviceGroupError, UnknownNameError, UnmetNeedError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Camera, Device, Display, Motor, RangeSensor
from robotcore.hal.drive import DifferentialDrive
from robotcore.hal.truth import TruthSource


class Role(str, Enum):
    """What an app may need of a robot, whatever the device behind it is called."""

    DRIVE = "drive"
    CAMERA = "camera"
    RANGE = "range"
    DISPLAY = "display"


class Robot:
    """An open robot. Leaving it, for whatever reason, stops every motor first.

    A role is filled by the first device of its kind. ``truth`` is what a simulator knows besides. ``cutoffs`` are how
    another process can stop the motors where this one can not; a run starts none where there are none. ``notes`` are
    what whoever runs it must know, and what is known only now.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        devices: Iterable[Device],
        *,
        drive: DifferentialDrive | None = None,
        truth: TruthSource | None = None,
        release: Callable[[], None] | None = None,
        cutoffs: Iterable[CutoffSpec] = (),
        notes: Iterable[str] = (),
    ) -> None:
        self.name = name
        self.clock = clock
        self.devices = {device.name: device for device in devices}
        self.truth = truth
        self.cutoffs = tuple(cutoffs)
        self.notes = tuple(notes)
        self._drive = drive
        self._release = release
        self._camera = next((d for d in self.devices.values() if isinstance(d, Camera)), None)
        self._range = next((d for d in self.devices.values() if isinstance(d, RangeSensor)), None)
        self._display = next((d for d in self.devices.values() if isinstance(d, Display)), None)

    @property
    def drive(self) -> DifferentialDrive:
        return self._drive or self._unmet(Role.DRIVE)

    @property
    def camera(self) -> Camera:
        return self._camera or self._unmet(Role.CAMERA)

    @property
    def range(self) -> RangeSensor:
        return self._range or self._unmet(Role.RANGE)

    @property
    def display(self) -> Display:
        return self._display or self._unmet(Role.DISPLAY)

    @property
    def motors(self) -> dict[str, Motor]:
        """Every motor that is open, by name."""
        return {d.name: d for d in self.devices.values() if isinstance(d, Motor)}

    def has(self, role: Role) -> bool:
        """Return whether something open fills the role."""
        filled = {
            Role.DRIVE: self._drive,
            Role.CAMERA: self._camera,
            Role.RANGE: self._range,
            Role.DISPLAY: self._display,
        }
        return filled[role] is not None

    def __getitem__(self, name: str) -> Device:
        if name not in self.devices:
            raise UnknownNameError("device", name, list(self.devices))
        return self.devices[name]

    def stop(self) -> None:
        """Stop every motor, each on its own; then raise what failed at once, DeviceGroupError."""
        if failures := _failures(motor.stop for motor in self.motors.values()):
            raise DeviceGroupError(f"stopping {self.name}", failures)

    def close(self) -> None:
        """Stop every motor, each on its own; then close every device; then let the backend go.

        All of it is tried, whatever fails; then what failed is raised at once, DeviceGroupError.
        """
        tries: list[Callable[[], None]] = [motor.stop for motor in self.motors.values()]
        tries += [device.close for device in self.devices.values()]
        tries.append(self.clock.close)
        if self._release:
            tries.append(self._release)
            self._release = None
        if failures := _failures(tries):
            raise DeviceGroupError(f"closing {self.name}", failures)

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _unmet(self, role: Role) -> NoReturn:
        raise UnmetNeedError(
            f"{self.name} has no {role.value} open; name it in the app's needs, or take a robot that has one"
        )


def _failures(tries: Iterable[Callable[[], None]]) -> list[Exception]:
    """Call each, whatever the others do; return what was raised, what says the same only once."""
    failures: dict[str, Exception] = {}
    for attempt in tries:
        try:
            attempt()
        except Exception as failure:  # noqa: BLE001, PERF203  one that fails must not keep the others from stopping
            for each in failure.failures if isinstance(failure, DeviceGroupError) else (failure,):
                failures.setdefault(str(each), each)
    return list(failures.values())
