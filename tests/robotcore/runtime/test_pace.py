from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from robotcore.errors import EmergencyStopError, Interrupted, UsageError, WatchdogError
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.behaviour import Status
from robotcore.runtime.loop import Loop
from robotcore.runtime.pace import POLL_S, PaceControl
from robotcore.safety.latch import EmergencyStop
from robotcore.safety.watchdog import TimeLimit
from tests.robotcore.fakes import FunctionApp, Rig
from tests.texts import Raises

TICK_S = 0.05
LIMIT = TimeLimit(0.5, lambda *_: WatchdogError("the loop hangs"), 1.0)


class FakeWall:
    """Replaces the real clock. Time passes only in sleeps; ``on_sleep`` is called in each."""

    def __init__(self) -> None:
        self.t = 1000.0
        self.on_sleep: Callable[[], object] = lambda: None

    def now(self) -> float:
        return self.t

    def sleep_until(self, deadline: float) -> bool:
        self.t = max(self.t, deadline)
        self.on_sleep()
        return True


class PacedRun:
    """A loop on a simulator whose tick takes ``work_s`` of real time, with a pace."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, speed: float = 1.0, ticks: int = 4) -> None:
        self.wall, self.work_s = FakeWall(), 0.01
        self.rig, self.pace = Rig(), PaceControl(speed)
        monkeypatch.setattr(self.pace, "_wall", self.wall)
        self.times: list[float] = []
        self.on_tick: Callable[[], object] = lambda: None
        self.check: Callable[[], object] = lambda: None
        self._ticks = ticks
        self.loop = Loop(
            self.rig.assembled,
            FunctionApp(self._step),
            1 / TICK_S,
            100.0,
            build_step_limit=LIMIT,
            observer_limit=LIMIT,
            pace=self.pace,
            check_signals=self._check,
        )

    def _check(self) -> None:
        self.check()

    @property
    def gaps(self) -> list[float]:
        """The real times between two ticks."""
        return [later - sooner for sooner, later in zip(self.times, self.times[1:], strict=False)]

    def _step(self, robot: Robot) -> Status:
        robot.drive.set_wheels(2.0, 2.0)
        self.times.append(self.wall.t)
        self.wall.t += self.work_s
        self.on_tick()
        return Status.SUCCESS if len(self.times) == self._ticks else Status.RUNNING


@pytest.fixture
def paced(monkeypatch: pytest.MonkeyPatch) -> Callable[..., PacedRun]:
    return partial(PacedRun, monkeypatch)


class TestSpeed:
    @pytest.mark.parametrize("speed", [0.01, 0.5, 1.0, 4.0])
    def test_ticks_follow_each_other_at_the_speed(self, paced: Callable[..., PacedRun], speed: float) -> None:
        run = paced(speed)
        run.loop.run()
        assert run.gaps == pytest.approx([TICK_S / speed] * 3)
        assert run.loop.overruns == 0

    def test_without_a_limit_the_loop_never_waits(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(math.inf)
        run.wall.on_sleep = pytest.fail
        run.loop.run()
        assert run.gaps == pytest.approx([0.01] * 3)

    def test_a_new_speed_holds_at_once(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(0.001)

        def speed_up() -> None:
            run.pace.speed, run.wall.on_sleep = 1.0, lambda: None

        run.wall.on_sleep = speed_up
        run.loop.run()
        assert run.gaps == pytest.approx([0.01 + POLL_S, TICK_S, TICK_S])

    def test_the_same_speed_again_changes_nothing(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(1.0)
        run.wall.on_sleep = run.on_tick = lambda: setattr(run.pace, "speed", 1.0)
        run.loop.run()
        assert run.gaps == pytest.approx([TICK_S] * 3)

    def test_a_machine_that_is_too_slow_for_real_time_has_overruns_and_loses_the_time(
        self, paced: Callable[..., PacedRun]
    ) -> None:
        run = paced(1.0)
        slowness = [0.2, 0.01, 0.01, 0.01]
        run.on_tick = lambda: setattr(run.wall, "t", run.wall.t + slowness.pop(0))
        run.loop.run()
        assert run.gaps == pytest.approx([0.21, TICK_S, TICK_S])
        assert run.loop.overruns == 1

    def test_a_machine_that_is_too_slow_for_a_high_speed_has_no_overruns(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(50.0)
        run.loop.run()
        assert run.gaps == pytest.approx([0.01] * 3)
        assert run.loop.overruns == 0

    @pytest.mark.parametrize("speed", [0, -1.0, math.nan, -math.inf, "fast", None])
    def test_a_speed_that_is_not_positive_is_refused_and_changes_nothing(self, speed: object, raises: Raises) -> None:
        pace = PaceControl(2.0)
        with raises(UsageError, "speed-not-positive", speed=speed):
            pace.speed = speed  # type: ignore[assignment]
        assert pace.speed == 2.0


class TestPause:
    @pytest.mark.parametrize("speed", [1.0, math.inf])
    def test_no_tick_runs_until_the_run_is_resumed(self, paced: Callable[..., PacedRun], speed: float) -> None:
        run = paced(speed)
        run.on_tick = run.pace.pause
        naps: list[float] = []

        def resume_after_a_minute() -> None:
            naps.append(run.wall.t)
            if run.wall.t - run.times[-1] >= 60.0:
                run.pace.resume()

        run.wall.on_sleep = resume_after_a_minute
        run.loop.run()
        assert run.gaps == pytest.approx([60.0] * 3, abs=0.1)
        assert run.loop.overruns == 0

    def test_the_time_of_a_pause_is_no_overrun_of_the_next_tick(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(1.0)
        run.on_tick = lambda: run.pace.pause() if len(run.times) == 1 else None
        run.wall.on_sleep = lambda: run.pace.resume() if run.wall.t > 1060.0 else None
        run.loop.run()
        assert run.gaps == pytest.approx([60.0, TICK_S, TICK_S], abs=0.1)
        assert run.loop.overruns == 0

    def test_a_run_that_is_paused_before_its_first_tick_waits_for_it(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(ticks=1)
        run.pace.pause()
        run.wall.on_sleep = run.pace.resume
        run.loop.run()
        assert run.times == pytest.approx([1000.0 + POLL_S])

    def test_each_step_runs_one_tick(self, paced: Callable[..., PacedRun]) -> None:
        run = paced(ticks=6)
        run.pace.pause()
        actions = [
            run.pace.step,
            lambda: counts.append(len(run.times)),
            lambda: run.pace.step(3),
            lambda: counts.append(len(run.times)),
            run.pace.resume,
        ]
        counts: list[int] = []
        run.wall.on_sleep = lambda: actions.pop(0)() if actions else None
        run.loop.run()
        assert counts == [1, 4]

    def test_resume_forgets_the_steps_that_are_left(self) -> None:
        pace = PaceControl(math.inf)
        pace.pause()
        pace.step(5)
        pace.resume()
        pace.pause()
        with pytest.raises(Interrupted):
            pace.hold(0.0, _interrupt)

    def test_a_step_without_a_pause_is_refused(self, raises: Raises) -> None:
        with raises(UsageError, "not-paused"):
            PaceControl().step()

    @pytest.mark.parametrize("ticks", [0, -1, 1.5])
    def test_a_step_of_no_whole_tick_is_refused(self, ticks: Any, raises: Raises) -> None:
        pace = PaceControl()
        pace.pause()
        with raises(UsageError, "no-ticks", ticks=ticks):
            pace.step(ticks)


def _interrupt() -> None:
    raise Interrupted(2)


@pytest.mark.parametrize("speed", [0.001, 1.0])
class TestEndWhileWaiting:
    def test_the_e_stop_ends_a_waiting_run(self, paced: Callable[..., PacedRun], speed: float, raises: Raises) -> None:
        run = _wait_after_first_tick(paced, speed)
        run.wall.on_sleep = partial(EmergencyStop(run.rig.assembled.latch).press, "pressed")
        with raises(EmergencyStopError):
            run.loop.run()
        assert (len(run.times), run.rig.wheels) == (1, (0.0, 0.0))

    def test_a_signal_ends_a_waiting_run(self, paced: Callable[..., PacedRun], speed: float) -> None:
        run = _wait_after_first_tick(paced, speed)
        run.wall.on_sleep = lambda: setattr(run, "check", _interrupt)
        with pytest.raises(Interrupted):
            run.loop.run()
        assert len(run.times) == 1

    def test_no_time_limit_of_the_watchdog_holds(self, paced: Callable[..., PacedRun], speed: float) -> None:
        run = _wait_after_first_tick(paced, speed)
        limits: list[object] = []

        def note_limits() -> None:
            limits.append((run.rig.assembled.activity.activity, run.rig.assembled.activity.call))
            run.check = _interrupt

        run.wall.on_sleep = note_limits
        with pytest.raises(Interrupted):
            run.loop.run()
        assert limits == [(None, None)]


def _wait_after_first_tick(paced: Callable[..., PacedRun], speed: float) -> PacedRun:
    """Return a run that waits after its first tick: for long at a low speed, else in a pause."""
    run = paced(speed)
    if speed == 1.0:
        run.on_tick = run.pace.pause
    return run


def test_the_real_clock_paces_a_run() -> None:
    clock, pace = MonotonicClock(), PaceControl(5.0)
    begun = clock.now()
    Loop(Rig().assembled, FunctionApp(lambda _: Status.RUNNING), 20, 0.5, pace=pace).run()
    assert clock.now() - begun >= 0.09
