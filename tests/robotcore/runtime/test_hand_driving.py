"""A person drives in place of an app, within the same safety stage, and a replay repeats it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, cast

import pytest

from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, RunResult, Status, run
from robotcore.autonomy.routines import Routine
from robotcore.errors import DeviceLostError, EmergencyStopError
from robotcore.kinds.operator import OperatorCommand
from robotcore.recording.replay import replay
from robotcore.runtime.observer import RunContext
from robotcore.runtime.operator_input import LEASE_S, OperatorInput
from robotcore.runtime.trace import TickRecord
from robotcore.safety.velocity_limits import STOPPED
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import Memory
from tests.robotcore.runs import Watcher

Act = Callable[[OperatorInput], object]


class Forward(Behaviour):
    """Drives forward, and counts its steps."""

    needs: ClassVar = {Role.DRIVE}
    steps: ClassVar[list[float]] = []

    def step(self, robot: Robot) -> Status:
        self.steps.append(robot.clock.now())
        robot.drive.set_velocity(0.1, 0.0)
        return Status.RUNNING


class Sequence(Behaviour):
    """Counts the ticks of its generator."""

    needs: ClassVar = {Role.DRIVE}
    times: ClassVar[list[float]] = []

    def run(self, robot: Robot) -> Routine[Status]:
        for _ in range(10):
            self.times.append(robot.clock.now())
            yield
        return Status.SUCCESS


class SequenceWithCamera(Sequence):
    """Has a camera, and does not read it."""

    needs: ClassVar = {Role.DRIVE, Role.CAMERA}


class Person:
    """An observer that acts after ticks. ``every`` acts after each tick of a range, and ``once`` after one."""

    def __init__(self, *every: tuple[range, Act], once: Mapping[int, Act] | None = None) -> None:
        self._every, self._once = every, once or {}
        self.records: list[TickRecord] = []
        self.context: RunContext

    def begin(self, run: RunContext) -> None:
        self.context = run

    def tick(self, record: TickRecord) -> None:
        assert self.context.operator
        self.records.append(record)
        for ticks, act in self._every:
            if record.tick in ticks:
                act(self.context.operator)
        if act_once := self._once.get(record.tick):
            act_once(self.context.operator)

    def end(self, result: RunResult) -> None:
        pass


def advance(operator: OperatorInput) -> None:
    operator.drive(0.2, 0.0)


def release(operator: OperatorInput) -> None:
    operator.release()


def drive(app: Any, person: Person, **asked: Any) -> RunResult:
    return run(RunRequest(app, **{"world": "open", "timeout_s": 2.0, "has_operator": True, **asked}), [person])


@pytest.fixture(autouse=True)
def _forget() -> None:
    Forward.steps.clear()
    Sequence.times.clear()


def test_the_app_is_not_called_while_a_person_drives_and_the_wheels_stop_in_between() -> None:
    person = Person((range(9, 20), advance), once={20: release})
    drive(Forward, person)
    sent = {record.tick: record.sent for record in person.records}
    assert sent[10] == sent[21] == STOPPED
    assert [round(time * 20) for time in Forward.steps] == [*range(10), *range(22, 41)]
    assert sent[19]
    assert sent[19].left == pytest.approx(0.2 / wheel_radius(person))


def wheel_radius(person: Person) -> float:
    return person.context.robot.drive.geometry.wheel_radius


def test_a_person_commands_servos_but_not_the_steering() -> None:
    person = Person()
    drive(Forward, person, robot="picar", timeout_s=0.1)
    assert person.context.operator
    assert "steering" in person.context.robot.devices
    assert "steering" not in person.context.operator.actuators


def test_the_generator_of_an_app_stands_still_meanwhile() -> None:
    result = drive(Sequence, Person((range(3, 12), advance), once={12: release}))
    assert result.outcome is Outcome.SUCCESS
    assert [round(time * 20) for time in Sequence.times] == [0, 1, 2, 3, *range(14, 20)]


def test_without_a_person_the_app_runs_as_in_a_run_that_is_not_steerable() -> None:
    request = RunRequest("green-search", seed=7, timeout_s=3.0)
    other = RunRequest("green-search", seed=7, timeout_s=3.0, has_operator=True)
    assert run(request).trace_sha256 == run(other).trace_sha256


def test_a_run_that_is_not_steerable_has_no_operator() -> None:
    watcher = Watcher()
    run(RunRequest(Forward, timeout_s=0.2), [watcher])
    (context,) = (each for name, each in watcher.calls if name == "begin")
    assert context.operator is None
    assert "operator" not in context.robot.devices


def test_the_wheels_stop_at_once_if_the_person_is_silent_and_the_app_does_not_continue(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fall_silent(_operator: OperatorInput) -> None:
        monkeypatch.setattr("robotcore.runtime.operator_input.LEASE_S", -1.0)

    person = Person((range(5, 40), advance), once={20: fall_silent})
    drive(Forward, person)
    sent = {record.tick: record.sent for record in person.records}
    assert LEASE_S > 0
    assert sent[20] != STOPPED
    assert {sent[tick] for tick in range(21, 40)} == {STOPPED}
    assert len(Forward.steps) == 6


def test_the_range_guard_stops_a_person_too() -> None:
    person = Person((range(200), advance))
    result = drive(Forward, person, world="arena", timeout_s=8.0)
    assert result.intervention_s.get("range guard", 0.0) > 1.0
    assert result.contacts == 0


def test_the_velocity_limit_holds_for_a_person_too() -> None:
    person = Person((range(40), lambda operator: operator.drive(100.0, 0.0)))
    drive(Forward, person)
    limit = person.context.robot.drive.max_linear / wheel_radius(person)
    assert max(record.sent.left for record in person.records if record.sent) == pytest.approx(limit)


def test_an_emergency_stop_ends_a_run_that_a_person_drives() -> None:
    person = Person((range(40), advance), once={20: lambda operator: person.context.emergency.press("pressed")})
    result = drive(Forward, person)
    assert isinstance(result.error, EmergencyStopError)
    assert person.records[-1].tick == 21


SERVO = '[[devices]]\nkind = "servo"\nname = "pan"\nmin_angle_rad = -1.0\nmax_angle_rad = 1.0\nmax_velocity_rad_s = 5.0'
LAMP = '[[devices]]\nkind = "led"\nname = "lamp"\nis_rgb = true'
ARM = '[[devices]]\nkind = "motor"\nname = "arm"\nmax_velocity_rad_s = 4.0'


WAVE = """
from robotcore import Behaviour, Role, Status
from robotcore.kinds import Led, Servo


