from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable

import pytest

from robotcore.errors import DeviceError, InvalidCommandError
from robotcore.geometry import Wheels
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.safety.command_filter import SafetyFilter
from robotcore.safety.velocity_limits import AccelerationLimit, Rule, VelocityLimit
from robotcore.safety.wheel_output import SideMotors
from tests.robotcore.fakes import NullMotor
from tests.texts import CheckText


class Bench:
    """A safety filter over two null motors, with a lease of 0.125 s."""

    def __init__(self, *rules: Rule) -> None:
        self.clock = TickClock(SteppedClock(20, lambda _: None))
        self.left, self.right = NullMotor("left"), NullMotor("right")
        self.heard: list[tuple[Wheels, float]] = []
        self.filter = SafetyFilter(
            self.clock,
            SideMotors([self.left], [self.right]),
            rules,
            0.125,
            on_sent=lambda wheels, time: self.heard.append((wheels, time)),
        )

    def drive(self, wheels: Wheels) -> None:
        """Send a command in a tick."""
        self.filter.ask(wheels)
        self.filter.commit()

    def sleep(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)

    @property
    def sent(self) -> list[tuple[float, float]]:
        return list(zip(self.left.sent, self.right.sent, strict=True))


class Failing:
    """A rule whose sensor fails."""

    cause = "failing"

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        raise DeviceError("nose", "no echo")


class Blocking:
    """A rule that stops the robot if an obstacle is near."""

    cause = "blocking"

    def __init__(self, is_near: Callable[[], bool]) -> None:
        self._is_near = is_near

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        return Wheels(0.0, 0.0) if self._is_near() else asked


@pytest.fixture
def bench() -> Bench:
    return Bench()


class TestCommit:
    def test_last_command_of_a_tick_is_sent(self, bench: Bench) -> None:
        bench.filter.ask(Wheels(1.0, 2.0))
        bench.filter.ask(Wheels(3.0, 4.0))
        assert bench.filter.commit() == ((3.0, 4.0), (3.0, 4.0), ())
        assert bench.sent == [(3.0, 4.0)]

    def test_stop_is_sent_once(self, bench: Bench) -> None:
        bench.drive(Wheels(1.0, 2.0))
        bench.filter.stop()
        assert bench.filter.commit() == ((0.0, 0.0), (0.0, 0.0), ())
        assert bench.sent == [(1.0, 2.0), (0.0, 0.0)]

    def test_failed_stop_is_sent_again(self, bench: Bench) -> None:
        bench.drive(Wheels(1.0, 2.0))
        bench.left.is_broken = True
        with pytest.raises(DeviceError):
            bench.filter.stop()
        with pytest.raises(DeviceError):
            bench.filter.commit()

    def test_tick_without_a_command_sends_nothing(self, bench: Bench) -> None:
        bench.drive(Wheels(1.0, 1.0))
        assert bench.filter.commit() == (None, None, ())
        assert len(bench.sent) == 1

    def test_each_rule_gets_the_command_of_the_rule_before(self) -> None:
        bench = Bench(VelocityLimit(10.0), AccelerationLimit(2.0))
        sent = bench.filter.ask(Wheels(40.0, 20.0))
        commit = bench.filter.commit()
        assert sent == commit.sent == (2.0, 1.0)
        assert commit.asked == (40.0, 20.0)
        changes = [(each.cause, each.asked, each.sent) for each in commit.interventions]
        assert changes == [
            ("velocity limit", (40.0, 20.0), (10.0, 5.0)),
            ("acceleration limit", (10.0, 5.0), (2.0, 1.0)),
        ]

    def test_replaced_command_leaves_no_interventions(self) -> None:
        bench = Bench(VelocityLimit(10.0))
        bench.filter.ask(Wheels(40.0, 20.0))
        bench.filter.ask(Wheels(1.0, 1.0))
        assert bench.filter.commit().interventions == ()
        assert bench.filter.commit().interventions == ()

    def test_acceleration_counts_from_the_last_sent_command(self) -> None:
        bench = Bench(AccelerationLimit(2.0))
        for _ in range(3):
            bench.filter.ask(Wheels(9.0, 9.0))
            bench.drive(Wheels(9.0, 9.0))
        assert bench.sent == [(2.0, 2.0), (4.0, 4.0), (6.0, 6.0)]

    def test_command_is_not_sent_if_a_rule_raises(self, bench: Bench) -> None:
        bench.drive(Wheels(5.0, 5.0))
        bench.filter._rules = (Failing(),)
        with pytest.raises(DeviceError):
            bench.filter.ask(Wheels(1.0, 1.0))
        with pytest.raises(DeviceError):
            bench.filter.commit()
        assert bench.sent == [(5.0, 5.0)]

    def test_sent_velocities_are_those_that_the_motors_accepted(self, bench: Bench) -> None:
        bench.right.max_velocity = 2.0
        bench.filter.ask(Wheels(3.0, 3.0))
        assert bench.filter.commit().sent == (3.0, 2.0)
        assert bench.heard == [(Wheels(3.0, 2.0), 0.0)]

    def test_failure_of_one_motor_stops_the_other(self, bench: Bench) -> None:
        bench.right.is_broken = True
        bench.filter.ask(Wheels(5.0, 5.0))
        with pytest.raises(DeviceError):
            bench.filter.commit()
        assert bench.left.sent == [5.0, 0.0]

    def test_lasting_command_passes_the_rules_in_every_tick(self) -> None:
        nearing = iter([False, False, True])
        bench = Bench(Blocking(lambda: next(nearing)))
        bench.filter.ask(Wheels(4.0, 4.0))
        commits = [bench.filter.commit() for _ in range(3)]
        assert [commit.asked for commit in commits] == [(4.0, 4.0), None, None]
        assert [commit.sent for commit in commits] == [(4.0, 4.0), None, (0.0, 0.0)]
        assert [each.cause for each in commits[2].interventions] == ["blocking"]


