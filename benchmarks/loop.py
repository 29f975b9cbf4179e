"""Measure what the framework costs a real loop, and what a simulator without physics saves.

    python -m benchmarks.loop

Each tick reads a picture of 320 × 240 at 20 Hz, looks for the ball in it, and commands two motors. Physics runs at
240 Hz. The loop exists twice: written by hand with PyBullet's own functions, and as an app with all layers, safety and
odometry of a real run. The robots hardly move, so both get the same pictures. Then the app's loop on MuJoCo is compared
with PyBullet, and so are the first seconds of green-search on the kinematic simulator. All is timed in pairs. The exit
status is 1 if a bound is broken.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from itertools import count
from time import perf_counter

import cv2

from benchmarks.report import measure_ratio, parse_options, print_table
from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import BulletScene
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

SEED = 1
RATE_HZ, STEPS_A_TICK = 20.0, 12
WHEEL_RAD_S = 0.001
RAW_BOUND, MUJOCO_BOUND, KINEMATIC_BOUND = 0.98, 3.0, 5.0

Block = Callable[[int], object]
"""A function that executes a number of ticks."""

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
    options = parse_options(__doc__, pairs=30, ticks=20, search=8.0)
    cv2.setNumThreads(1)
    robot = load_robot("rover")
    world = draw_world(load_world("clutter"), robot, SEED)
    pybullet, mujoco = (
        make_timer(make_framework_block(backend, robot, world), options.ticks) for backend in ("pybullet", "mujoco")
    )
    by_hand = make_timer(_build_loop_by_hand(robot, world), options.ticks)
    slow, fast = (_make_search_timer(backend, options.search) for backend in ("pybullet", "kinematic"))
    cases = (
        ("a loop on PyBullet, against the same by hand", by_hand, pybullet, RAW_BOUND),
        ("the loop on MuJoCo, against PyBullet", pybullet, mujoco, MUJOCO_BOUND),
        ("green-search on the kinematic simulator, against PyBullet", slow, fast, KINEMATIC_BOUND),
    )
    rows, is_met = [], True
    for claim, slower, faster, bound in cases:
        ratio = measure_ratio(slower, faster, options.pairs)
        rows.append((claim, *ratio.format_cells(".3f"), f"≥ {bound:g}"))
        is_met &= ratio.median >= bound
    print_table((f"speed, {options.pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return int(not is_met)


def make_timer(block: Block, ticks: int) -> Timer:
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


def make_framework_block(backend: str, robot: RobotDescription, world: WorldDescription) -> Block:
    behaviour = LookRound()
    raw = load_backend(backend).open(Setup(robot, world, needed_devices(robot, behaviour.needs), RATE_HZ))
    loop = Loop(assemble(raw, robot, RATE_HZ), behaviour, RATE_HZ, timeout=math.inf)

    def block(ticks: int) -> None:
        behaviour.left = ticks
        loop.run()

    return block


def _build_loop_by_hand(robot: RobotDescription, world: WorldDescription) -> Block:
    """Return the loop for PyBullet, with TinyRenderer and Bullet's own functions."""
    assert robot.drive
    (left_motor,), (right_motor,) = robot.drive.left_motors, robot.drive.right_motors
    bullet = Bullet.connect(gui=False)
    scene, body = BulletScene(bullet, world), Body(bullet, robot, world.start.pose)
    body.hide()
    bullet.setGravity(0.0, 0.0, -9.81)
    bullet.setPhysicsEngineParameter(fixedTimeStep=1 / (RATE_HZ * STEPS_A_TICK))
    (left,), (right,) = body.find_joints(left_motor), body.find_joints(right_motor)
    (camera,) = robot.all_of(CameraDescription)
    mount, light, detector = camera.mount, scene.light, ColourDetector("green")
    tall = 2 * math.degrees(math.atan(camera.height_px / 2 / camera.intrinsics.focal_length))
    projection = bullet.computeProjectionMatrixFOV(tall, camera.width_px / camera.height_px, 0.005, 500.0)

    def block(ticks: int) -> None:
        for _ in range(ticks):
            pose = body.pose()
            ahead = math.cos(pose.heading), math.sin(pose.heading)
            eye = pose.x + mount.x_m * ahead[0], pose.y + mount.x_m * ahead[1], mount.z_m
            view = bullet.computeViewMatrix(eye, (eye[0] + ahead[0], eye[1] + ahead[1], eye[2]), (0.0, 0.0, 1.0))
            rgba = bullet.getCameraImage(
                camera.width_px,
                camera.height_px,
                view,
                projection,
                lightDirection=light.direction,
                lightAmbientCoeff=light.ambient,
                lightDiffuseCoeff=light.diffuse,
                lightSpecularCoeff=0.0,
                shadow=0,
                renderer=bullet.ER_TINY_RENDERER,
            )[2]
            detector.find(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), camera.intrinsics)
            for joint, velocity in ((left, -WHEEL_RAD_S), (right, WHEEL_RAD_S)):
                bullet.setJointMotorControl2(
                    body.body_id, joint, bullet.VELOCITY_CONTROL, targetVelocity=velocity, force=0.08
                )
            for _ in range(STEPS_A_TICK):
                bullet.stepSimulation()

    return block


if __name__ == "__main__":
    sys.exit(main())
