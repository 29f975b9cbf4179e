"""What a driver package offers: the backend, what it is given to open a robot, and backends by name."""

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
    from robotcore.hal.finding import Finding
    from robotcore.hal.wiring import Wiring


@dataclass(frozen=True)
class Exported:
    """A model in words.

    ``pictures`` are the files that it names, by their paths beside it; ``notes`` say what is left out.
    """

    text: str
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


OptionsT = TypeVar("OptionsT", bound=StrictModel)


class Capability(str, Enum):
    """A property of a simulator on which runs and tests rely."""

    CONTACTS = "contacts"
    """Its truth counts contacts of the robot with the world."""
    POSE = "pose"
    """Its truth has the exact pose of the robot."""
    LOCKSTEP = "lockstep"
    """Its time passes only when the robot's clock sleeps, so equal runs are equal to the bit."""


@dataclass(frozen=True)
class Setup:
    """What a backend needs to open a robot; ``devices`` are the names to open."""

    robot: RobotDescription
    world: WorldDescription | None
    devices: frozenset[str]
    rate_hz: float = 20.0
    seed: int = 0
    gui: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)

    def options_as(self, model: type[OptionsT]) -> OptionsT:
        """Return the user's options as the backend's own model; UsageError names what is wrong."""
        known = list(model.model_fields)
        for name in self.options:
            if name not in known:
                meant = "" if known else "one of another backend, which --backend names"
                raise UnknownNameError("option", name, known, meant)
        try:
            return model.model_validate(dict(self.options))
        except ValidationError as error:
            key, fault = first_mistake(error)
            raise UsageError(f"option {key}: {fault}") from error

    @property
    def chosen(self) -> tuple[Any, ...]:
        """The descriptions of the devices to open, in the order of the file."""
        return tuple(device for device in self.robot.devices if device.name in self.devices)

    def without_batteries(self) -> Setup:
        """Return the same for a simulator, which has no battery to tell of, and makes none up."""
        batteries = {battery.name for battery in self.robot.all_of(BatteryDescription)}
        return replace(self, devices=self.devices - batteries)

    def open_each(self, open_one: Callable[[Any], Device]) -> list[Device]:
        """Return the devices to open, each opened by its description; raise DeviceGroupError with all that failed."""
        devices, failures = [], []
        for description in self.chosen:
            try:
                devices.append(open_one(description))
            except DeviceError as failure:  # noqa: PERF203  every device that fails is to be named
                failures.append(failure)
        if failures:
            raise DeviceGroupError(f"opening {self.robot.name}", failures)
        return devices


