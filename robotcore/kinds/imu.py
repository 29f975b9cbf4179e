"""An inertial measurement unit (IMU), which measures the turn rate, the acceleration and the heading."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import Field

from robotcore.description import Ideal, SensorDescription
from robotcore.geometry import wrap_angle
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.device_test import REVERSED, DeviceTest
from robotcore.hal.kind import Kind
from robotcore.hal.simulation_state import SimulationState

__all__ = ["KIND", "Imu", "ImuDescription", "ImuSample"]


class ImuDescription(SensorDescription):
    """An inertial measurement unit. The errors are those of a simulated one.

    >>> imu = ImuDescription(kind="imu", name="imu", yaw_rate_bias_rad_s=0.01, rate_hz=100)
    >>> imu.idealise().yaw_rate_bias_rad_s
    0.0
    """

    kind: Literal["imu"]
    yaw_rate_noise_rad_s: Annotated[float, Field(ge=0, le=10), Ideal(0.0)] = 0.0
    """The standard deviation of the turn rate, in rad/s."""
    yaw_rate_bias_rad_s: Annotated[float, Field(ge=-10, le=10), Ideal(0.0)] = 0.0
    """The constant error of the turn rate, in rad/s."""
    acceleration_noise_m_s2: Annotated[float, Field(ge=0, le=100), Ideal(0.0)] = 0.0
    """The standard deviation of each acceleration, in m/s²."""
    heading_noise_rad: Annotated[float, Field(ge=0, le=math.pi), Ideal(0.0)] = 0.0
    """The standard deviation of the heading, in radians, in addition to the integrated errors of the turn rate."""


@dataclass(frozen=True, slots=True)
class ImuSample:
    """A sample of an IMU. The axes are those of the robot, and gravity is not part of the acceleration.

    >>> sample = ImuSample(0.5, 0.0, 0.1, heading=1.57, time=1.25, sequence=25)
    >>> sample.format_values()
    'yaw rate 0.50 rad/s, forward acceleration 0.00 m/s², left acceleration 0.10 m/s², heading 1.57 rad'
    """

    yaw_rate: Annotated[float, Unit("rad/s")]
    """The turn rate, in rad/s, positive to the left."""
    forward_acceleration: Annotated[float, Unit("m/s²")]
    """The acceleration along the robot's x axis, in m/s²."""
    left_acceleration: Annotated[float, Unit("m/s²")]
    """The acceleration along the robot's y axis, in m/s². In a curve it points to the centre of the curve."""
    heading: Annotated[float, Unit("rad")]
    """The angle from -π to π by which the robot has turned since it was opened, in radians, positive to the left.

    It is the integral of the turn rate, and drifts with the errors of the turn rate.
    """
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class Imu(Sensor[ImuSample]):
    """A sensor that measures the turn rate, the acceleration and the heading.

    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.imu import ImuDescription, ImuSample
    >>> description = ImuDescription(kind="imu", name="imu")
    >>> imu = build_sensor(description, lambda: ImuSample(0.5, 0.0, 0.1, heading=1.57, time=1.25, sequence=25))
    >>> imu.read().yaw_rate, imu.read().heading
    (0.5, 1.57)
    """

    kind = "imu"

    def limit_sample(self, sample: ImuSample) -> ImuSample:
        return replace(sample, heading=wrap_angle(sample.heading))


