"""The interface of a driver package: the backend, and the setup from which a backend opens a robot."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import Enum
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from pydantic import ValidationError

from robotcore.description import (
    BatteryDescription,
    RobotDescription,
    StrictModel,
    WorldDescription,
    first_mistake,
    load_robot,
)
from robotcore.errors import BackendMissingError, DeviceError, DeviceGroupError, UnknownNameError, UsageError
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device
from robotcore.hal.robot import Robot
from robotcore.plugins import BACKENDS, backend_names, load_registered

if TYPE_CHECKING:
    from robotcore.hal.check_finding import Finding
    from robotcore.hal.wiring import Wiring


@dataclass(frozen=True)
class ModelExport:
    """The model of a robot in a text format."""

    text: str
    """The document."""
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    """The content of each file that the document refers to, by the path relative to the document."""
    notes: tuple[str, ...] = ()
    """The parts of the robot and the world that the document lacks, as sentences."""


OptionsT = TypeVar("OptionsT", bound=StrictModel)


class Capability(str, Enum):
    """A property of a simulator on which runs and tests rely."""

    CONTACTS = "contacts"
    """The simulator counts the contacts of the robot with the world."""
    POSE = "pose"
    """The simulator provides the exact pose of the robot."""
    LOCKSTEP = "lockstep"
    """Simulated time passes only when the robot's clock sleeps. Two equal runs then have bitwise equal results."""


@dataclass(frozen=True)
class Setup:
    """The arguments with which a backend opens a robot.

    >>> from robotcore.description import load_robot, load_world
    >>> setup = Setup(load_robot("rover"), load_world("arena"), devices=frozenset({"nose", "left_motor"}))
    >>> [device.name for device in setup.chosen_devices]
    ['left_motor', 'nose']
    """

    robot: RobotDescription
    world: WorldDescription | None
    """The world to simulate. None for a backend without a world."""
    devices: frozenset[str]
    """The names of the devices to open."""
    rate_hz: float = 20.0
    """The number of ticks in a second."""
    seed: int = 0
    gui: bool = False
    """Whether to open a window."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """The user's options for the backend."""

    def options_as(self, model: type[OptionsT]) -> OptionsT:
        """Return the user's options as an instance of the backend's model. Raises UsageError for wrong options."""
        known = list(model.model_fields)
        for name in self.options:
            if name not in known:
                meant = "" if known else "one of another backend, which --backend names"
                raise UnknownNameError("option", name, known, meant)
        try:
            return model.model_validate(dict(self.options))
        except ValidationError as error:
            key, fault = first_mistake(error)
            raise UsageError(f"option {key}: {fault}", kind="invalid-option", option=key) from error

    @property
    def chosen_devices(self) -> tuple[Any, ...]:
        """The descriptions of the devices to open, in the order of the file."""
        return tuple(device for device in self.robot.devices if device.name in self.devices)

    def without_batteries(self) -> Setup:
        """Return the setup without batteries, for a simulator, which has none."""
        batteries = {battery.name for battery in self.robot.all_of(BatteryDescription)}
        return replace(self, devices=self.devices - batteries)

    def open_each(self, open_one: Callable[[Any], Device]) -> list[Device]:
        """Open each device with a function, and return the open devices.

        Raises DeviceGroupError if a device fails, after all others were tried.
        """
        devices, failures = [], []
        for description in self.chosen_devices:
            try:
                devices.append(open_one(description))
            except DeviceError as failure:  # noqa: PERF203  the error names every device that fails
                failures.append(failure)
        if failures:
            raise DeviceGroupError(f"opening {self.robot.name}", failures)
        return devices


