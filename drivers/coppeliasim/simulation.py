"""One robot in one world, both built in a scene, and how each of its devices is opened."""

from __future__ import annotations

from drivers.coppeliasim.connection import LOADING_S, Connection
from drivers.coppeliasim.eyes import add_vision_sensor
from drivers.coppeliasim.placing import LOOK, mounted, on_floor
from drivers.coppeliasim.ranging import FanRangeSensor, add_fan
from drivers.coppeliasim.rover import BuiltRobot, build_robot
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.tidying import Undo, borrow, ours, require_empty, tidy
from drivers.coppeliasim.truth import CoppeliaSimTruth, Touches
from drivers.coppeliasim.wheels import BuiltEncoder, BuiltMotor
from drivers.coppeliasim.workshop import Workshop
from drivers.coppeliasim.world import BuiltWorld, build_world
from robotcore.backend import Setup
from robotcore.clock import SteppedClock
from robotcore.description import (
    AnyDevice,
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    WorldDescription,
)
from robotcore.devices import Device
from robotcore.errors import BackendError, DeviceError
from robotcore.scene import State
from robotcore.scene.pictures import SceneCamera, SceneDisplay

SCREEN = (320, 240)
_SCREEN_FOV_RAD = 1.0
_SCREEN_HEIGHT_M = 3.0


class Simulation:
    """The world, the robot in it, and the clock that moves both."""

    def __init__(self, connection: Connection, setup: Setup, world: WorldDescription) -> None:
        self._connection = connection
        self._setup = setup
        self._workshop = Workshop(connection)
        self._scene = CoppeliaSimScene(connection)
        self._start = on_floor(world.start.pose)
        undo = self._set_time_step(1 / setup.rate_hz)
        self.world: BuiltWorld = build_world(self._workshop, world)
        undo += [("destroyCollection", collection) for collection in (self.world.seen, self.world.met)]
        borrow(self._workshop, self.world.root, world.light, undo)
        self._sky = sum(world.light.sky_colour) / 3 / 255
        self.robot: BuiltRobot = build_robot(self._workshop, setup.robot, world.start.pose)
        self._workshop.mark(self.robot.body, "[]")
        self._sensors = {told.name: handle for told in setup.chosen if (handle := self._add_sensor(told)) >= 0}
        self._touches = Touches(connection, self.robot.body, self.world.things)
        self._motors: list[BuiltMotor] = []
        self.clock = SteppedClock(setup.rate_hz, self._advance, self._scene.time_step())
        self.truth = CoppeliaSimTruth(connection, self.robot.body, self.robot.frame, self._touches)

    def start(self) -> None:
        """Let it run, in lockstep; before its first step nothing has come to rest."""
        self._scene.start()
        self._scene.advance(1)

    def open(self, told: AnyDevice) -> Device:
        """Open one device; raises DeviceError where it sits on a wheel that is not there."""
        if isinstance(told, MotorDescription):
            motor = BuiltMotor(self._scene, told, self._joint_of(told.name), self.clock.step)
            self._motors.append(motor)
            return motor
        if isinstance(told, EncoderDescription):
            return BuiltEncoder(self._scene, told, self._joint_of(told.name), self.clock)
        sensor = self._sensors[told.name]
        if isinstance(told, RangeSensorDescription):
            return FanRangeSensor(self._connection, told, sensor, self.clock)
        if isinstance(told, CameraDescription):
            return SceneCamera(told.name, told.intrinsics, self._scene, sensor, self.clock)
        display: DisplayDescription = told  # of a new kind of device, the type checker tells
        return SceneDisplay(display.name, self._scene, sensor)

    def close(self) -> None:
        """Stop, and remove what was made."""
        self._scene.stop()
        tidy(self._workshop)

    def _advance(self, steps: int) -> None:
        for _ in range(steps):
            for motor in self._motors:
                motor.drive()
            self._scene.advance(1)
            self._touches.look()

    def _add_sensor(self, told: AnyDevice) -> int:
        workshop, body = self._workshop, self.robot.body
        if isinstance(told, RangeSensorDescription):
            return add_fan(workshop, told, body, self._start, self.world.met)
        if isinstance(told, CameraDescription):
            place = self._start.at(mounted(told.mount))
            size = (told.width_px, told.height_px)
            fov = told.horizontal_fov_rad
            return add_vision_sensor(workshop, told.name, place, body, size, fov, empty=self._sky, seen=self.world.seen)
        if isinstance(told, DisplayDescription):
            place = self._start.at(LOOK._replace(z=_SCREEN_HEIGHT_M))
            return add_vision_sensor(workshop, told.name, place, body, SCREEN, _SCREEN_FOV_RAD)
        return -1

    def _joint_of(self, name: str) -> int:
        if name not in self.robot.joints:
            raise DeviceError(name, "sits on no wheel; name it in the robot's drive")
        return self.robot.joints[name]

    def _set_time_step(self, step_s: float) -> list[Undo]:
        """Let the simulation step so; return how that is undone."""
        parameter = self._connection.constant("floatparam_simulation_time_step")
        before = self._scene.time_step()
        self._connection.sim("setFloatParam", parameter, step_s, within_s=LOADING_S)
        if abs((got := self._scene.time_step()) - step_s) > 1e-6 * step_s:
            raise BackendError(
                f"coppeliasim: the simulation's time step was set to {step_s:g} s and is {got:g} s. "
                "Is a simulation running, or does the scene fix it? Open a new scene in CoppeliaSim"
            )
        return [("setFloatParam", parameter, before)]


def make_room(connection: Connection) -> None:
    """Recover the scene from a program that was killed; raise BackendError where somebody else uses it."""
    scene, workshop = CoppeliaSimScene(connection), Workshop(connection)
    if scene.state() is not State.STOPPED:
        if not ours(workshop):
            raise BackendError(
                f"coppeliasim: a simulation of somebody's is {scene.state().value} in the CoppeliaSim at "
                f"{connection.address}. Stop it, and run again"
            )
        scene.stop()
    tidy(workshop)
    require_empty(workshop)
