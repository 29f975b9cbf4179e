"""The interface by which a kind of device tests its devices on a robot, for `robotcore test-devices`.

The mistakes that a test finds have names, which `DeviceDriver.correct` gets.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from robotcore.description import RobotDescription
from robotcore.hal.check_finding import Finding
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState

__all__ = [
    "AT_OTHER_ANGLES",
    "FLIPPED_HORIZONTALLY",
    "FLIPPED_VERTICALLY",
    "INVERTED",
    "IN_OTHER_ORDER",
    "RED_AND_BLUE_SWAPPED",
    "REVERSED",
    "ROTATED_180",
    "YES_OR_NO",
    "DeviceTest",
    "Question",
]

T = TypeVar("T")

REVERSED = "reversed"
"""A motor, an encoder, a servo or an IMU has the opposite sign."""

INVERTED = "inverted"
"""A switch, a light or a line sensor is on when it should be off."""

IN_OTHER_ORDER = "in-other-order"
"""The parts of a device, such as the colours of a light, are connected in another order.

The observation is a list with the number of the part whose wire belongs to each part: ``[2, 1, 0]`` if the order is
reversed.
"""

FLIPPED_HORIZONTALLY = "mirrored"
"""The columns of a camera's pictures have the opposite order."""

FLIPPED_VERTICALLY = "upside-down"
"""The rows of a camera's pictures have the opposite order."""

ROTATED_180 = "rotated"
"""The columns and the rows of a camera's pictures have the opposite order."""

RED_AND_BLUE_SWAPPED = "red-and-blue-swapped"
"""A camera's pictures have red in place of blue."""

AT_OTHER_ANGLES = "at-other-angles"
"""A servo turns to other angles than commanded.

The observation is a list with the command at which the servo has its least angle and that at which it has its greatest.
A command is a share of the range: 0 is the least angle, 1 the greatest, and others are beyond them.
"""


@dataclass(frozen=True)
class Question:
    """A question about a device. A person answers it, or the truth of a simulator.

    >>> from robotcore.hal.device_test import YES_OR_NO
    >>> question = Question("tone", "Does horn play a tone now?", YES_OR_NO)
    >>> question.choices["y"]
    'yes'
    """

    topic: str
    """A name for the question within its device, such as ``wheel``. The option ``--answer`` refers to it."""
    text: str
    choices: Mapping[str, str] = field(default_factory=dict)
    """The meanings of the answers, by what the person types. Without choices, the answer is a number."""
    answer: Callable[[SimulationState], str | float | None] | None = None
    """Returns the true answer in a simulator; None if the simulator cannot answer."""


YES_OR_NO = {"y": "yes", "n": "no"}
"""The choices of a question that a person answers with yes or no."""


class DeviceTest(ABC):
    """A test of devices in progress. It moves and reads them, asks the person, and collects findings and corrections.

    A test lets time pass only by `run` and the methods that call it. Between these calls, all motors stand.

    >>> from robotcore.hal.device_test import YES_OR_NO, Question
    >>> def test_lamps(test: DeviceTest, lamps) -> None:  # `test_devices` of a Kind
    ...     for lamp in lamps:
    ...         test.repeat(lambda: test.robot[lamp.name].set_brightness(1.0), seconds=0.5)
    ...         if test.ask(lamp.name, Question("on", f"Is {lamp.name} on?", YES_OR_NO)) == "y":
    ...             test.confirm(lamp.name, "shines")
    """

    robot: Robot
    """The open robot. It has no drive: each motor takes commands of its own."""
    description: RobotDescription
    """The description of the robot, with its drive."""
    state: SimulationState | None
    """The true state of the simulated robot, which may differ from ``description``; None on a real robot."""

    @abstractmethod
    def run(self, routine: Generator[None, None, T]) -> T:
        """Run a routine, which yields once in each tick, to its end. Return its result."""

    @abstractmethod
    def ask(self, device: str, question: Question) -> str | float | None:
        """Return the answer to a question: a key of its choices, or a number. None if the person cannot answer."""

    @abstractmethod
    def instruct(
        self, device: str, topic: str, instruction: str, act: Callable[[SimulationState], object] | None = None
    ) -> bool:
        """Ask the person to do something now, such as to press a button. Return False if no person can do it.

        topic: a name for the instruction within its device. The option ``--answer`` refers to it.
        act: does it in a simulator. With None, a simulator cannot do it.
        """

    @abstractmethod
    def add(self, finding: Finding) -> None:
        """Add a finding. Its subject is the name of a device."""

    @abstractmethod
    def skip(self, device: str, reason: str) -> None:
        """Report that a device, or a part of it, was not tested."""

    @abstractmethod
    def correct(
        self, device: str, message: str, mistake: str, observed: Any = None, *, remedy: str, kind: str = ""
    ) -> bool:
        """Add an error for a mistake that settings of the device's driver may correct. Return whether they correct it.

        message: what is wrong.
        mistake: the name of the mistake, see `DeviceDriver.correct`.
        remedy: what the user must do if no setting corrects it.
        kind: the kind of the finding; by default, the name of the mistake.
        """

    @abstractmethod
    def swap_tables(self, sources: Mapping[str, str], message: str, *, remedy: str, kind: str) -> None:
        """Add an error for devices whose wires are swapped, and give each device the table of another one.

        sources: the name of the device whose wires belong to each device, by its name.
        remedy: what the user must do if the backend has no tables of wires.
        """

    @abstractmethod
    def correct_description(self, device: str, message: str, *, remedy: str, kind: str, **values: Any) -> None:
        """Add an error for values of the device's description, and correct them."""

    @abstractmethod
    def has_own_direction(self, device: str) -> bool:
        """Return whether an encoder measures the direction. If not, it takes that of the motor's command."""

    def wait(self, seconds: float) -> None:
        """Let a time in seconds pass."""
        self.repeat(lambda: None, seconds)

    def repeat(self, action: Callable[[], object], seconds: float) -> None:
        """Call a function once in each tick for a time in seconds, such as a motor's command."""
        self.wait_until(lambda: bool(action()) and False, seconds)

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Let time pass until a condition holds. Return False if the time in seconds is over before."""

        def wait() -> Generator[None, None, bool]:
            end = self.robot.clock.now() + timeout_s - 1e-9
            while self.robot.clock.now() < end:
                if condition():
                    return True
                yield
            return condition()

        return self.run(wait())

    def confirm(self, device: str, message: str, kind: str = "works") -> None:
        """Add a finding that a device works."""
        self.add(Finding.ok(device, message, kind=kind))

    def fail(self, device: str, message: str, remedy: str, kind: str) -> None:
        """Add an error that no change of the robot's file corrects."""
        self.add(Finding.error(device, message, remedy, kind=kind))

    def warn(self, device: str, message: str, remedy: str, kind: str) -> None:
        """Add a warning."""
        self.add(Finding.warning(device, message, remedy, kind=kind))