class Wave(Behaviour):
    needs = {Role.DRIVE, Role.RANGE, Servo, Led, "arm"}

    def step(self, robot):
        robot["arm"].set_velocity(1.0)
        return Status.RUNNING
"""


@pytest.fixture
def _wave(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wave.py").write_text(WAVE)
    Path("driven.toml").write_text(f"{ROVER}\n{SERVO}\n{LAMP}\n{ARM}")


HONK = """
from robotcore import Behaviour, Role, Status
from robotcore.kinds import Buzzer


class Honk(Behaviour):
    needs = {Role.DRIVE, Buzzer}

    def step(self, robot):
        return Status.RUNNING
"""


@pytest.fixture
def _horn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("honk.py").write_text(HONK)
    Path("loud.toml").write_text(f'{ROVER}\n[[devices]]\nkind = "buzzer"\nname = "horn"')


@pytest.mark.usefixtures("_wave")
def test_a_command_to_an_actuator_is_sent_once_and_limited() -> None:
    def turn(operator: OperatorInput) -> None:
        operator.command("pan", 9.0)
        operator.command("lamp", [1.0, 0.5, 0.0])

    memory = Memory()
    request = RunRequest("wave.py", robot="driven.toml", world="open", timeout_s=1.0, has_operator=True)
    run(request, [memory, Person(once={5: turn, 15: release})], [memory.layer])
    commands = [(tick.number, each.device, each.given) for tick in memory.ticks for each in tick.commands]
    assert commands == [(7, "pan", 1.0), (7, "lamp", [1.0, 0.5, 0.0])]
    arm = {tick.number: [each.asked for each in tick.motor_asks] for tick in memory.ticks}
    assert arm[5] == [1.0]
    assert arm[6] == [None]  # the motor outside the drive stops
    assert arm[10] == []
    assert replay(memory.recording).is_equal
    assert replay(memory.recording).is_exact


@pytest.mark.usefixtures("_horn")
@pytest.mark.parametrize("end", ["release", "silence"])
def test_a_buzzer_of_the_person_is_silent_after_the_person(monkeypatch: pytest.MonkeyPatch, end: str) -> None:
    def finish(operator: OperatorInput) -> None:
        if end == "release":
            operator.release()
        else:
            monkeypatch.setattr("robotcore.runtime.operator_input.LEASE_S", -1.0)

    memory = Memory()
    person = Person((range(3, 15), advance), once={6: lambda operator: operator.command("horn", 440.0), 15: finish})
    request = RunRequest("honk.py", robot="loud.toml", world="open", timeout_s=1.0, has_operator=True)
    run(request, [memory, person], [memory.layer])
    commands = [(tick.number, each.device, each.given) for tick in memory.ticks for each in tick.commands]
    assert commands == [(7, "horn", 440.0), (16, "horn", 0.0)]
    assert replay(memory.recording).is_equal
    assert replay(memory.recording).is_exact


@pytest.mark.usefixtures("_wave")
def test_the_sensors_are_read_while_a_person_drives() -> None:
    memory = Memory()
    request = RunRequest("wave.py", robot="driven.toml", world="open", timeout_s=1.0, has_operator=True)
    run(request, [memory, Person((range(5, 40), advance))], [memory.layer])
    read = {tick.number: {each.device for each in tick.reads if each.by is None} for tick in memory.ticks}
    assert "nose" not in read[5]
    assert {"nose", "operator"} <= read[15]


WEAVE = """
from robotcore import Behaviour, Role, Status
from robotcore.autonomy.manoeuvres import straight, turn