class Backend(ABC):
    """Opens robots of one kind: in one simulator, or on one kind of board."""

    name: ClassVar[str]
    """The name that --backend takes."""
    summary: ClassVar[str]
    """What it is, in a few words, for lists."""
    capabilities: ClassVar[frozenset[Capability]] = frozenset()
    """The properties of its simulator on which runs and tests rely."""
    connection_options: ClassVar[frozenset[str]] = frozenset()
    """The options that override where the robot's file says that the robot is connected."""
    needs_world: ClassVar[bool] = False
    """Whether it simulates the world that it is given."""
    has_gui: ClassVar[bool] = False
    """Whether --gui opens a window."""
    brings_physics: ClassVar[bool] = False
    """Whether it is a physics simulator in this process: no other program has to run."""
    is_exclusive: ClassVar[bool] = False
    """Whether it has one robot or simulator, for which a second program has to wait."""
    is_smoke_tested: ClassVar[bool] = True
    """Whether `robotcore doctor` looks if it is installed and, if it simulates, opens a robot in it."""
    exports: ClassVar[tuple[str, ...]] = ()
    """The formats in which it writes its models."""
    modules: ClassVar[tuple[str, ...]] = ()
    """The libraries that it needs; they are looked for without an import."""

    @abstractmethod
    def open(self, setup: Setup) -> Robot:
        """Open the robot with the devices asked for and nothing else, bare of every layer.

        Raises BackendMissingError, DeviceError or DeviceGroupError; what was opened by then is closed again.
        """

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        """Return the robot to open, by name or from its file; a backend that brings its own returns that.

        ``options`` are the user's. Raises UsageError where there is none.
        """
        return load_robot(robot)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of the batteries whose voltage it tells: every run opens them, whatever its app needs.

        None by default: a simulator has none.
        """
        return frozenset()

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of all devices that it can open: all but the batteries of which it tells nothing."""
        batteries = {battery.name for battery in robot.all_of(BatteryDescription)}
        return frozenset({device.name for device in robot.devices} - batteries) | self.batteries(robot, options)

    def builds_world(self, robot: RobotDescription) -> bool:
        """Whether it makes the world for this robot, and does not find it as it is."""
        return self.needs_world

    def check(self, robot: RobotDescription) -> str:
        """Return what the backend's own section of a robot's file has, in words; nothing where it reads none.

        Raises DescriptionError where the section is wrong.
        """
        return ""

    def warnings(self, robot: RobotDescription) -> Sequence[str]:
        """Return what of a section that is right may do harm all the same, in whole sentences: what, then what to do.

        Raises what `check` raises.
        """
        return ()

    def notes(self, setup: Setup) -> Sequence[str]:
        """Return what whoever runs this must know, in plain words: what of the robot is not what it seems.

        Raises DescriptionError where the section is wrong.
        """
        return ()

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        """Yield findings about this machine for the backend, and about the robot if there is one; none by default.

        `robotcore doctor` adds a smoke test of its own to them if the backend ``is_smoke_tested``.
        """
        return ()

    def inspect_scene(self, setup: Setup) -> Iterable[Finding]:
        """Yield which of a robot's devices are there in the scene that a simulator has open; nothing is moved.

        Raises UsageError where there is no such scene, and BackendError where nobody answers.
        """
        raise UsageError(
            f"the backend {self.name!r} joins nobody's scene, so there is nothing to look at. Leave "
            "--backend out: each section of the file is checked without it"
        )

    def export(
        self, file_format: str, robot: RobotDescription, world: WorldDescription | None, folder: str | None
    ) -> Exported:
        """Return the model of a robot, at the start of a world if there is one, in a format that it ``exports``.

        ``folder`` is the name of one beside the file, for the pictures that the model shows; with None they are left
        out, and a note says so. Raises BackendMissingError.
        """
        raise UsageError(f"the backend {self.name!r} exports no {file_format}. Take --format urdf")

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        """Return how the motors of ``setup.devices`` are made to stand by a process that has nothing of them open.

        For `robotcore stop`, where whoever drove them is gone. None where motors turn no longer than their run, such
        as a simulator's own. Nothing is opened for it. Raises UsageError and DescriptionError.
        """
        return ()

    def wiring(self, robot: RobotDescription) -> Wiring | None:
        """Return where a robot's wires go, as its section says; None where there is nothing to wire.

        Raises DescriptionError where the section is wrong.
        """
        return None

    @property
    def is_native_host(self) -> bool:
        """Whether this machine is the board that it is made for."""
        return False

    @property
    def remedy(self) -> str:
        """How to get what is missing."""
        return f"pip install {' '.join(self.modules)}"

    @property
    def is_installed(self) -> bool:
        return all(_is_there(module) for module in self.modules)

    def require_installed(self) -> None:
        """Raise BackendMissingError, with the remedy, where a library is missing."""
        if not self.is_installed:
            raise BackendMissingError(f"the backend {self.name!r} is not installed. {self.remedy}")


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:  # the package of a dotted name
        return False


def load_backend(name: str) -> Backend:
    """Return the backend of that name; its own library is not imported yet."""
    backend: Backend = load_registered("backend", BACKENDS, name)()
    return backend


def loadable_backends() -> Iterator[Backend]:
    """Yield every backend, by name, but those of somebody's package that is broken."""
    for name in backend_names():
        with suppress(BackendMissingError):
            yield load_backend(name)
