"""Tests the devices of a live robot, kind by kind."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from robotcore.description import RobotDescription
from robotcore.device_test.corrections import Corrections
from robotcore.errors import DeviceError, UsageError
from robotcore.hal.check_finding import Finding
from robotcore.hal.device import Actuator, Sensor
from robotcore.hal.device_test import DeviceTest, Question
from robotcore.hal.kind import load_kind
from robotcore.hal.simulation_state import SimulationState
from robotcore.interactive.live_robot import LiveRobot

T = TypeVar("T")

NOT_TESTED = "not-tested"
"""The kind of the finding for a device that was not tested."""


class Person(Protocol):
    """The person beside the robot."""

    def answer(self, device: str, question: Question) -> str | float | None:
        """Return the person's answer: a key of the question's choices, or a number; None without an answer."""

    def follow(self, device: str, topic: str, instruction: str) -> bool:
        """Let the person follow an instruction. Return False if no person does it."""


class LiveDeviceTest(DeviceTest):
    """Tests the devices of a live robot. The truth of a simulator answers questions that the person does not answer.

    live: the open robot, whose motors take commands of their own.
    description: the description of the robot, with its drive.
    corrections: collects the corrections of the robot's file.
    person: answers questions and follows instructions.
    write: shows a finding at once.
    """

    def __init__(
        self,
        live: LiveRobot,
        description: RobotDescription,
        corrections: Corrections,
        person: Person,
        write: Callable[[Finding], object] = lambda _finding: None,
    ) -> None:
        self.robot: LiveRobot = live
        self.description = description
        self.state: SimulationState | None = live.ground_truth.state if live.ground_truth else None
        self.findings: list[Finding] = []
        self.has_uncorrected_errors = False
        """Whether a device has an error that no change of the file corrects."""
        self._corrections, self._person, self._write = corrections, person, write

    def test_all(self, names: Sequence[str]) -> None:
        """Test devices, kind by kind in the order of the robot's file, the sensors before the actuators.

        A simulated robot stands on the floor, so its motors move it away from what its sensors see.

        names: the names of the devices. Those that are not open are left out.

        Raises the errors that end a session, other than those of devices: SafetyStop and BackendError.
        """
        devices = [each for each in self.description.devices if each.name in names and each.name in self.robot.devices]
        kinds = dict.fromkeys(device.kind for device in devices)
        for kind in sorted(kinds, key=lambda kind: not issubclass(load_kind(kind).device, Sensor)):
            chosen = [device for device in devices if device.kind == kind]
            try:
                (load_kind(kind).test_devices or _test_plainly)(self, chosen)
            except DeviceError as error:
                self.fail(error.device, str(error).partition(": ")[2], "Check its wires and its supply", error.kind)
            except UsageError as error:
                if error.kind != "robot-stopped":
                    raise
                for device in chosen:
                    self.skip(device.name, "the robot was stopped by the error above. Correct it, and repeat the test")

    def run(self, routine: Generator[None, None, T]) -> T:
        result: T = self.robot.run(routine)
        return result

    def ask(self, device: str, question: Question) -> str | float | None:
        given = self._person.answer(device, question)
        if given is None and self.state and question.answer:
            return question.answer(self.state)
        return given

    def instruct(
        self, device: str, topic: str, instruction: str, act: Callable[[SimulationState], object] | None = None
    ) -> bool:
        if self.state and act:
            act(self.state)
            return True
        return self._person.follow(device, topic, instruction)

    def add(self, finding: Finding) -> None:
        self.findings.append(finding)
        self._write(finding)

    def fail(self, device: str, message: str, remedy: str, kind: str) -> None:
        self.has_uncorrected_errors = True
        super().fail(device, message, remedy, kind)

    def skip(self, device: str, reason: str) -> None:
        self.add(Finding.warning(device, f"not tested: {reason}", "", kind=NOT_TESTED))

    def correct(
        self, device: str, message: str, mistake: str, observed: Any = None, *, remedy: str, kind: str = ""
    ) -> bool:
        settings = self._corrections.correct(device, mistake, observed)
        if settings is None:
            self.fail(device, message, remedy, kind or mistake)
            return False
        self.add(Finding.error(device, message, f"The changes set {_list(settings)}", kind=kind or mistake))
        return True

    def swap_tables(self, sources: Mapping[str, str], message: str, *, remedy: str, kind: str) -> None:
        names = " and ".join(sorted(sources))
        if self._corrections.swap(sources):
            self.add(Finding.error(min(sources), message, f"The changes swap the tables of {names}", kind=kind))
        else:
            self.fail(min(sources), message, remedy, kind)

    def correct_description(self, device: str, message: str, *, remedy: str, kind: str, **values: Any) -> None:
        self._corrections.correct_description(device, values)
        self.add(Finding.error(device, message, f"The changes set {_list(values)}", kind=kind))

    def has_own_direction(self, device: str) -> bool:
        driver = self._corrections.get_driver(device)
        return driver is None or driver.has_own_direction


def _test_plainly(test: DeviceTest, devices: Sequence[Any]) -> None:
    """Read each sensor of a kind without a test of its own. Actuators are not tested."""
    for description in devices:
        device = test.robot[description.name]
        if isinstance(device, Actuator):
            test.skip(device.name, f"the kind {description.kind!r} has no test")
        elif isinstance(device, Sensor):
            test.wait(0.5)
            sample = device.read()
            text = f"reads {device.format_sample(sample)}"
            if problem := device.find_problem(sample):
                test.warn(device.name, text, problem, "sensor-problem")
            else:
                test.confirm(device.name, text)


def _list(values: Mapping[str, Any]) -> str:
    """Return keys and values as in a robot's file, such as ``a = 21, b = 20``."""
    return ", ".join(
        f"{key} = {str(value).lower() if isinstance(value, bool) else value}" for key, value in values.items()
    )