class Weave(Behaviour):
    needs = {Role.DRIVE, Role.RANGE}

    def run(self, robot):
        while True:
            yield from straight(robot, 0.1)
            yield from turn(robot, 0.5)
"""


@pytest.mark.parametrize(
    "faults",
    [
        (),
        ("operator drop=0.3",),
        ("operator delay=0.2 after=0.5", "left_encoder delay=0.05"),
        ("operator freeze after=1",),
    ],
)
@pytest.mark.parametrize("app", ["green-search", "weave.py"])
def test_a_hand_driven_run_replays_equal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, app: str, faults: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("weave.py").write_text(WEAVE)
    memory = Memory()
    person = Person(
        (range(9, 30), lambda operator: operator.drive(0.2, 0.7)),
        (range(45, 60), lambda operator: operator.drive(-0.1, -1.0)),
        once={30: release, 60: release},
    )
    request = RunRequest(app, seed=7, timeout_s=4.0, has_operator=True, faults=faults)
    run(request, [memory, person], [memory.layer])
    found = replay(memory.recording)
    assert found.deviation is None
    assert found.is_equal
    assert found.is_exact
    assert found.ticks == len(memory.ticks)
    assert any(read.device == "operator" for tick in memory.ticks for read in tick.reads)


def test_a_lost_operator_ends_the_run() -> None:
    result = drive(Forward, Person((range(40), advance)), faults=("operator lost=1 after=1",))
    assert isinstance(result.error, DeviceLostError)


def test_a_lost_sensor_that_the_routine_has_not_read_does_not_stop_the_person(tmp_path: Path) -> None:
    robot = tmp_path / "patient.toml"
    robot.write_text(ROVER.replace("[safety]", "[safety]\noutage_s = 5.0"))
    person = Person((range(4, 60), advance))
    result = drive(SequenceWithCamera, person, robot=str(robot), faults=("camera lost=1 after=0.5",))
    assert result.outcome is Outcome.TIMEOUT
    sent = {record.tick: record.sent for record in person.records}
    assert not {sent[tick] for tick in range(8, 39)} & {STOPPED, None}


@pytest.mark.parametrize("device", ["nose", "missing"])
def test_a_recorded_command_to_no_actuator_is_ignored(device: str) -> None:
    memory = Memory()
    person = Person(once={5: lambda operator: operator.drive(0.1, 0.0)})
    run(RunRequest("avoid-obstacles", timeout_s=1.0, has_operator=True), [memory, person], [memory.layer])
    changed = {
        key: replace(sample, commands=(OperatorCommand(device, (0.5,), 1),)) if key.device == "operator" else sample
        for key, sample in memory.samples.items()
        for sample in [cast("Any", sample)]
    }
    assert replay(replace(memory.recording, samples=changed)).is_equal
