"""A Bullet simulation of one robot in one world, and the robot's true state."""

from __future__ import annotations

import math
from functools import cached_property, partial

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.devices import (
    BulletMotor,
    BulletRenderer,
    Steering,
    build_renderer,
    cast_rays,
    open_encoder,
)
from drivers.pybullet.scene import BulletScene
from robotcore.description import AckermannDrive, DeviceDescription, WorldDescription
from robotcore.geometry import Pose, Twist
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.kind import simulate_device
from robotcore.hal.simulation_state import Array, SimulationState
from robotcore.hal.truth import RELEASE_M
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.simulation.body_cameras import CameraSet, needs_sheet
from robotcore.simulation.rigid_body import ContactCounter


class Simulation:
    """A Bullet simulation of one robot in one world, and its devices. It is the `TruthSource` of the run.

    The steps of ``clock`` are physics steps of Bullet.
    """

    def __init__(
        self, bullet: Bullet, setup: Setup, world: WorldDescription, solver_iterations: int, camera: str | None = None
    ) -> None:
        """Add the world and the robot to a server. No device is open.

        camera: `CameraOptions.camera`.
        """
        self._robot, self._world, self._seed = setup.robot, world, setup.seed
        self._bullet, self._has_window = bullet, setup.gui
        self._scene = BulletScene(bullet, world, has_sheet=needs_sheet(setup, camera))
        self._body = Body(bullet, setup.robot, world.start.pose)
        if setup.gui:
            bullet.set_window_view(width_m=max(world.floor.length_m, world.floor.width_m))
        else:
            self._body.hide()
        self.clock = SteppedClock(setup.rate_hz, self._advance)
        self._motors: list[BulletMotor] = []
        self._cameras = CameraSet(camera, self.simulation_state)
        self._steering = self._open_steering()
        self._contacts = ContactCounter()
        self._things = frozenset(self._scene.things.values())
        self._step, self._contact_points = bullet.stepSimulation, bullet.getContactPoints
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.clock.step, numSolverIterations=solver_iterations, deterministicOverlappingPairs=1
        )
        bullet.setGravity(0.0, 0.0, -9.81)

    def open(self, description: DeviceDescription) -> Device:
        """Open a device of the robot. Raises DeviceError for an encoder that is on no wheel.

        A motor that is on no wheel accepts commands without an effect.
        """
        bullet = self._bullet.for_device(description.name)
        body = self._body.with_connection(bullet)
        driven = self._robot.drive.motors if self._robot.drive else ()
        if isinstance(description, MotorDescription) and description.name in driven:
            motor = BulletMotor(bullet, description, body, self.clock.step, self._steering)
            self._motors.append(motor)
            return motor
        if isinstance(description, EncoderDescription):
            return open_encoder(description, self.clock, body)
        if isinstance(description, CameraDescription):
            build_other = None if self._has_window else partial(build_renderer, self._world)  # a window shows the robot
            return self._cameras.open(
                description, body.transform, lambda: BulletRenderer(bullet, self._scene), build_other
            )
        return simulate_device(description, self.simulation_state)

    def close(self) -> None:
        """End the server, and the process that renders pictures. Further calls do nothing."""
        self._cameras.close()
        self._bullet.close()

    def pose(self) -> Pose:
        return self._body.pose()

    def twist(self) -> Twist:
        return self._body.twist()

    def contacts(self) -> int:
        return self._contacts.count

    @cached_property
    def simulation_state(self) -> SimulationState:
        """The state from which kinds of devices are simulated."""
        return SimulationState(
            self._robot,
            self._world,
            self.clock,
            self.pose,
            self.twist,
            self._cast,
            self._list_touched,
            self._seed,
            self._measure_wheel_angles,
        )

    def _measure_wheel_angles(self) -> dict[str, float]:
        motors = self._robot.drive.motors if self._robot.drive else ()
        return {motor: self._body.angle(self._body.find_joints(motor)) for motor in motors}

    def _open_steering(self) -> Steering | None:
        if not isinstance(drive := self._robot.drive, AckermannDrive):
            return None
        joint = self.simulation_state.joints[drive.steering]
        return Steering(self._bullet, self._body, drive, joint, self.clock.step)

    def _cast(self, origin: Array, directions: Array, reach_m: float) -> Array:
        rotation, start = self._body.transform()
        return cast_rays(self._bullet, start + rotation @ origin, directions * reach_m @ rotation.T, reach_m)

    def _list_touched(self) -> list[str]:
        names = {number: name for name, number in self._scene.things.items()}
        return [names[thing] for thing in self._contacts.touched]

    def _advance(self, steps: int) -> None:
        start, length = self.clock.now(), self.clock.step
        for step in range(1, steps + 1):
            if self._steering:
                self._steering.turn(start + step * length)
            for motor in self._motors:
                motor.drive()
            self._step()
            self._count_contacts()

    def _count_contacts(self) -> None:
        """Count the contacts that began in the last physics step, except those with the floor.

        Bullet also lists bodies that are near but do not touch. Their gap is greater than 0.
        """
        points = self._contact_points(bodyA=self._body.body_id, linkIndexA=-1)
        if not (points or self._contacts.touched):  # the usual case; what follows takes longer than Bullet's call
            return
        gaps: dict[int, float] = {}
        for _, _, thing, _, _, _, _, _, gap, *_ in points:
            if thing in self._things:
                gaps[thing] = min(gap, gaps.get(thing, gap))
        touching = {thing for thing, gap in gaps.items() if gap <= 0}
        self._contacts.update(touching, lambda thing: gaps.get(thing, math.inf) <= RELEASE_M)
