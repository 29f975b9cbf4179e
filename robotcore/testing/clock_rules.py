"""Rules for the clock: it fits the tick, stands still unless somebody sleeps, and makes calls on time."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robotcore.errors import UsageError
from robotcore.hal.backend import Vouch
from robotcore.testing.bench import Bench

RATES_HZ = (10.0, 20.0, 30.0, 50.0)


class ClockRules(Bench):
    """What every robot's clock owes."""

    def test_time_begins_at_zero(self) -> None:
        self.require(Vouch.LOCKSTEP)
        with self.opened() as robot:
            assert (now := robot.clock.now()) == 0, f"just opened, the clock says {now} s; it counts from the opening"

    def test_time_never_goes_back(self) -> None:
        with self.opened() as robot:
            times = [robot.clock.now()]
            for _ in range(5):
                robot.clock.sleep_until(times[-1] + 0.02)
                times.append(robot.clock.now())
        assert times == sorted(times), f"the clock went back: {times}"

    def test_sleeping_ends_no_earlier_than_asked(self) -> None:
        with self.opened() as robot:
            deadline = robot.clock.now() + 0.1
            robot.clock.sleep_until(deadline)
            now = robot.clock.now()
        assert now >= deadline - 1e-9, f"sleep_until({deadline}) ended at {now}"

    @pytest.mark.parametrize("rate_hz", RATES_HZ)
    def test_steps_divide_the_tick(self, rate_hz: float) -> None:
        self.require(Vouch.LOCKSTEP)
        try:
            robot = self.open(replace(self.setup_for(), rate_hz=rate_hz))
        except UsageError as refusal:
            pytest.skip(f"it refuses {rate_hz} Hz: {refusal}")
        with robot:
            for tick in range(1, 6):
                robot.clock.sleep_until(tick / rate_hz)
                assert robot.clock.now() == pytest.approx(tick / rate_hz, abs=1e-9), (
                    f"at {rate_hz} Hz, tick {tick} came at {robot.clock.now()} s instead of {tick / rate_hz} s; "
                    "the physics step must divide the tick, see SteppedClock"
                )

    def test_calls_are_made_when_they_are_due(self) -> None:
        called_at: list[float] = []
        with self.opened() as robot:
            due = robot.clock.now() + 0.1
            robot.clock.call_at(due, lambda: called_at.append(robot.clock.now()))
            robot.clock.sleep_until(due + 0.2)
        assert called_at, f"a call due at {due} s was never made, though time passed until {due + 0.2} s"
        assert due - 1e-9 <= called_at[0] < due + 0.1, f"a call due at {due} s was made at {called_at[0]} s"
