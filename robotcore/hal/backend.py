"""The interface of a backend, and the arguments with which a backend opens a robot."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from enum import Enum
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from pydantic import ValidationError

from robotcore.description import RobotDescription, StrictModel, WorldDescription, first_mistake, load_robot
from robotcore.errors import BackendMissingError, DeviceError, DeviceGroupError, UnknownNameError, UsageError
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.device import Device
from robotcore.hal.kind import load_kind
from robotcore.hal.robot import Robot
from robotcore.plugins import BACKENDS, backend_names, load_registered

if TYPE_CHECKING:
    from robotcore.hal.check_finding import Finding
    from robotcore.hal.loopback import LoopbackRequest, LoopbackTest
    from robotcore.hal.wiring import Wiring

__all__ = ["Backend", "Capability", "ModelExport", "Setup", "load_backend", "loadable_backends"]


@dataclass(frozen=True)
class ModelExport:
    """The model of a robot, and optionally of its world, in a text format such as URDF.

    >>> model = ModelExport('<robot name="rover"/>', notes=("URDF has no range sensor",))
    >>> model.notes, dict(model.pictures)
    (('URDF has no range sensor',), {})
    """

    text: str
    """The text of the model's file."""
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    """The contents of the picture files to which ``text`` refers, by their paths relative to the model's file."""
    notes: tuple[str, ...] = ()
    """A sentence for each part of the description that the model lacks."""


OptionsT = TypeVar("OptionsT", bound=StrictModel)


