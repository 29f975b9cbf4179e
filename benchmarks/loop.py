"""Measure what the framework costs a real loop, and what a simulator without physics saves.

    python -m benchmarks.loop --backends pybullet,mujoco

Each tick reads a picture of 320 × 240 at 20 Hz, looks for the ball in it, and commands two motors. Physics runs at
240 Hz. The loop exists twice: written by hand with the simulator's own functions, and as an app with all layers, safety
and odometry of a real run. The robots hardly move, so both get the same pictures. Then the app's loop on each other
simulator is compared with the first one, and so are the first seconds of green-search on the kinematic simulator. All
is timed in pairs. The exit status is 1 if a bound is broken.
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

from benchmarks.baseline_loop import BASELINES, RATE_HZ, WHEEL_RAD_S, Block
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
    """An app that drives and looks for the ball. It ends after ``left`` ticks."""

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
    """Time the loops in pairs, and print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--backends", default="pybullet,mujoco")
    parser.add_argument("--pairs", type=at_least_one, default=30)
    parser.add_argument("--ticks", type=at_least_one, default=20, help="ticks in a block")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    robot = load_robot("rover")
    world = draw_world(load_world("clutter"), robot, SEED)
    first, *others = backends = options.backends.split(",")
    timers = {backend: _make_timer(_make_framework_block(backend, robot, world), options.ticks) for backend in backends}
    rows = []
    for backend in backends:
        by_hand = _make_timer(BASELINES[backend](robot, world), options.ticks)
        raw = paired_ratios(by_hand, timers[backend], options.pairs)
        rows.append(_build_row(f"a loop on {backend}, compared with the same loop by hand", raw, RAW_BOUND))
    for other in others:
        faster = paired_ratios(timers[first], timers[other], options.pairs)
        rows.append(_build_row(f"the loop on {other}, compared with {first}", faster, OTHER_BOUND))
    saved = paired_ratios(_make_search_timer(first), _make_search_timer("kinematic"), options.pairs)
    rows.append(_build_row(f"green-search on the kinematic simulator, compared with {first}", saved, KINEMATIC_BOUND))
    print(machine())
    print_table((f"speed, {options.pairs} pairs", "median", "95 % interval of it", "bound"), [row[:-1] for row in rows])
    return int(not all(row[-1] for row in rows))


def _make_timer(block: Block, ticks: int) -> Callable[[], float]:
    def timed() -> float:
        start = perf_counter()
        block(ticks)
        return perf_counter() - start

    return timed


def _make_search_timer(backend: str) -> Callable[[], float]:
    seeds = count(SEED)

    def search() -> float:
        result = run(RunRequest("green-search", backend, world="clutter", seed=next(seeds), timeout_s=SEARCH_S))
        return result.wall_time_s / result.sim_time_s

    return search


class Row(NamedTuple):
    """A row of the table, and whether its bound is met."""

    claim: str
    median: str
    interval: str
    bound: str
    holds: bool


def _build_row(claim: str, measured: tuple[float, float, float], bound: float) -> Row:
    median, low, high = measured
    return Row(claim, f"{median:.3f}", f"{low:.3f} to {high:.3f}", f"≥ {bound:g}", median >= bound)


def _make_framework_block(backend: str, robot: RobotDescription, world: WorldDescription) -> Block:
    behaviour = LookRound()
    raw = load_backend(backend).open(Setup(robot, world, needed_devices(robot, behaviour.needs), RATE_HZ))
    loop = Loop(assemble(raw, robot, RATE_HZ), behaviour, RATE_HZ, timeout=math.inf)

    def block(ticks: int) -> None:
        behaviour.left = ticks
        loop.run()

    return block


if __name__ == "__main__":
    sys.exit(main())