class ImuSimulation:
    """Takes samples of an IMU at the axle's centre.

    The forward acceleration is the mean since the last sample. The left acceleration is the product of the velocity and
    the turn rate, without the sideways slip that a simulator of physics may have. The noise of the turn rate is
    integrated as constant between two samples.
    """

    def __init__(self, imu: ImuDescription, state: SimulationState) -> None:
        self._imu, self._state = imu, state
        self._start = state.pose().heading
        self._time, self._speed = state.clock.now(), state.twist().linear
        self._acceleration = self._drift = 0.0

    def __call__(self, time: float, sequence: int) -> ImuSample:
        """Return a sample at a time in seconds."""
        imu, (speed, turn) = self._imu, self._state.twist()
        error = imu.yaw_rate_bias_rad_s + self._draw_noise("yaw_rate", imu.yaw_rate_noise_rad_s, time)
        if passed := time - self._time:
            self._acceleration = (speed - self._speed) / passed
            self._drift += error * passed
            self._time, self._speed = time, speed
        heading = self._state.pose().heading - self._start + self._drift
        return ImuSample(
            turn + error,
            self._acceleration + self._draw_noise("forward", imu.acceleration_noise_m_s2, time),
            speed * turn + self._draw_noise("left", imu.acceleration_noise_m_s2, time),
            wrap_angle(heading + self._draw_noise("heading", imu.heading_noise_rad, time)),
            time,
            sequence,
        )

    def _draw_noise(self, field: str, sigma: float, time: float) -> float:
        return self._state.draw_noise(f"{self._imu.name}:{field}", sigma, time)


def simulate(imu: ImuDescription, state: SimulationState) -> Callable[[float, int], ImuSample]:
    """Return a function that takes a sample from the true pose and velocity, with the described errors."""
    return ImuSimulation(imu, state)


TURN_S = 3.0
"""The time for which the person turns the robot, in seconds."""

LEAST_TURN_RAD = 0.15
"""A smaller turn shows nothing, in radians."""

PUSH_SHARE, PUSH_S = 0.2, 0.6
"""The velocity of one motor that turns a simulated robot, as a share of its greatest, and the duration in seconds."""


def test_imus(test: DeviceTest, imus: Sequence[Any]) -> None:
    """Let the person turn the robot to the left by hand, and compare the heading of each IMU."""
    for imu in imus:
        device = test.robot.devices[imu.name]
        assert isinstance(device, Imu)
        before = device.read().heading
        text = f"Press Enter, and then turn the whole robot to the left by about 90° within {TURN_S:g} s"
        if not test.instruct(imu.name, "turn", text, lambda _state: None):
            test.skip(imu.name, "no person turns the robot")
            continue
        direction, undo = _turn_simulated(test) if test.state else _wait(test)
        turned = wrap_angle(device.read().heading - before)
        undo()
        if direction == 0:
            test.skip(imu.name, "no motor turns the simulated robot")
        elif abs(turned) < LEAST_TURN_RAD:
            test.fail(imu.name, "does not measure the turn", "Check its wires and its address", "imu-dead")
        elif turned * direction > 0:
            test.confirm(imu.name, "measures turns positive to the left")
        else:
            remedy = "Turn the chip over, or change is_upside_down"
            test.correct(
                imu.name, "measures turns to the left as negative", REVERSED, remedy=remedy, kind="imu-reversed"
            )


def _wait(test: DeviceTest) -> tuple[int, Callable[[], None]]:
    test.wait(TURN_S)
    return 1, lambda: None


def _turn_simulated(test: DeviceTest) -> tuple[int, Callable[[], None]]:
    """Turn a simulated robot by one of its motors.

    Return 1 if it has turned to the left, -1 if to the right, else 0, and a function that turns it back.
    """
    state = test.state
    assert state
    for motor in test.robot.motors.values():
        before = state.pose().heading
        push = partial(_push, test, motor)
        push(PUSH_SHARE)
        turned = wrap_angle(state.pose().heading - before)
        if abs(turned) > LEAST_TURN_RAD:
            return 1 if turned > 0 else -1, partial(push, -PUSH_SHARE)
    return 0, lambda: None


def _push(test: DeviceTest, motor: Any, share: float) -> None:
    test.repeat(partial(motor.set_velocity, share * motor.max_velocity), PUSH_S)
    motor.stop()
    test.wait(PUSH_S / 2)


KIND = Kind(
    "a sensor of turn rate, acceleration and heading", ImuDescription, Imu, ImuSample, simulate, test_devices=test_imus
)
"""The kind `imu`, which the entry point of this name refers to."""
