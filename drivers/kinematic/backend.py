"""The built-in simulator: exact motion, ray-cast ranges, a painted camera; nothing to install."""

from __future__ import annotations

from pydantic import NonNegativeFloat

from robotcore.backend import Backend, Setup, Vouch
from robotcore.description import (
    AnyDevice,
    CameraDescription,
    Described,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
)
from robotcore.devices import Device
from robotcore.display import MemoryDisplay
from robotcore.errors import DeviceError, DeviceGroupError, UsageError
from robotcore.robot import Robot

from drivers.kinematic.devices import KinematicCamera, KinematicEncoder, KinematicMotor, KinematicRangeSensor
from drivers.kinematic.motion import Wheel
from drivers.kinematic.noise import Noise
from drivers.kinematic.simulation import Simulation


class KinematicOptions(Described):
    """What a user may set: standard deviations, in grey levels and in metres."""

    camera_noise: NonNegativeFloat = 0.0
    range_noise_m: NonNegativeFloat = 0.0


class KinematicBackend(Backend):
    """Opens robots in an exact, fast simulation that knows no mass and no friction.

    Options: see `KinematicOptions`.
    """

    name = "kinematic"
    summary = "built in: exact differential drive, ray-cast ranges, a painted camera"
    vouches_for = frozenset(Vouch)
    needs_world = True

    def open(self, setup: Setup) -> Robot:
        if setup.world is None:
            raise UsageError("the kinematic backend needs a world; name one with --world")
        options = setup.options_as(KinematicOptions)
        simulation = Simulation(setup, setup.world)
        devices, failures = [], []
        for description in setup.chosen:
            try:
                devices.append(_open_device(description, setup, options, simulation))
            except DeviceError as failure:
                failures.append(failure)
        if failures:
            raise DeviceGroupError(f"opening {setup.robot.name}", failures)
        return Robot(setup.robot.name, simulation.clock, devices, truth=simulation)


def _open_device(
    description: AnyDevice, setup: Setup, options: KinematicOptions, simulation: Simulation
) -> Device:
    name = description.name
    if isinstance(description, MotorDescription):
        return KinematicMotor(description, simulation.wheels[name])
    if isinstance(description, EncoderDescription):
        return KinematicEncoder(description, _wheel_of(name, setup.robot, simulation), simulation.clock)
    if isinstance(description, RangeSensorDescription):
        return KinematicRangeSensor(description, simulation, Noise(setup.seed, name, options.range_noise_m))
    if isinstance(description, CameraDescription):
        return KinematicCamera(description, simulation, Noise(setup.seed, name, options.camera_noise))
    return MemoryDisplay(name)


def _wheel_of(encoder: str, robot: RobotDescription, simulation: Simulation) -> Wheel:
    drive = robot.drive
    if drive and encoder == drive.left_encoder:
        return simulation.wheels[drive.left]
    if drive and encoder == drive.right_encoder:
        return simulation.wheels[drive.right]
    raise DeviceError(encoder, "sits on no wheel; name it as left_encoder or right_encoder of the drive")
