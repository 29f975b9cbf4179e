"""The polls of the drive's encoders between two ticks, in simulated time and in a thread."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.sampling import SampleCache
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.runtime.layers.encoder_polling import MAX_POINTS, EncoderPolling, build_polling

ROVER = load_robot("rover")


class TurningEncoder(Encoder):
    """Measures an angle that depends on the time.

    angle_at: returns the angle in radians at a time in seconds.
    late_s: the age of a new sample in seconds.
    """

    def __init__(self, name: str, clock: Clock, angle_at: Callable[[float], float], late_s: float = 0.0) -> None:
        super().__init__(name)
        self.times: list[float] = []
        """The times of the measurements in seconds."""
        self.is_broken = False
        self._angle_at, self._late_s = angle_at, late_s
        self._newest_at = SampleCache(clock, self._take)

    def _newest(self) -> Angle:
        if self.is_broken:
            raise OSError("unplugged")
        return self._newest_at()

    def _take(self, time: float, sequence: int) -> Angle:
        self.times.append(time)
        return Angle(self._angle_at(time - self._late_s), time - self._late_s, sequence)


class UnsteppedClock(SteppedClock):
    """A clock whose time passes by itself, for a layer. A test steps it."""

    is_lockstep = False


class Bench:
    """Two encoders and their polls, 200 in a second, on a clock with 240 steps in a second."""

    def __init__(self, clock: Clock | None = None, late_s: float = 0.0) -> None:
        self.clock = clock or SteppedClock(20, lambda _: None)
        self.left = TurningEncoder("left_encoder", self.clock, lambda time: 2 * time, late_s)
        self.right = TurningEncoder("right_encoder", self.clock, lambda time: time**2, late_s)
        self.polling = EncoderPolling([self.left], [self.right], self.clock, 200)
        self.layered = self.polling.clock(self.clock)

    def take(self) -> list[tuple[float, Wheels]]:
        return [(time, angles) for time, angles in self.polling.take(-1.0, math.inf)]


def test_encoders_are_polled_between_two_ticks_but_not_at_a_tick() -> None:
    bench = Bench()
    assert bench.layered.sleep_until(0.05)
    times = [time for time, _ in bench.take()]
    assert bench.left.times == bench.right.times == times
    assert times == pytest.approx([step / 240 for step in (1, 2, 4, 5, 6, 7, 8, 10, 11)])
    assert bench.clock.now() == 0.05


def test_a_poll_has_the_angles_of_its_time() -> None:
    bench = Bench()
    bench.layered.sleep_until(0.05)
    time, angles = bench.take()[4]
    assert time == 0.025
    assert angles == pytest.approx((0.05, 0.025**2))


def test_a_poll_follows_the_other_calls_of_its_time() -> None:
    bench, calls = Bench(), list[str]()
    bench.clock.call_every(1 / 60, lambda: calls.append(f"{len(bench.left.times)} polls before"), "disc")
    bench.layered.sleep_until(0.05)
    assert calls == ["2 polls before", "6 polls before", "9 polls before"]


def test_a_sleep_shorter_than_a_period_has_no_poll() -> None:
    bench = Bench()
    assert bench.layered.sleep_until(0.005)
    assert not bench.layered.sleep_until(0.001)
    assert bench.left.times == []


def test_mean_of_each_side_is_stored() -> None:
    bench = Bench()
    rear = TurningEncoder("rear", bench.clock, lambda time: 4 * time)
    polling = EncoderPolling([bench.left, rear], [bench.right], bench.clock, 40)
    polling.clock(bench.clock).sleep_until(0.05)
    ((_, angles),) = polling.take(0.0, 1.0)
    assert angles == pytest.approx((0.075, 0.025**2))


def test_repeated_sample_of_one_encoder_is_no_new_point() -> None:
    bench = Bench()
    slow = TurningEncoder("slow", bench.clock, lambda time: time)
    stored = Angle(0.0, 0.0, 0)

    def read_slowly() -> Angle:
        nonlocal stored
        if bench.clock.now() >= stored.time + 0.02:  # as a board that sends counts 50 times in a second
            stored = Angle(bench.clock.now(), bench.clock.now(), stored.sequence + 1)
        return stored

    slow._newest = read_slowly  # type: ignore[method-assign]
    polling = EncoderPolling([bench.left], [slow], bench.clock, 200)
    polling.clock(bench.clock).sleep_until(0.1)
    assert [round(time * 240) for time, _ in polling.take(0.0, 1.0)] == [1, 5, 10, 16, 22]


def test_failed_poll_is_left_out() -> None:
    bench = Bench()
    bench.layered.sleep_until(0.05)
    bench.right.is_broken = True
    bench.layered.sleep_until(0.1)
    bench.right.is_broken = False
    bench.layered.sleep_until(0.15)
    ticks = [math.floor(time / 0.05) for time, _ in bench.take()]
    assert [ticks.count(tick) for tick in range(3)] == [9, 0, 9]


def test_read_of_a_tick_raises_the_error_of_a_failed_encoder() -> None:
    bench = Bench()
    read = bench.polling.sensor(bench.right, bench.right.read)
    bench.right.is_broken = True
    bench.layered.sleep_until(0.05)
    with pytest.raises(DeviceError):
        read()


def test_samples_of_the_ticks_are_stored_when_each_encoder_was_read() -> None:
    bench = Bench()
    reads = [bench.polling.sensor(encoder, encoder.read) for encoder in (bench.left, bench.right)]
    reads[0]()
    assert bench.polling.list_read() is None
    right = reads[1]()
    assert bench.polling.list_read() == ([Angle(0.0, 0.0, 0)], [right])


def test_other_sensors_are_read_without_the_layer() -> None:
    bench = Bench()
    other = TurningEncoder("arm", bench.clock, abs)
    read = other.read
    assert bench.polling.sensor(other, read) is read


def test_only_the_polls_between_two_times_are_taken() -> None:
    bench = Bench()
    bench.layered.sleep_until(0.1)
    assert [round(time * 240) for time, _ in bench.polling.take(5 / 240, 8 / 240)] == [6, 7]
    assert [round(time * 240) for time, _ in bench.polling.take(8 / 240, 12 / 240)] == [10, 11]


def test_old_polls_are_dropped_if_nothing_takes_them() -> None:
    bench = Bench()
    bench.layered.sleep_until(10.0)
    points = bench.take()
    assert len(points) == MAX_POINTS
    assert points[-1][0] == pytest.approx(10 - 1 / 240)


def test_a_clock_that_is_not_in_lockstep_is_polled_by_its_own_task_until_the_end() -> None:
    bench = Bench(UnsteppedClock(20, lambda _: None))
    assert bench.layered is bench.clock
    bench.clock.sleep_until(0.05)
    assert bench.left.times == []
    bench.polling.begin()
    bench.clock.sleep_until(0.1)
    assert len(bench.take()) == 10
    bench.polling.end()
    bench.polling.end()
    bench.clock.sleep_until(0.2)
    assert bench.take() == []


def test_simulated_time_has_no_task_of_its_own() -> None:
    bench = Bench()
    bench.polling.begin()
    bench.clock.sleep_until(0.05)
    bench.polling.end()
    assert bench.left.times == []


@pytest.mark.parametrize(
    "names, rate_hz, tick_hz",
    [(("left_encoder",), 200.0, 20.0), ((), 200.0, 20.0), (("left_encoder", "right_encoder"), None, 20.0)]
    + [(("left_encoder", "right_encoder"), 200.0, tick_hz) for tick_hz in (200.0, 500.0)],
)
def test_no_polls_without_encoders_or_rate_or_with_fast_ticks(
    names: tuple[str, ...], rate_hz: float | None, tick_hz: float
) -> None:
    clock = SteppedClock(tick_hz, lambda _: None)
    devices: dict[str, Device] = {name: TurningEncoder(name, clock, abs) for name in names}
    assert build_polling(devices, ROVER.drive, clock, rate_hz, tick_hz) is None


def test_no_polls_without_a_drive() -> None:
    clock = SteppedClock(20, lambda _: None)
    devices: dict[str, Device] = {name: TurningEncoder(name, clock, abs) for name in ("left_encoder", "right_encoder")}
    assert build_polling(devices, None, clock, 200.0, 20.0) is None
    assert build_polling(devices, ROVER.drive, clock, 200.0, 20.0)
