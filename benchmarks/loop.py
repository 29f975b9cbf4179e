"""What the framework costs a real loop, and what a simulator without physics saves.

    python -m benchmarks.loop

A picture of 320 × 240 at 20 Hz, the ball looked for in it, two motors, PyBullet's physics at 240 Hz: once written by
hand with PyBullet's own functions, once as an app under all layers, safety and odometry of a real run. The robots all
but stand, so both see the same. Then green-search, the first seconds of it, on PyBullet and on the kinematic simulator.
All is timed in pairs, in turn. Exit status 1 where a bound is broken.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from itertools import count
from time import perf_counter

import cv2

from benchmarks.pairs import paired_ratios
from benchmarks.report import machine, print_table
from drivers.pybullet.backend import PyBulletBackend
from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import Scene
from robotcore.backend import Setup
from robotcore.behaviour import Behaviour, Status
from robotcore.description import (
    CameraDescription,
    RobotDescription,
    WorldDescription,
    draw_world,
    load_robot,
    load_world,
)
from robotcore.layers import assemble, needed_devices
from robotcore.robot import Robot, Role
from robotcore.running.loop import Loop
from robotcore.running.plan import RunRequest
from robotcore.running.session import run
from robotcore.vision import ColourDetector

RATE_HZ, STEPS_A_TICK = 20.0, 12
WHEEL_RAD_S = 0.001
SEED, SEARCH_S = 1, 8.0
RAW_BOUND, KINEMATIC_BOUND = 0.98, 5.0

Block = Callable[[int], object]
"""Takes so many ticks."""


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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=30)
    parser.add_argument("--ticks", type=int, default=20, help="ticks in a block")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    robot = load_robot("rover")
    world = draw_world(load_world("clutter"), robot, SEED)
    by_hand, framed = _by_hand(robot, world), _framed(robot, world)

    def seconds(block: Block) -> Callable[[], float]:
        return lambda: _seconds(lambda: block(asked.ticks))

    raw = paired_ratios(seconds(by_hand), seconds(framed), asked.pairs)
    saved = paired_ratios(_searches("pybullet"), _searches("kinematic"), asked.pairs)
    print(machine())
    rows = [
        ("a loop on PyBullet, against the same by hand", *_told(raw), f"≥ {RAW_BOUND:g}"),
        ("green-search on the kinematic simulator, against PyBullet", *_told(saved), f"≥ {KINEMATIC_BOUND:g}"),
    ]
    print_table((f"speed, {asked.pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return int(raw[0] < RAW_BOUND or saved[0] < KINEMATIC_BOUND)


def _seconds(work: Callable[[], object]) -> float:
    start = perf_counter()
    work()
    return perf_counter() - start


def _searches(backend: str) -> Callable[[], float]:
    """Return what times the beginning of a search, in a new world each time, and tells it for a simulated second."""
    seeds = count(SEED)

    def search() -> float:
        result = run(RunRequest("green-search", backend, world="clutter", seed=next(seeds), timeout_s=SEARCH_S))
        return result.wall_time_s / result.sim_time_s

    return search


def _told(measured: tuple[float, float, float]) -> tuple[str, str]:
    median, low, high = measured
    return f"{median:.3f}", f"{low:.3f} to {high:.3f}"


def _framed(robot: RobotDescription, world: WorldDescription) -> Block:
    """Return a block of ticks under all that a run has."""
    behaviour = LookRound()
    raw = PyBulletBackend().open(Setup(robot, world, needed_devices(robot, behaviour.needs), RATE_HZ))
    loop = Loop(assemble(raw, robot, RATE_HZ), behaviour, RATE_HZ, timeout=math.inf)

    def block(ticks: int) -> None:
        behaviour.left = ticks
        loop.run()

    return block


def _by_hand(robot: RobotDescription, world: WorldDescription) -> Block:
    """Return the same ticks as one would write them for PyBullet alone; only the scene is built by the driver."""
    assert robot.drive
    bullet = Bullet.connect(gui=False)
    scene, body = Scene(bullet, world), Body(bullet, robot, world.start.pose)
    body.hide()
    bullet.setGravity(0.0, 0.0, -9.81)
    bullet.setPhysicsEngineParameter(fixedTimeStep=1 / (RATE_HZ * STEPS_A_TICK))
    left, right = body.joint_of(robot.drive.left), body.joint_of(robot.drive.right)
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
                    body.number, joint, bullet.VELOCITY_CONTROL, targetVelocity=velocity, force=0.08
                )
            for _ in range(STEPS_A_TICK):
                bullet.stepSimulation()

    return block


if __name__ == "__main__":
    sys.exit(main())