class TestThreads:
    """The deadman stops the motors in another thread while the loop runs."""

    def test_deadman_stops_both_motors_while_a_command_hangs(self, bench: Bench) -> None:
        going_on = threading.Event()
        bench.left.on_command = lambda velocity: going_on.wait(10) if velocity else None
        bench.filter.ask(Wheels(5.0, 5.0))
        loop = threading.Thread(target=bench.filter.commit)
        loop.start()
        while not bench.left.received:
            pass
        bench.clock.sleep_until(0.5)
        assert bench.right.sent == [0.0]
        going_on.set()
        loop.join()
        assert (bench.left.sent[-1], bench.right.sent[-1]) == (0.0, 0.0)

    def test_command_before_a_deadman_stop_passes_the_rules_again(self) -> None:
        bench = Bench(AccelerationLimit(3.0))
        for _ in range(3):
            bench.drive(Wheels(9.0, 9.0))
        bench.filter.ask(Wheels(9.0, 9.0))
        bench.filter._stop_after_lease(0.1)
        assert bench.filter.commit().sent == (3.0, 3.0)


class TestLatch:
    def test_latch_trips_even_if_a_motor_fails_to_stop(self, bench: Bench) -> None:
        bench.left.is_broken = True
        with pytest.raises(InvalidCommandError):
            bench.filter.ask(Wheels(math.nan, 0.0))
        bench.left.is_broken = False
        with pytest.raises(InvalidCommandError):
            bench.filter.ask(Wheels(1.0, 1.0))


class TestStop:
    def test_stop_replaces_an_earlier_command_of_the_tick(self, bench: Bench) -> None:
        bench.filter.ask(Wheels(9.0, 9.0))
        bench.filter.stop()
        assert bench.filter.commit() == ((0.0, 0.0), (0.0, 0.0), ())
        assert set(bench.sent) == {(0.0, 0.0)}

    def test_command_after_a_stop_begins_at_rest(self) -> None:
        bench = Bench(AccelerationLimit(2.0))
        for _ in range(2):
            bench.drive(Wheels(9.0, 9.0))
        bench.filter.stop()
        assert bench.sent[-1] == (0.0, 0.0)
        assert bench.filter.ask(Wheels(9.0, 9.0)) == (2.0, 2.0)

    @pytest.mark.parametrize("broken", ["left", "right"])
    def test_other_wheel_stops_if_one_fails(self, bench: Bench, broken: str) -> None:
        bench.drive(Wheels(5.0, 5.0))
        getattr(bench, broken).is_broken = True
        with pytest.raises(DeviceError) as raised:
            bench.filter.stop()
        assert raised.value.device == broken
        sound = bench.right if broken == "left" else bench.left
        assert sound.sent[-1] == 0.0


class TestNumbers:
    @pytest.mark.parametrize("wheels", [Wheels(math.nan, 1.0), Wheels(1.0, math.nan), Wheels(math.inf, 0.0)])
    def test_invalid_velocity_stops_both_motors_at_once(self, bench: Bench, wheels: Wheels) -> None:
        bench.drive(Wheels(5.0, 5.0))
        for use in (lambda: bench.filter.ask(wheels), lambda: bench.filter.ask(Wheels(1.0, 1.0)), bench.filter.commit):
            with pytest.raises(InvalidCommandError):
                use()
            assert bench.sent[-1] == (0.0, 0.0)

    def test_error_names_the_motor(self, check_text: CheckText) -> None:
        with pytest.raises(InvalidCommandError) as raised:
            Bench().filter.ask(Wheels(1.0, math.nan))
        check_text(raised.value, hide=re.findall(r"\.py:\d+", str(raised.value)))


class TestDeadman:
    def test_deadman_stop_between_ticks_is_an_intervention_of_the_next_tick(self, bench: Bench) -> None:
        bench.drive(Wheels(5.0, 4.0))
        bench.sleep(0.5)
        assert bench.sent == [(5.0, 4.0), (0.0, 0.0)]
        (cut,) = bench.filter.commit().interventions
        assert (cut.time, cut.cause, cut.asked, cut.sent) == (0.125, "deadman", (5.0, 4.0), (0.0, 0.0))
        assert bench.heard == [((5.0, 4.0), 0.0), ((0.0, 0.0), 0.125)]
        assert bench.filter.commit().interventions == ()

    @pytest.mark.parametrize("is_stop", [True, False])
    def test_deadman_does_not_stop_stopped_wheels(self, bench: Bench, is_stop: bool) -> None:
        bench.drive(Wheels(5.0, 5.0))
        if is_stop:
            bench.filter.stop()
        else:
            bench.drive(Wheels(0.0, 0.0))
        bench.sleep(1.0)
        assert bench.filter.commit().interventions == ()
