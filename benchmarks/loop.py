"""Measure what the framework costs a real loop, and what a simulator without physics saves.

    python -m benchmarks.loop --backends pybullet,mujoco

Each tick reads a picture of 320 × 240 at 20 Hz, looks for the ball in it, and commands two motors. Physics runs at
240 Hz. The loop exists twice: written by hand with the simulator's own functions, and as an app with all layers, safety
and odometry of a real run. The robots hardly move, so both get the same pictures. Then the app's loop on each other
simulator is compared with the first one, and so are the first seconds of green-search on the kinematic simulator. All
is timed in pairs. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from itertools import count
from time import perf_counter

import cv2

from benchmarks.baseline_loop import BASELINES, RATE_HZ, WHEEL_RAD_S, Block
from benchmarks.report import measure_ratio, parse_options, print_table
from robotcore.autonomy.vision import ColourDetector
from robotcore.description import RobotDescription, WorldDescription, draw_world, load_robot, load_world
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import assemble, needed_devices
from robotcore.runtime.loop import Loop
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.session import run

SEED = 1
RAW_BOUND, KINEMATIC_BOUND, OTHER_BOUND = 0.98, 5.0, 3.0

Timer = Callable[[], float]
"""A function that returns a duration in seconds."""


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
    options = parse_options(__doc__, backends="pybullet,mujoco", pairs=30, ticks=20, search=8.0)
    cv2.setNumThreads(1)
    robot = load_robot("rover")
    world = draw_world(load_world("clutter"), robot, SEED)
    first, *others = backends = options.backends.split(",")
    timers = {backend: _make_timer(_make_framework_block(backend, robot, world), options.ticks) for backend in backends}
    cases: list[tuple[str, Timer, Timer, float]] = []
    for backend in backends:
        by_hand = _make_timer(BASELINES[backend](robot, world), options.ticks)
        cases.append((f"a loop on {backend}, compared with the same by hand", by_hand, timers[backend], RAW_BOUND))
    cases += [
        (f"the loop on {each}, compared with {first}", timers[first], timers[each], OTHER_BOUND) for each in others
    ]
    slow, fast = (_make_search_timer(each, options.search) for each in (first, "kinematic"))
    cases.append((f"green-search on the kinematic simulator, compared with {first}", slow, fast, KINEMATIC_BOUND))
    rows, is_met = [], True
    for claim, slower, faster, bound in cases:
        ratio = measure_ratio(slower, faster, options.pairs)
        rows.append((claim, *ratio.format_cells(".3f"), f"≥ {bound:g}"))
        is_met &= ratio.median >= bound
    print_table((f"speed, {options.pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return int(not is_met)


def _make_timer(block: Block, ticks: int) -> Timer:
    def timed() -> float:
        start = perf_counter()
        block(ticks)
        return perf_counter() - start

    return timed


def _make_search_timer(backend: str, search_s: float) -> Timer:
    seeds = count(SEED)

    def search() -> float:
        result = run(RunRequest("green-search", backend, world="clutter", seed=next(seeds), timeout_s=search_s))
        return result.wall_time_s / result.sim_time_s

    return search


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
