"""``robotcore test-devices`` finds wrong wires and mountings of a robot's devices, and corrects the robot's file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import parse_pair
from robotcore.cli.output import write_finding
from robotcore.cli.person import TerminalPerson
from robotcore.cli.robot_changes import RobotChanges
from robotcore.cli.robot_session import BENCH, MeasuringCommand, RobotSession, robot_session_options
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


class AnsweringPerson:
    """The person at the terminal, with answers that were given on the command line.

    answers: the answers, by ``DEVICE.TOPIC``.
    """

    def __init__(self, person: TerminalPerson, answers: Mapping[str, str]) -> None:
        self._person, self._answers = person, dict(answers)

    def answer(self, device: str, question: Question) -> str | float | None:
        name = f"{device}.{question.topic}"
        given = self._answers.get(name)
        if given is None:
            prompt = f"{name}: {question.text}"
            if question.choices:
                return self._person.choose(prompt, question.choices)
            return self._person.read_number(f"{prompt} (Enter = skip):")
        if question.choices and given not in question.choices:
            listed = ", ".join(f"{key} = {meaning}" for key, meaning in question.choices.items())
            text = f"unknown answer to {name}: {given!r}. The answers are: {listed}"
            raise UsageError(text, kind=f"unknown-answer-to-{name}", device=device, answer=given)
        return given if question.choices else _parse_number(device, question.topic, given)

    def follow(self, device: str, topic: str, instruction: str) -> bool:
        name = f"{device}.{topic}"
        if (given := self._answers.get(name)) is not None:
            if given not in ("", "ready", "skip"):
                raise UnknownNameError(f"answer to {name}", given, ["ready", "skip"])
            return given != "skip"
        return self._person.confirm(f"{name}: {instruction}")


def _parse_number(device: str, topic: str, answer: str) -> float:
    with suppress(ValueError):
        if math.isfinite(number := float(answer)):
            return number
    text = f"the answer to {device}.{topic} is {answer!r}, which is no number. Give a number such as 0.5"
    raise UsageError(text, kind="no-number", device=device, answer=answer)


@click.command("test-devices", cls=MeasuringCommand)
@robot_session_options(BENCH, has_plot=False)
@click.option("--only", "names", metavar="DEVICE", multiple=True, help="Test only this device. Repeatable.")
@click.option(
    "--answer",
    "answers",
    metavar="DEVICE.TOPIC=ANSWER",
    type=parse_pair,
    multiple=True,
    help="Answer a question in advance, such as left_motor.wheel=lf: the left wheel turned forward. Repeatable.",
)
def command(names: tuple[str, ...], answers: tuple[tuple[str, str], ...], **values: Any) -> int:
    """Test each device of a robot, and correct its file.

    Lift the wheels off the ground. The command finds swapped sides and directions of motors and encoders, dead devices,
    wrong colours and mirrored pictures of cameras, directions and limits of servos, buttons, bumpers, lights, buzzers,
    line sensors, range sensors and IMUs. It moves each device slowly and for a short time, says what should happen, and
    asks what has happened. Encoders measure what they can. Press Enter to skip a question. In a terminal, the space bar
    stops every motor and ends the test. Each question begins with the name that --answer takes.

    In a simulator, the state of the simulated robot answers the questions. On virtualpi, --option truth=FILE simulates
    the robot of FILE, whose wires may differ from those of --robot.

    After an e-stop, Ctrl-C or an error, the findings and the changes of before are shown, but not written. Exit status:
    0 no device has a mistake, or all mistakes were written to the file; 1 a device has a mistake.
    """
    session = RobotSession(**values)
    devices = [device.name for device in session.description.devices if device.kind not in UNTESTED_KINDS]
    for name in names:
        if name not in devices:
            raise UnknownNameError("device", name, devices)
    person = AnsweringPerson(session.person, _check_answers(answers, devices))
    session.prepare(LIFT)
    from robotcore.device_test.corrections import Corrections

    report = _Report(Corrections(session.description, session.backend))
    session.measure(partial(_test, session, report, person, names or devices))
    if session.error:
        session.changes.refuse("the test did not reach its end")
    _apply(session.changes, report.corrections)
    has_errors = any(finding.level.value == "error" for finding in report.findings)

    def find_status() -> int:
        return 1 if has_errors and not (session.changes.is_written and report.is_corrected) else 0

    is_right = all(finding.level.value == "ok" for finding in report.findings)
    return session.finish(
        "The devices", _build_answer(report.findings), lambda: None, find_status=find_status, is_right=is_right
    )


def _build_answer(findings: Iterable[Finding]) -> dict[str, Any]:
    """Return the data about the devices for JSON.

    The JSON keys:

    findings: list of objects; the results of the devices.
    findings[].*: robotcore.hal.check_finding.Finding
    """
    return {"findings": [{**asdict(finding), "level": finding.level.value} for finding in findings]}


class _Report:
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


def _test(session: RobotSession, report: _Report, person: AnsweringPerson, names: Sequence[str]) -> None:
    """Open the devices, and test those that open. Each finding is shown at once."""
    from robotcore.device_test.live_device_test import LiveDeviceTest

    with ExitStack() as opened:
        live = _open(session, opened, report)
        test = LiveDeviceTest(live, session.description, report.corrections, person, report.add)
        for name in names:
            if name not in live.devices and name not in report.failed:
                test.skip(name, f"the backend {session.backend.name!r} does not open it")
        test.test_all(names)
        report.is_corrected = not report.failed and not test.has_uncorrected_errors


def _open(session: RobotSession, opened: ExitStack, report: _Report) -> LiveRobot:
    """Open all devices that open. Each of the others has a finding."""
    from robotcore.hal.check_finding import Finding

    everything = frozenset(device.name for device in session.description.devices)
    while True:
        wants = everything - report.failed
        try:
            return opened.enter_context(session.open(wants=wants, has_separate_motors=True))
        except DeviceError as error:
            failures = error.failures if isinstance(error, DeviceGroupError) else (error,)
            lost = {each.device: each for each in failures if isinstance(each, DeviceError) and each.device in wants}
            if not lost:
                raise
            for name, failure in lost.items():
                report.failed.add(name)
                problem, _, remedy = str(failure).partition(": ")[2].partition(". ")
                report.add(Finding.error(name, problem, remedy, kind=failure.kind))


def _apply(changes: RobotChanges, corrections: Corrections) -> None:
    for device, table in corrections.tables.items():
        assert corrections.section
        changes.replace_section(corrections.section, device, table)
    for device, values in corrections.values.items():
        changes.set_device(device, **values)
