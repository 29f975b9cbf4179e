from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import DeviceLostError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.layers import assemble, timing
from robotcore.runtime.layers.timing import TickTimer
from robotcore.runtime.loop import Loop
from robotcore.runtime.pace import PaceControl
from robotcore.runtime.tick_statistics import PhaseTimes, TickStatistics
from robotcore.safety.velocity_limits import VelocityLimit
from tests.robotcore.fakes import FunctionApp, Rig, picture

READ_RANGE_S, READ_CAMERA_S, STEP_S, RULE_S, MOTOR_S, DISPLAY_S, OBSERVER_S, PHYSICS_S = (2.0**n for n in range(8))
"""The times of the parts of a tick. Each sum of some of them is another number."""


class TimedRun:
    """A loop of three ticks with a fake timer. Each part of a tick takes its own time, in seconds."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.t = 0.0
        self.rig, self.statistics = Rig(), TickStatistics()
        self._patch = monkeypatch
        monkeypatch.setattr(timing, "read_timer", lambda: self.t)
        delays: tuple[tuple[object, str, float], ...] = (
            (self.rig.nose, "_newest", READ_RANGE_S),
            (self.rig.eye, "_newest", READ_CAMERA_S),
            (VelocityLimit, "__call__", RULE_S),
            (self.rig.left, "_apply", MOTOR_S),
            (self.rig.screen, "_apply", DISPLAY_S),
        )
        for owner, name, seconds in delays:
            self._delay(owner, name, seconds)

    def measure(self, step: Callable[[Robot], object], pace: PaceControl | None = None) -> PhaseTimes:
        """Return the greatest times of the phases in the first two of three ticks, in seconds."""
        statuses = [Status.RUNNING, Status.RUNNING, Status.SUCCESS]  # the last tick has no sleep, and does not count

        def decide(robot: Robot) -> Status:
            self.t += STEP_S
            step(robot)
            return statuses.pop(0)

        rig = self.rig
        assembled = assemble(rig.raw, rig.description, rig.rate_hz, timer=TickTimer(self.statistics))
        self._delay(rig.clock, "sleep_until", PHYSICS_S)
        observers = [lambda _: self._spend(OBSERVER_S)]
        loop = Loop(assembled, FunctionApp(decide), rig.rate_hz, 10.0, observers, outage=1.0, pace=pace)
        loop.run()
        found = self.statistics.summarise()
        return PhaseTimes(*(found[phase]["worst"] / 1e6 for phase in PhaseTimes._fields))

    def _spend(self, seconds: float) -> None:
        self.t += seconds

    def _delay(self, owner: object, name: str, seconds: float) -> None:
        function = getattr(owner, name)

        def delayed(*args: object) -> object:
            self._spend(seconds)
            return function(*args)

        self._patch.setattr(owner, name, delayed)


@pytest.fixture
def timed(monkeypatch: pytest.MonkeyPatch) -> TimedRun:
    return TimedRun(monkeypatch)


def test_each_part_of_a_tick_belongs_to_one_phase(timed: TimedRun) -> None:
    def step(robot: Robot) -> None:
        robot.camera.read()
        robot.drive.set_wheels(2.0, 2.0)  # the range guard reads the range sensor
        robot.display.show(picture())

    assert timed.measure(step) == PhaseTimes(
        read=READ_CAMERA_S + READ_RANGE_S,
        decide=STEP_S,
        guard=RULE_S,
        commit=MOTOR_S + DISPLAY_S,
        record=OBSERVER_S,
        sleep=PHYSICS_S,
    )


def test_a_tick_in_which_a_sensor_is_lost_counts(timed: TimedRun) -> None:
    ticks: list[int] = []

    def lose(robot: Robot) -> None:
        ticks.append(1)
        if len(ticks) == 2:
            timed.t += 1000.0
            raise DeviceLostError("eye", "unplugged")

    found = timed.measure(lose)
    assert (found.decide, found.commit, found.sleep) == (STEP_S + 1000.0, 0.0, PHYSICS_S)


def test_a_pause_does_not_count(timed: TimedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    pace = PaceControl(float("inf"))

    def hold(*_: object) -> None:
        timed.t += 1e6
        pace.resume()

    monkeypatch.setattr(pace, "hold", hold)
    found = timed.measure(lambda _: pace.pause(), pace)
    assert max(found) == PHYSICS_S
