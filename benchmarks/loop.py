"""What the framework costs a real loop, and what a simulator without physics saves.

    python -m benchmarks.loop --backends pybullet,mujoco

A picture of 320 × 240 at 20 Hz, the ball looked for in it, two motors, physics at 240 Hz: once written by hand with the
simulator's own functions, once as an app under all layers, safety and odometry of a real run. The robots all but stand,
so both see the same. Then the app's loop on every other simulator against the first, and green-search, the first
seconds of it, on the kinematic simulator against the first. All is timed in pairs, in turn. Exit status 1 where a bound
is broken.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from itertools import count
from time import perf_counter
from typing import NamedTuple

import cv2

from benchmarks.by_hand import BY_HAND, RATE_HZ, WHEEL_RAD_S, Block
from benchmarks.pairs import paired_ratios
from benchmarks.report import at_least_one, machine, print_table
from robotcore.autonomy.vision import ColourDetector
from robotcore.description import RobotDescription, WorldDescription, draw_world, load_robot, load_world
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import assemble, needed_devices
from robotcore.runtime.loop import Loop
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.session import run

SEED, SEARCH_S = 1, 8.0
RAW_BOUND, KINEMATIC_BOUND, OTHER_BOUND = 0.98, 5.0, 3.0


class LookRound(Behaviour):
    """Drives, and looks for the ball, for as many ticks as it has left."""

    needs = frozenset({Role.DRIVE, Role.CAMERA})

    def __init__(self) -> None:
        self.left = 0
        self._detector = ColourDetector("green")

    def step(self, robot: Robot) -> Status:
        if not self.left:
            return Status.SUCCESS
        self.left -= 1
        self._detector.find(robot.camera.read().image, robot.camera.intrinsics)
        robot.drive.set_wheels(-WHEEL_RAD_S, WHEEL_RAD_S)
        return Status.RUNNING


def main() -> int:
    """Time the loops in pairs and print by how much they differ."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--backends", default="pybullet,mujoco")
    parser.add_argument("--pairs", type=at_least_one, default=30)
    parser.add_argument("--ticks", type=at_least_one, default=20, help="ticks in a block")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    robot = load_robot("rover")
    world = draw_world(load_world("clutter"), robot, SEED)
    first, *others = backends = asked.backends.split(",")
    framed = {backend: _seconds(_framed(backend, robot, world), asked.ticks) for backend in backends}
    rows = []
    for backend in backends:
        by_hand = _seconds(BY_HAND[backend](robot, world), asked.ticks)
        raw = paired_ratios(by_hand, framed[backend], asked.pairs)
        rows.append(_row(f"a loop on {backend}, against the same by hand", raw, RAW_BOUND))
    for other in others:
        faster = paired_ratios(framed[first], framed[other], asked.pairs)
        rows.append(_row(f"the loop on {other}, against {first}", faster, OTHER_BOUND))
    saved = paired_ratios(_searches(first), _searches("kinematic"), asked.pairs)
    rows.append(_row(f"green-search on the kinematic simulator, against {first}", saved, KINEMATIC_BOUND))
    print(machine())
    print_table((f"speed, {asked.pairs} pairs", "median", "95 % interval of it", "bound"), [row[:-1] for row in rows])
    return int(not all(row[-1] for row in rows))


def _seconds(block: Block, ticks: int) -> Callable[[], float]:
    """Return what times a block."""

    def timed() -> float:
        start = perf_counter()
        block(ticks)
        return perf_counter() - start

    return timed


def _searches(backend: str) -> Callable[[], float]:
    """Return what times the beginning of a search, in a new world each time, and tells it for a simulated second."""
    seeds = count(SEED)

    def search() -> float:
        result = run(RunRequest("green-search", backend, world="clutter", seed=next(seeds), timeout_s=SEARCH_S))
        return result.wall_time_s / result.sim_time_s

    return search


class Row(NamedTuple):
    """A claim, as it is printed, and whether it holds."""

    claim: str
    median: str
    interval: str
    bound: str
    holds: bool


def _row(claim: str, measured: tuple[float, float, float], bound: float) -> Row:
    median, low, high = measured
    return Row(claim, f"{median:.3f}", f"{low:.3f} to {high:.3f}", f"≥ {bound:g}", median >= bound)


def _framed(backend: str, robot: RobotDescription, world: WorldDescription) -> Block:
    """Return a block of ticks under all that a run has."""
    behaviour = LookRound()
    raw = load_backend(backend).open(Setup(robot, world, needed_devices(robot, behaviour.needs), RATE_HZ))
    loop = Loop(assemble(raw, robot, RATE_HZ), behaviour, RATE_HZ, timeout=math.inf)

    def block(ticks: int) -> None:
        behaviour.left = ticks
        loop.run()

    return block


if __name__ == "__main__":
    sys.exit(main())