class Backend(ABC):
    """Opens robots in one simulator, or on one kind of board."""

    name: ClassVar[str]
    """The backend's name, for the option --backend."""
    summary: ClassVar[str]
    """A description in a few words, for lists."""
    capabilities: ClassVar[frozenset[Capability]] = frozenset()
    """The properties of its simulator on which runs and tests rely."""
    connection_options: ClassVar[frozenset[str]] = frozenset()
    """The names of the options that replace a connection in the robot's file, such as ``port``."""
    needs_world: ClassVar[bool] = False
    """Whether it needs a world to simulate."""
    has_gui: ClassVar[bool] = False
    """Whether --gui opens a window."""
    brings_physics: ClassVar[bool] = False
    """Whether the backend is a physics simulator that runs in this process, without another program."""
    is_exclusive: ClassVar[bool] = False
    """Whether only one program at a time can use its robot or simulator."""
    is_smoke_tested: ClassVar[bool] = True
    """Whether `robotcore doctor` checks that it is installed and, for a simulator, opens a robot in it."""
    exports: ClassVar[tuple[str, ...]] = ()
    """The formats of `export`."""
    modules: ClassVar[tuple[str, ...]] = ()
    """The modules that the backend requires. They are searched for without importing them."""

    @abstractmethod
    def open(self, setup: Setup) -> Robot:
        """Open the robot with exactly the devices of the setup, without layers.

        Raises BackendMissingError, DeviceError or DeviceGroupError, after closing the devices that were open.
        """

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        """Return the robot to open. A backend with its own description, such as a recording, returns that.

        robot: the name or the file of a robot.
        options: the user's options.

        Raises UsageError if there is no such robot.
        """
        return load_robot(robot)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of the batteries whose voltage the backend measures.

        Each run opens them, even if its app does not use them. A simulator has no batteries, so the default is empty.
        """
        return frozenset()

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of all devices that the backend can open: all except batteries that it cannot measure."""
        batteries = {battery.name for battery in robot.all_of(BatteryDescription)}
        return frozenset({device.name for device in robot.devices} - batteries) | self.batteries(robot, options)

    def builds_world(self, robot: RobotDescription) -> bool:
        """Return whether the backend builds the world from the world's file. Otherwise it uses an existing scene."""
        return self.needs_world

    def check(self, robot: RobotDescription) -> str:
        """Check the backend's section of a robot's file, and return a summary. Without a section, it is ``""``.

        Raises DescriptionError for a wrong section.
        """
        return ""

    def warnings(self, robot: RobotDescription) -> Sequence[str]:
        """Return the risks in the backend's section of a robot's file. Each text describes a risk and then its remedy.

        Raises DescriptionError for a wrong section.
        """
        return ()

    def notes(self, setup: Setup) -> Sequence[str]:
        """Return notes for the user of a run, such as parts of the robot that differ from the description.

        Raises DescriptionError for a wrong section.
        """
        return ()

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        """Yield findings about this machine, and about the robot if it is not None. By default there are none.

        `robotcore doctor` adds its own smoke test for a backend with ``is_smoke_tested``.
        """
        return ()

    def inspect_scene(self, setup: Setup) -> Iterable[Finding]:
        """Yield a finding for each of a robot's devices in the scene that a simulator has open. Nothing moves.

        Raises UsageError if the backend has no such scene, and BackendError if the simulator does not answer.
        """
        raise UsageError(
            f"the backend {self.name!r} has no scene to check. Leave --backend out: "
            "each section of the file is checked without it",
            kind="no-scene",
        )

    def export(
        self, file_format: str, robot: RobotDescription, world: WorldDescription | None, folder: str | None
    ) -> ModelExport:
        """Return the model of a robot in a format.

        file_format: one of ``exports``.
        robot: the robot.
        world: the world around the robot, which stands at its start pose. None exports the robot alone.
        folder: the name of a folder for pictures, next to the document. None leaves the pictures out.

        Raises UsageError for another format, and BackendMissingError.
        """
        text = f"the backend {self.name!r} exports no {file_format}. Take --format urdf"
        raise UsageError(text, kind="unknown-format", format=file_format)

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        """Return the specifications of cutoffs that stop the motors of the setup from another process.

        `robotcore stop` uses them after a run's process has died. A simulator returns none, because its motors end with
        the run. Nothing is opened. Raises UsageError and DescriptionError.
        """
        return ()

    def wiring(self, robot: RobotDescription) -> Wiring | None:
        """Return the wires of a robot from the backend's section of its file. None if the backend has no wires.

        Raises DescriptionError for a wrong section.
        """
        return None

    @property
    def is_native_host(self) -> bool:
        """Whether this machine is the board for which the backend is made."""
        return False

    @property
    def remedy(self) -> str:
        """The command that installs the libraries."""
        return f"pip install {' '.join(self.modules)}"

    @property
    def is_installed(self) -> bool:
        return all(_is_there(module) for module in self.modules)

    def require_installed(self) -> None:
        """Raise BackendMissingError, with the remedy, if a library is missing."""
        if not self.is_installed:
            raise BackendMissingError(f"the backend {self.name!r} is not installed. {self.remedy}")


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:  # the package that contains the module is missing
        return False


def load_backend(name: str) -> Backend:
    """Return the backend with a name. Its library is not imported yet.

    >>> load_backend("kinematic").is_installed
    True
    """
    backend: Backend = load_registered("backend", BACKENDS, name)()
    return backend


def loadable_backends() -> Iterator[Backend]:
    """Yield all backends in the order of their names, except those whose packages cannot be imported."""
    for name in backend_names():
        with suppress(BackendMissingError):
            yield load_backend(name)