class Capability(str, Enum):
    """An ability of a backend's simulator, such as to count contacts.

    >>> from robotcore.hal.backend import load_backend
    >>> sorted(capability.value for capability in load_backend("kinematic").capabilities)
    ['contacts', 'lockstep', 'pose']
    """

    CONTACTS = "contacts"
    """The simulator counts the contacts of the robot with the world."""
    POSE = "pose"
    """The simulator provides the true pose of the robot."""
    LOCKSTEP = "lockstep"
    """Simulated time passes only while the robot's clock sleeps, so that equal runs have bitwise equal results."""


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
    """The world to simulate; None for a backend without a simulated world."""
    devices: frozenset[str]
    """The names of the devices to open."""
    rate_hz: float = 20.0
    """The number of ticks per second."""
    seed: int = 0
    gui: bool = False
    """Whether the simulator opens a window."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """The user's options for the backend."""
    is_ideal: bool = False
    """Whether the simulated devices have none of the imperfections that a robot's file describes.

    ``robot`` has none then.
    """

    def options_as(self, model: type[OptionsT]) -> OptionsT:
        """Return the user's options as an instance of a model. Raises UsageError for an unknown or invalid option."""
        known = list(model.model_fields)
        for name in self.options:
            if name not in known:
                meant = "" if known else "an option for another --backend"
                raise UnknownNameError("option", name, known, meant)
        try:
            return model.model_validate(dict(self.options))
        except ValidationError as error:
            key, problem = first_mistake(error)
            raise UsageError(f"option {key}: {problem}", kind="invalid-option", option=key) from error

    @property
    def chosen_devices(self) -> tuple[Any, ...]:
        """The descriptions of the devices to open, in the order of the robot's file."""
        return tuple(device for device in self.robot.devices if device.name in self.devices)

    def open_each(self, open_one: Callable[[Any], Device]) -> list[Device]:
        """Open all chosen devices, and return them.

        open_one: the function that opens a device. Its argument is the device's description.

        Raises DeviceGroupError with the failures of all devices.
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
    """The base class of backends. A backend opens robots in a simulator, or on a board.

    >>> from robotcore import Robot
    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.backend import Setup
    >>> from robotcore.hal.clock import SteppedClock
    >>> class Empty(Backend):
    ...     name, summary = "empty", "opens a robot without devices"
    ...
    ...     def open(self, setup):
    ...         return Robot(setup.robot.name, SteppedClock(setup.rate_hz, lambda steps: None), devices=[])
    >>> setup = Setup(load_robot("rover"), None, devices=frozenset())
    >>> with Empty().open(setup) as robot:
    ...     robot
    <Robot rover: t=0 s>
    """

    name: ClassVar[str]
    """The backend's name, for the option --backend."""
    summary: ClassVar[str]
    """A description of the backend in a few words, which `robotcore backends` lists."""
    capabilities: ClassVar[frozenset[Capability]] = frozenset()
    """The optional properties that the backend's simulator has."""
    connection_options: ClassVar[frozenset[str]] = frozenset()
    """The names of the options that replace a connection in the robot's file, such as ``port``."""
    needs_world: ClassVar[bool] = False
    """Whether the backend needs a world to simulate."""
    has_gui: ClassVar[bool] = False
    """Whether the option --gui opens a window of the simulator."""
    brings_physics: ClassVar[bool] = False
    """Whether the backend simulates physics in this process, without another program."""
    is_exclusive: ClassVar[bool] = False
    """Whether only one program at a time can use the backend's robot or simulator."""
    is_smoke_tested: ClassVar[bool] = True
    """Whether `robotcore doctor` checks that the backend is installed, and opens a robot if it is a simulator."""
    encoder_rate_hz: ClassVar[float | None] = None
    """The number of times in a second at which a run reads the drive's encoders for the odometry.

    None reads them once a tick. A backend sets it if a read of an encoder takes little time, and if another thread may
    read an encoder too, unless the clock is in lockstep.
    """
    exports: ClassVar[tuple[str, ...]] = ()
    """The formats that `export` supports."""
    modules: ClassVar[tuple[str, ...]] = ()
    """The Python modules that the backend requires. Checks search for them without an import."""

    @abstractmethod
    def open(self, setup: Setup) -> Robot:
        """Open the devices of the setup, and return the robot. The robot has no layers yet.

        Raises BackendMissingError, DeviceError or DeviceGroupError. Then no device stays open.
        """

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        """Return the description of the robot to open.

        Most backends load it from the robot's file. The backend `replay` takes it from the recording.

        robot: the name or the file of a robot.
        options: the user's options.

        Raises UsageError if there is no such robot.
        """
        return load_robot(robot)

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of the devices that the backend can open: by default all that a simulator can have.

        Each run opens the monitored sensors among them, such as a battery, even if its app does not use them.
        """
        return frozenset(device.name for device in robot.devices if load_kind(device.kind).is_simulated)

    def builds_world(self, robot: RobotDescription) -> bool:
        """Return whether the backend builds the world from the world's file, and does not use an existing scene."""
        return self.needs_world

    def check(self, robot: RobotDescription) -> str:
        """Check the backend's section of a robot's file, and return a summary; ``""`` without a section.

        Raises DescriptionError for mistakes in the section.
        """
        return ""

    def warnings(self, robot: RobotDescription) -> Sequence[str]:
        """Return warnings about risks in the backend's section of a robot's file, each with a remedy.

        Raises DescriptionError for mistakes in the section.
        """
        return ()

    def notes(self, setup: Setup) -> Sequence[str]:
        """Return notes for the user of a run, such as the parts of the robot that differ from its description.

        Raises DescriptionError for mistakes in the section.
        """
        return ()

    def list_stand_ins(self, robot: RobotDescription) -> Sequence[str]:
        """Return the names of the devices whose drivers do not run on this backend, so that others stand in for them.

        What is measured with such a device says nothing about the robot of the file.
        """
        return ()

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        """Yield findings about this machine for `robotcore doctor`, and about the robot if there is one.

        The default is none. For a backend with ``is_smoke_tested``, `robotcore doctor` adds a smoke test.
        """
        return ()

    def inspect_scene(self, setup: Setup) -> Iterable[Finding]:
        """Yield a finding for each chosen device about its object in the scene that is open in the simulator.

        The scene does not change. Raises UsageError if the backend has no scenes, and BackendError if the simulator
        does not answer.
        """
        raise UsageError(
            f"the backend {self.name!r} has no scene to check. Without --backend, each section of the file is checked",
            kind="no-scene",
        )

    def export(
        self, file_format: str, robot: RobotDescription, world: WorldDescription | None, folder: str | None
    ) -> ModelExport:
        """Return the model of a robot, and optionally of a world, in a text format.

        file_format: one of ``exports``.
        robot: the robot.
        world: the world, with the robot at its start pose. None exports the robot alone.
        folder: the name of the folder for the model's pictures. None leaves the pictures out.

        Raises UsageError for a format that is not one of ``exports``, and BackendMissingError.
        """
        text = f"the backend {self.name!r} does not export {file_format}. Take --format urdf"
        raise UsageError(text, kind="unknown-format", format=file_format)

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        """Return the specifications of the cutoffs that stop the setup's motors, without opening a device.

        `robotcore stop` uses the cutoffs after a run's process has died. A simulator returns none, because its motors
        end with the process of the run.

        Raises UsageError for wrong options, and DescriptionError for mistakes in the section.
        """
        return ()

    def wiring(self, robot: RobotDescription) -> Wiring | None:
        """Return the wires that the backend's section of a robot's file describes; None for a backend without wires.

        Raises DescriptionError for mistakes in the section.
        """
        return None

    def plan_loopback(self, request: LoopbackRequest) -> LoopbackTest:
        """Return the test of this machine's pins by wires between them, for `robotcore doctor --loopback`.

        Raises UsageError if the backend has no such test, or if the request cannot be tested, and BackendError if this
        machine has no pins that can be used.
        """
        text = f"the backend {self.name!r} has no pins to connect. Use --backend raspberrypi on a Raspberry Pi"
        raise UsageError(text, kind="no-loopback", backend=self.name)

    @property
    def is_native_host(self) -> bool:
        """Whether this machine is a board that the backend drives, such as a Raspberry Pi."""
        return False

    @property
    def remedy(self) -> str:
        """The command that installs the backend's libraries."""
        return f"pip install {' '.join(self.modules)}"

    @property
    def is_installed(self) -> bool:
        return all(_is_there(module) for module in self.modules)

    def require_installed(self) -> None:
        """Raise BackendMissingError if one of ``modules`` is not installed."""
        if not self.is_installed:
            raise BackendMissingError(f"the backend {self.name!r} is not installed. {self.remedy}")


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:  # the package that contains the module is missing
        return False


def load_backend(name: str) -> Backend:
    """Return the backend with a name, without importing its libraries.

    >>> load_backend("kinematic").is_installed
    True
    """
    backend: Backend = load_registered("backend", BACKENDS, name)()
    return backend


def loadable_backends() -> Iterator[Backend]:
    """Yield all registered backends, sorted by name. Backends that cannot be imported are left out.

    >>> [backend.summary for backend in loadable_backends() if backend.name == "mock"]
    ['scripted readings, recorded commands; no physics']
    """
    for name in backend_names():
        with suppress(BackendMissingError):
            yield load_backend(name)
