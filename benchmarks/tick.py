"""What a tick costs in the framework itself: a robot of null devices, a behaviour that does next to nothing.

    python -m benchmarks.tick

Two motors, a range sensor and a camera, read in each tick, under the layers of a real run; the clock is a stepped one
whose steps take no time. The bare behaviour, which calls the same devices without any framework, is timed in turn with
it. Exit status 1 where a tick takes more than the bound, in times of the bare behaviour: a machine's speed does not
matter.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from time import process_time

import numpy as np

from benchmarks.pairs import median_with_interval, paired_ratios
from benchmarks.report import at_least_one, machine, print_table
from robotcore.description import load_robot
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.devices import Camera, Frame, Motor, Range, RangeSensor
from robotcore.hal.robot import Robot
from robotcore.optics import Intrinsics
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.result import Outcome

BOUND = 10.0
RATE_HZ = 20.0
PICTURE = np.zeros((240, 320, 3), np.uint8)


class NullMotor(Motor):
    """Takes commands and does nothing."""

    def _apply(self, rad_s: float) -> None:
        pass


class NullRange(RangeSensor):
    """Always the same distance."""

    def __init__(self, clock: Clock) -> None:
        super().__init__("nose", min_range=0.02, max_range=2.0, cone=0.5)
        self._clock = clock

    def _newest(self) -> Range:
        return Range(1.0, self._clock.now(), 0)


class NullCamera(Camera):
    """Always the same picture."""

    def __init__(self, clock: Clock) -> None:
        super().__init__("eye", Intrinsics(320, 240, 1.0))
        self._clock = clock

    def _newest(self) -> Frame:
        return Frame(PICTURE, self._clock.now(), 0)


class Trivial(Behaviour):
    """Reads both sensors and sets the wheels."""

    def step(self, robot: Robot) -> Status:
        robot.camera.read()
        robot.range.read()
        robot.drive.set_wheels(2.0, 1.0)
        return Status.RUNNING


def main() -> int:
    """Time both in turn, print their medians and the ratio within a pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=at_least_one, default=60)
    parser.add_argument("--ticks", type=at_least_one, default=2000)
    asked = parser.parse_args()
    framework, bare = list[float](), list[float]()
    ratio = paired_ratios(
        lambda: _microseconds(_framed(asked.ticks), asked.ticks, framework),
        lambda: _microseconds(_bare(asked.ticks), asked.ticks, bare),
        asked.repeats,
    )
    rows = [
        ("the devices, called without the framework, µs", *_format_cells(median_with_interval(bare), 1)),
        ("a tick of the loop, µs", *_format_cells(median_with_interval(framework), 1)),
        (f"ratio within a pair, at most {BOUND:g}", *_format_cells(ratio, 2)),
    ]
    print(machine())
    print_table((f"{asked.repeats} × {asked.ticks} ticks", "median", "95 % interval of it"), rows)
    return int(ratio[0] > BOUND)


def _microseconds(work: Callable[[], object], ticks: int, noted: list[float]) -> float:
    """Return how long a tick of this work takes, and note it."""
    start = process_time()
    work()
    noted.append((process_time() - start) / ticks * 1e6)
    return noted[-1]


def _raw() -> Robot:
    clock = SteppedClock(RATE_HZ, lambda _steps: None)
    motors = NullMotor("left_motor", 12.0), NullMotor("right_motor", 12.0)
    return Robot("null", clock, [*motors, NullRange(clock), NullCamera(clock)])


def _bare(ticks: int) -> Callable[[], object]:
    robot = _raw()
    left, right = robot.motors.values()

    def work() -> None:
        for tick in range(ticks):
            robot.camera.read()
            robot.range.read()
            left.set_velocity(2.0)
            right.set_velocity(1.0)
            robot.clock.sleep_until((tick + 1) / RATE_HZ)

    return work


def _framed(ticks: int) -> Callable[[], object]:
    assembled = assemble(_raw(), load_robot("rover"), RATE_HZ)
    loop = Loop(assembled, Trivial(), RATE_HZ, timeout=(ticks - 1.5) / RATE_HZ)

    def work() -> None:
        assert loop.run() is Outcome.TIMEOUT
        assert loop.trace.ticks == ticks

    return work


def _format_cells(measured: tuple[float, float, float], digits: int) -> tuple[str, str]:
    median, low, high = (f"{value:.{digits}f}" for value in measured)
    return median, f"{low} to {high}"


if __name__ == "__main__":
    sys.exit(main())
