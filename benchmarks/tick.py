"""Measure what a tick costs in the framework itself, with devices and a behaviour that do almost nothing.

    python -m benchmarks.tick

Each tick commands two motors, and reads a range sensor and a camera, with the layers of a real run. The steps of the
clock take no time. A loop that calls the same devices without the framework is timed in turn, and so is a loop of the
framework without the tick statistics. The exit status is 1 if a bound is exceeded. A ratio does not depend on the speed
of the machine.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from operator import sub, truediv
from time import process_time

import numpy as np

from benchmarks.report import compute_median, parse_options, print_table
from robotcore.description import load_robot
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Camera, Frame
from robotcore.kinds.motor import Motor
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.optics import Intrinsics
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import assemble
from robotcore.runtime.layers.timing import TickTimer
from robotcore.runtime.loop import Loop
from robotcore.runtime.result import Outcome
from robotcore.runtime.tick_statistics import TickStatistics

BOUND = 10.0
STATISTICS_BOUND = 0.9
"""The greatest cost of the tick statistics, as a multiple of the time of the devices alone: 2 µs where that is 2.2."""
RATE_HZ = 20.0
PICTURE = np.zeros((240, 320, 3), np.uint8)


class NullMotor(Motor):
    """A motor that ignores its commands."""

    def _apply(self, rad_s: float) -> None:
        pass


class NullRange(RangeSensor):
    """A range sensor that always measures 1 m."""

    def __init__(self, clock: Clock) -> None:
        super().__init__("nose", min_range=0.02, max_range=2.0, cone=0.5)
        self._clock = clock

    def _newest(self) -> Range:
        return Range(1.0, self._clock.now(), 0)


class NullCamera(Camera):
    """A camera that always returns the same picture."""

    def __init__(self, clock: Clock) -> None:
        super().__init__("eye", Intrinsics(320, 240, 1.0))
        self._clock = clock

    def _newest(self) -> Frame:
        return Frame(PICTURE, self._clock.now(), 0)


class Trivial(Behaviour):
    """An app that reads both sensors and commands the wheels."""

    def step(self, robot: Robot) -> Status:
        robot.camera.read()
        robot.range.read()
        robot.drive.set_wheels(2.0, 1.0)
        return Status.RUNNING


def main() -> int:
    """Measure the loops in turn. Print their medians, and the ratio and the difference within each pair."""
    options = parse_options(__doc__, repeats=60, ticks=2000)
    ticks, framework, untimed, bare = options.ticks, list[float](), list[float](), list[float]()
    for _ in range(options.repeats):
        _time_tick_us(_make_framework_loop(ticks, has_timer=False), ticks, untimed)
        _time_tick_us(_make_framework_loop(ticks), ticks, framework)
        _time_tick_us(_make_bare_loop(ticks), ticks, bare)
    ratio = compute_median(map(truediv, framework, bare))
    costs = list(map(sub, framework, untimed))
    share = compute_median(map(truediv, costs, bare))
    rows = [
        ("the devices, called without the framework, µs", *compute_median(bare).format_cells(".1f")),
        ("a tick of the loop, µs", *compute_median(framework).format_cells(".1f")),
        (f"ratio within a pair, at most {BOUND:g}", *ratio.format_cells(".2f")),
        ("the tick statistics in it, µs", *compute_median(costs).format_cells(".2f")),
        (f"ratio to the devices, at most {STATISTICS_BOUND:g}", *share.format_cells(".2f")),
    ]
    print_table((f"{options.repeats} × {options.ticks} ticks", "median", "95 % interval of it"), rows)
    return int(ratio.median > BOUND or share.median > STATISTICS_BOUND)


def _time_tick_us(work: Callable[[], object], ticks: int, noted: list[float]) -> None:
    start = process_time()
    work()
    noted.append((process_time() - start) / ticks * 1e6)


def _build_robot() -> Robot:
    clock = SteppedClock(RATE_HZ, lambda _steps: None)
    motors = NullMotor("left_motor", 12.0), NullMotor("right_motor", 12.0)
    return Robot("null", clock, [*motors, NullRange(clock), NullCamera(clock)])


def _make_bare_loop(ticks: int) -> Callable[[], object]:
    robot = _build_robot()
    left, right = robot.motors.values()

    def work() -> None:
        for tick in range(ticks):
            robot.camera.read()
            robot.range.read()
            left.set_velocity(2.0)
            right.set_velocity(1.0)
            robot.clock.sleep_until((tick + 1) / RATE_HZ)

    return work


def _make_framework_loop(ticks: int, *, has_timer: bool = True) -> Callable[[], object]:
    timer = TickTimer(TickStatistics()) if has_timer else None
    assembled = assemble(_build_robot(), load_robot("rover"), RATE_HZ, timer=timer)
    loop = Loop(assembled, Trivial(), RATE_HZ, timeout=(ticks - 1.5) / RATE_HZ)

    def work() -> None:
        assert loop.run() is Outcome.TIMEOUT
        assert loop.trace.ticks == ticks

    return work


if __name__ == "__main__":
    sys.exit(main())
