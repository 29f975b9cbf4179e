"""``robotcore test-devices`` finds wrong wires and mountings of a robot's devices, and corrects the robot's file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from robotcore.cli.calibrate._options import CalibratedSetup, calibrated_robot_options, load_calibrated_robot
from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.live_session import open_live_robot
from robotcore.cli.options import parse_pair
from robotcore.cli.output import as_json, redirect_prints, write_finding, write_json
from robotcore.cli.person import choose, read_answer, read_number, require_ready
from robotcore.cli.robot_changes import RobotChanges, write_option
from robotcore.errors import DeviceError, DeviceGroupError, UnknownNameError, UsageError

if TYPE_CHECKING:
    from robotcore.device_test.corrections import Corrections
    from robotcore.hal.check_finding import Finding
    from robotcore.hal.device_test import Question
    from robotcore.interactive.live_robot import LiveRobot

LIFT = (
    "Lift the robot so that its wheels turn freely, keep fingers and cables away from moving parts, and stay beside "
    "the switch of its battery"
)

UNTESTED_KINDS = frozenset({"operator"})
"""The kinds of devices that no robot's file has."""


class TerminalPerson:
    """The person at the terminal, with answers that were given on the command line.

    answers: the answers, by ``DEVICE.TOPIC``.
    """

    def __init__(self, answers: Mapping[str, str]) -> None:
        self._answers = dict(answers)
        self.check: Callable[[], object] = lambda: None
        """Raises the error of an e-stop while the person types."""

    def answer(self, device: str, question: Question) -> str | float | None:
        given = self._answers.get(f"{device}.{question.topic}")
        if given is None:
            if question.choices:
                return choose(question.text, question.choices, self.check)
            return read_number(f"{question.text} (Enter = skip):", lambda _number: "", self.check)
        if question.choices and given not in question.choices:
            raise UnknownNameError(f"answer to {device}.{question.topic}", given, list(question.choices))
        return given if question.choices else _parse_number(device, question.topic, given)

    def follow(self, device: str, topic: str, instruction: str) -> bool:
        if (given := self._answers.get(f"{device}.{topic}")) is not None:
            return given != "skip"
        return read_answer(f"{instruction}. [Enter = ready, s = skip]", self.check) == ""


def _parse_number(device: str, topic: str, answer: str) -> float:
    with suppress(ValueError):
        if math.isfinite(number := float(answer)):
            return number
    text = f"the answer to {device}.{topic} is {answer!r}, which is no number. Give a number such as 0.5"
    raise UsageError(text, kind="no-number", device=device, answer=answer)


@click.command("test-devices", cls=AnsweringCommand)
@calibrated_robot_options
@click.option("--only", "names", metavar="DEVICE", multiple=True, help="Test only this device. Repeatable.")
@click.option(
    "--answer",
    "answers",
    metavar="DEVICE.TOPIC=ANSWER",
    type=parse_pair,
    multiple=True,
    help="Answer a question in advance, such as left_motor.wheel=lf. Repeatable.",
)
@write_option
@as_json
def command(
    robot: str,
    backend: str,
    world: str | None,
    seed: int | None,
    port: str | None,
    options: tuple[tuple[str, str], ...],
    names: tuple[str, ...],
    answers: tuple[tuple[str, str], ...],
    *,
    is_confirmed: bool,
    is_writing: bool,
    as_json: bool,
) -> int:
    """Test each device of a robot, and correct its file.

    The wheels must be off the ground. It finds swapped sides and directions of motors and encoders, dead devices, wrong
    colours and mirrored pictures of cameras, directions and limits of servos, buttons, bumpers, lights, buzzers, line
    sensors, range sensors and IMUs. It moves each device slowly and for a short time, says what should happen, and asks
    what has happened. Encoders measure what they can. Press Enter to skip a question. In a terminal, the space bar
    stops everything.

    In a simulator, the truth answers. On virtualpi, --option truth=FILE is a robot whose wires differ from its file.

    Exit status: 0 all devices work, or all mistakes were written to the file; 1 a device has a mistake.
    """
    setup = load_calibrated_robot(robot, backend, world, seed, options, port=port)
    devices = [device.name for device in setup.description.devices if device.kind not in UNTESTED_KINDS]
    for name in names:
        if name not in devices:
            raise UnknownNameError("device", name, devices)
    changes = RobotChanges(robot, is_writing=is_writing)
    person = TerminalPerson(_check_answers(answers, devices))
    if not setup.is_simulated:
        require_ready(LIFT, is_confirmed=is_confirmed)
    from robotcore.device_test.corrections import Corrections

    tested = _Tested(Corrections(setup.description, setup.backend))
    with redirect_prints(as_json=as_json):
        _test(setup, tested, person, names or devices)
    _apply(changes, tested.corrections)
    changes.finish(setup.backend)
    has_errors = any(finding.level.value == "error" for finding in tested.findings)
    status = 1 if has_errors and not (changes.is_written and tested.is_corrected) else 0
    if as_json:
        findings = [{**asdict(finding), "level": finding.level.value} for finding in tested.findings]
        answer = {"robot": setup.description.name, "findings": findings, "values": changes.values}
        write_json({**answer, "diff": changes.diff, "is_written": changes.is_written, "exit_status": status})
    else:
        changes.show()
    return status


