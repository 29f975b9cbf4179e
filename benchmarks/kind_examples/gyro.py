"""A gyroscope, which measures the turn rate, and the angle since the start."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from robotcore.description import DeviceDescription
from robotcore.geometry import wrap_angle
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.simulation_state import SimulationState


class GyroDescription(DeviceDescription):
    """The table of a gyroscope in a robot's file."""

    kind: Literal["gyro"]
    noise_rad_s: Annotated[float, Field(ge=0, le=1)] = 0.01


@dataclass(frozen=True, slots=True)
class Turn:
    """A sample of a gyroscope."""

    rate: Annotated[float, Unit("rad/s")]
    angle: Annotated[float, Unit("rad")]
    time: float
    sequence: int


class Gyro(Sensor[Turn]):
    """A gyroscope. A driver for a board inherits it."""

    kind = "gyro"


def simulate(gyro: GyroDescription, state: SimulationState) -> Callable[[float, int], Turn]:
    """Return a function that takes a sample from the true state of the robot."""
    start = state.pose().heading

    def take(time: float, sequence: int) -> Turn:
        rate = state.twist().angular + state.draw_noise(gyro.name, gyro.noise_rad_s, time)
        return Turn(rate, wrap_angle(state.pose().heading - start), time, sequence)

    return take


def check_rate(_robot: Any, gyro: Gyro) -> None:
    """Check that the rate of a robot at rest is small."""
    assert abs(gyro.read().rate) < 0.2, f"{gyro.name} turns at rest"


KIND = Kind("a gyroscope", GyroDescription, Gyro, Turn, simulate, rules=(check_rate,))
