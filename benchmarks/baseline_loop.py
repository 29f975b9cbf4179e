"""The loop of `benchmarks.loop`, written by hand for one simulator. Only the scene comes from the driver.

Each function takes a robot and a world, and returns a function that executes a number of ticks.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from types import MappingProxyType

import cv2

from drivers.mujoco.model import build
from drivers.mujoco.model.attributes import CAMERA_GROUPS, group_flags
from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import Scene
from robotcore.autonomy.vision import ColourDetector
from robotcore.description import CameraDescription, RobotDescription, WorldDescription

os.environ.setdefault("MUJOCO_GL", "egl")  # MuJoCo reads it at its first import; otherwise its renderer needs a screen

RATE_HZ, STEPS_A_TICK = 20.0, 12
WHEEL_RAD_S = 0.001

Block = Callable[[int], object]
"""A function that executes a number of ticks."""


def build_pybullet_loop(robot: RobotDescription, world: WorldDescription) -> Block:
    """Return the loop for PyBullet, with TinyRenderer and Bullet's own functions."""
    assert robot.drive
    bullet = Bullet.connect(gui=False)
    scene, body = Scene(bullet, world), Body(bullet, robot, world.start.pose)
    body.hide()
    bullet.setGravity(0.0, 0.0, -9.81)
    bullet.setPhysicsEngineParameter(fixedTimeStep=1 / (RATE_HZ * STEPS_A_TICK))
    left, right = body.find_joint(robot.drive.left), body.find_joint(robot.drive.right)
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


def build_mujoco_loop(robot: RobotDescription, world: WorldDescription) -> Block:
    """Return the loop for MuJoCo, with its own renderer. One call executes all physics steps of a tick."""
    import mujoco

    assert robot.drive
    (camera,) = robot.all_of(CameraDescription)
    spec = build(robot, world, 1 / (RATE_HZ * STEPS_A_TICK))
    spec.visual.global_.offwidth, spec.visual.global_.offheight = camera.width_px, camera.height_px
    model = spec.compile()
    data = mujoco.MjData(model)
    renderer, detector = mujoco.Renderer(model, camera.height_px, camera.width_px), ColourDetector("green")
    seen = mujoco.MjvOption()
    seen.geomgroup[:] = group_flags(CAMERA_GROUPS)
    left, right = model.actuator(robot.drive.left).id, model.actuator(robot.drive.right).id
    mujoco.mj_forward(model, data)

    def block(ticks: int) -> None:
        for _ in range(ticks):
            renderer.update_scene(data, camera.name, seen)
            detector.find(cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2BGR), camera.intrinsics)
            data.ctrl[left], data.ctrl[right] = -WHEEL_RAD_S, WHEEL_RAD_S
            mujoco.mj_step(model, data, STEPS_A_TICK)

    return block


BASELINES: Mapping[str, Callable[[RobotDescription, WorldDescription], Block]] = MappingProxyType(
    {"pybullet": build_pybullet_loop, "mujoco": build_mujoco_loop}
)