class _Tested:
    """The findings of a test, and the corrections."""

    def __init__(self, corrections: Corrections) -> None:
        self.corrections = corrections
        self.findings: list[Finding] = []
        self.failed: set[str] = set()
        """The names of the devices that do not open."""
        self.is_corrected = False
        """Whether the corrections correct all mistakes."""

    def add(self, finding: Finding) -> None:
        self.findings.append(finding)
        write_finding(finding)


def _check_answers(answers: Iterable[tuple[str, str]], devices: Iterable[str]) -> dict[str, str]:
    for key, _ in answers:
        device, _, topic = key.partition(".")
        if device not in devices:
            raise UnknownNameError("device", device, list(devices))
        if not topic:
            text = f"--answer {key} names no question. Write DEVICE.TOPIC=ANSWER, such as left_motor.wheel=lf"
            raise UsageError(text, kind="answer-without-topic")
    return dict(answers)


def _test(setup: CalibratedSetup, tested: _Tested, person: TerminalPerson, names: Sequence[str]) -> None:
    """Open the devices, and test those that open. Each finding is shown at once."""
    from robotcore.device_test.live_device_test import LiveDeviceTest

    with ExitStack() as opened:
        live = _open(setup, opened, tested)
        person.check = live.require_running
        test = LiveDeviceTest(live, setup.description, tested.corrections, person, tested.add)
        for name in names:
            if name not in live.devices and name not in tested.failed:
                test.skip(name, f"the backend {setup.backend.name!r} does not open it")
        test.test_all(names)
        tested.is_corrected = not tested.failed and not test.has_uncorrected_errors


def _open(setup: CalibratedSetup, opened: ExitStack, tested: _Tested) -> LiveRobot:
    """Open all devices that open. Each of the others has a finding."""
    from robotcore.hal.check_finding import Finding

    everything = frozenset(device.name for device in setup.description.devices)
    while True:
        wants = everything - tested.failed
        try:
            live = open_live_robot(**setup.arguments, wants=wants, has_separate_motors=True)
            return opened.enter_context(live)
        except DeviceError as error:
            failures = error.failures if isinstance(error, DeviceGroupError) else (error,)
            lost = {each.device: each for each in failures if isinstance(each, DeviceError) and each.device in wants}
            if not lost:
                raise
            for name, failure in lost.items():
                tested.failed.add(name)
                problem, _, remedy = str(failure).partition(": ")[2].partition(". ")
                tested.add(Finding.error(name, problem, remedy, kind=failure.kind))


def _apply(changes: RobotChanges, corrections: Corrections) -> None:
    for device, table in corrections.tables.items():
        assert corrections.section
        changes.replace_section(corrections.section, device, table)
    for device, values in corrections.values.items():
        changes.set_device(device, values)
