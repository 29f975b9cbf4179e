"""The backend ``kinematic``: the built-in simulator, which needs no installation."""

from __future__ import annotations

from functools import partial

from drivers.kinematic.devices import KinematicMotor, Sonar
from drivers.kinematic.simulation import Simulation
from robotcore.description import DeviceDescription, StrictModel
from robotcore.errors import DeviceError, DeviceGroupError, UsageError
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.device import Device
from robotcore.hal.kind import simulate_device
from robotcore.hal.robot import Robot
from robotcore.hardware import SimulatorBackend
from robotcore.kinds.camera import CameraDescription, Render, SimulatedCamera
from robotcore.kinds.encoder import EncoderDescription, SimulatedEncoder
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription, SimulatedRangeSensor
from robotcore.optics import CameraView, Intrinsics


class KinematicOptions(StrictModel):
    """The options of the backend. It has none."""


class KinematicBackend(SimulatorBackend):
    """Opens a robot in a fast simulation without mass and friction.

    >>> from robotcore.description import load_robot, load_world
    >>> setup = Setup(load_robot("rover"), load_world("open"), devices=frozenset({"nose", "eye"}))
    >>> with KinematicBackend().open(setup) as robot:
    ...     robot.clock.sleep_until(0.5)
    ...     robot.camera.read().image.shape, robot.range.read().time
    True
    ((240, 320, 3), 0.5)
    """

    name = "kinematic"
    summary = "built in: exact motion, ray-cast ranges and painted pictures, without mass and friction"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    encoder_rate_hz = 120.0  # at 20 ticks a second, after every second step

    def open(self, setup: Setup) -> Robot:
        if setup.world is None:
            raise UsageError("the backend 'kinematic' needs a world. Name one with --world", kind="world-missing")
        setup.options_as(KinematicOptions)
        simulation = Simulation(setup, setup.world)
        _require_wheels(setup, simulation)
        devices = self.open_each(setup, simulation.clock, partial(_open_device, simulation))
        return Robot(setup.robot.name, simulation.clock, devices, truth=simulation)


def _require_wheels(setup: Setup, simulation: Simulation) -> None:
    problem = "the encoder is on no wheel. Name it as left_encoder or right_encoder of the drive, or leave it out"
    encoders = [device.name for device in setup.chosen_devices if isinstance(device, EncoderDescription)]
    if stray := [
        DeviceError(name, problem, kind="no-wheel") for name in encoders if name not in simulation.encoded_wheels
    ]:
        raise DeviceGroupError(f"opening {setup.robot.name}", stray)


def _open_device(simulation: Simulation, description: DeviceDescription) -> Device:
    name, locate = description.name, simulation.simulation_state.joints.locate
    if isinstance(description, MotorDescription):
        return KinematicMotor(description, simulation.wheels[name])
    if isinstance(description, EncoderDescription):
        wheel = simulation.encoded_wheels[name]
        return SimulatedEncoder(description, simulation.clock, lambda: wheel.angle)
    if isinstance(description, RangeSensorDescription):
        sonar, mount = Sonar(description, simulation.world), description.mount
        return SimulatedRangeSensor(
            description,
            simulation.clock,
            lambda: sonar.measure(simulation.body_pose, locate(mount)),
            simulation.simulation_state.seed,
        )
    if isinstance(description, CameraDescription):
        mount = description.mount

        def capture(pinhole: Intrinsics) -> Render:
            view = CameraView.of(pinhole, locate(mount), simulation.body_pose)
            return lambda: simulation.painter.picture(view)

        return SimulatedCamera(description, simulation.clock, capture, simulation.simulation_state.seed)
    return simulate_device(description, simulation.simulation_state)
