"""Measure what the framework costs a real loop, and what painting, a second core and simple physics save.

    python -m benchmarks.loop

Each tick reads a picture of 320 × 240 at 20 Hz, looks for the ball in it, and commands two motors. Physics runs at
240 Hz. The loop exists as an app with all layers, safety and odometry of a real run. It is compared with the same loop
by hand: with the functions of PyBullet and its TinyRenderer, and with those of MuJoCo and its renderer. The robots
hardly move, so all get the same pictures. The first seconds of green-search are compared too. All is timed in pairs.

The times are CPU times of all threads. Only a loop that renders on a second core is timed by the wall clock. Mesa draws
the pictures of MuJoCo in software. LP_NUM_THREADS is the number of its threads, for all loops. The exit status is 1 if
a bound is broken.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator
from itertools import count
from time import perf_counter, process_time, sleep
from typing import NamedTuple

import cv2

from benchmarks.handwritten_loops import RATE_HZ, WHEEL_RAD_S, Block, build_mujoco_loop, build_pybullet_loop
from benchmarks.report import measure_ratio, parse_options, print_table
from robotcore.autonomy.vision import ColourDetector
from robotcore.description import RobotDescription, WorldDescription, draw_world, load_robot, load_world
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.camera import CameraDescription
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import needed_devices
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.session import run
from robotcore.simulation.render_worker import has_free_core
from robotcore.simulation.render_worker.picture_queue import FIRST_PICTURES

SEED = 1
MANY = 5
"""How many times more ticks are timed if a process renders the pictures."""

START_S = 4.0
"""The time in which a process that renders pictures starts, in seconds."""

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


class Case(NamedTuple):
    """A comparison of two loops."""

    claim: str
    slower: Timer
    faster: Timer
    bound: float
    """The least ratio of their times."""


def main() -> int:
    """Time the loops in pairs, and print the ratios."""
    options = parse_options(__doc__, pairs=30, ticks=20, search=8.0)
    os.environ.setdefault("MUJOCO_GL", "egl")  # MuJoCo's own renderer needs it
    os.environ.setdefault("LP_NUM_THREADS", "1")
    os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
    cv2.setNumThreads(1)
    rows, is_met = [], True
    for case in _build_cases(options.ticks, options.search):
        ratio = measure_ratio(case.slower, case.faster, options.pairs)
        rows.append((case.claim, *ratio.format_cells(".3f"), f"≥ {case.bound:g}"))
        is_met &= ratio.median >= case.bound
    print(f"LP_NUM_THREADS={os.environ['LP_NUM_THREADS']}")
    print_table((f"speed, {options.pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return int(not is_met)


def _build_cases(ticks: int, search_s: float) -> Iterator[Case]:
    robot = load_robot("rover")
    world = draw_world(load_world("clutter"), robot, SEED)
    by_hand = make_timer(build_pybullet_loop(robot, world), ticks)
    pybullet = make_timer(make_framework_block("pybullet", robot, world), ticks)
    painted = make_timer(make_framework_block("pybullet", robot, world, camera="painted"), ticks)
    yield Case("a loop on PyBullet, against the same by hand", by_hand, pybullet, 0.95)
    yield Case("the loop on PyBullet with a painted camera, against the same by hand", by_hand, painted, 4.0)
    mujoco_by_hand = build_mujoco_loop(robot, world)
    mujoco = make_timer(make_framework_block("mujoco", robot, world), ticks)
    yield Case("a loop on MuJoCo, against the same by hand", make_timer(mujoco_by_hand, ticks), mujoco, 1.5)
    yield Case("the loop on MuJoCo, against PyBullet", pybullet, mujoco, 3.0)
    if has_free_core():
        late = make_framework_block("mujoco", _delay_camera(robot), world)
        late(FIRST_PICTURES + 2)
        sleep(START_S)
        claim = "the loop on MuJoCo with a latency of a tick, on two cores, against the same by hand"
        many = MANY * ticks  # the picture of the last tick is rendered in the time of the other loop
        timers = make_timer(mujoco_by_hand, many, perf_counter), make_timer(late, many, perf_counter)
        yield Case(claim, *timers, 2.0)
    slow, fast = (_make_search_timer(backend, search_s) for backend in ("pybullet", "kinematic"))
    yield Case("green-search on the kinematic simulator, against PyBullet", slow, fast, 5.0)


def _delay_camera(robot: RobotDescription) -> RobotDescription:
    late = {"latency_s": 1 / RATE_HZ}
    devices = (each.model_copy(update=late) if isinstance(each, CameraDescription) else each for each in robot.devices)
    return robot.model_copy(update={"devices": tuple(devices)})


def make_timer(block: Block, ticks: int, clock: Callable[[], float] = process_time) -> Timer:
    def timed() -> float:
        start = clock()
        block(ticks)
        return clock() - start

    return timed


def _make_search_timer(backend: str, search_s: float) -> Timer:
    seeds = count(SEED)

    def search() -> float:
        result = run(RunRequest("green-search", backend, world="clutter", seed=next(seeds), timeout_s=search_s))
        return result.wall_time_s / result.sim_time_s

    return search


def make_framework_block(backend: str, robot: RobotDescription, world: WorldDescription, **options: str) -> Block:
    behaviour = LookRound()
    setup = Setup(robot, world, needed_devices(robot, behaviour.needs), RATE_HZ, options=options)
    raw = load_backend(backend).open(setup)
    loop = Loop(assemble(raw, robot, RATE_HZ), behaviour, RATE_HZ, timeout=math.inf)

    def block(ticks: int) -> None:
        behaviour.left = ticks
        loop.run()

    return block


if __name__ == "__main__":
    sys.exit(main())
