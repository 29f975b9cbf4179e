"""The loops of `benchmarks.loop` as a user writes them, with the functions of PyBullet and MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2

from drivers.mujoco.model import build, compile_model
from drivers.mujoco.model.attributes import CAMERA_GROUPS, group_flags
from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import BulletScene
from robotcore.autonomy.vision import ColourDetector
from robotcore.description import RobotDescription, WorldDescription
from robotcore.kinds.camera import CameraDescription

RATE_HZ, STEPS_A_TICK = 20.0, 12
WHEEL_RAD_S = 0.001

Block = Callable[[int], object]
"""A function that executes a number of ticks."""


def build_mujoco_loop(robot: RobotDescription, world: WorldDescription) -> Block:
    """Return the loop for MuJoCo, with the renderer and the functions of MuJoCo's Python documentation.

    The model is that of the backend, so the camera sees no robot and no shadows, but the sky.
    """
    import mujoco

    assert robot.drive
    (left_motor,), (right_motor,) = robot.drive.left_motors, robot.drive.right_motors
    model = compile_model(build(robot, world, 1 / (RATE_HZ * STEPS_A_TICK)))
    data = mujoco.MjData(model)
    (camera,) = robot.all_of(CameraDescription)
    renderer = mujoco.Renderer(model, camera.height_px, camera.width_px)
    options = mujoco.MjvOption()
    options.geomgroup[:] = group_flags(CAMERA_GROUPS)
    left, right = model.actuator(left_motor).id, model.actuator(right_motor).id
    detector = ColourDetector("green")

    def block(ticks: int) -> None:
        for _ in range(ticks):
            renderer.update_scene(data, camera=camera.name, scene_option=options)
            detector.find(cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2BGR), camera.intrinsics)
            data.ctrl[left], data.ctrl[right] = -WHEEL_RAD_S, WHEEL_RAD_S
            mujoco.mj_step(model, data, nstep=STEPS_A_TICK)

    return block


def build_pybullet_loop(robot: RobotDescription, world: WorldDescription) -> Block:
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
