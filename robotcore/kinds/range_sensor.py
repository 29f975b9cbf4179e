"""A sensor that measures the distance to the nearest body, such as an ultrasonic module."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field, model_validator

from robotcore.description import Body, Ideal, Mount, SensorDescription
from robotcore.description.types import SensorRange
from robotcore.errors import Mistake
from robotcore.hal.clock import Clock
from robotcore.hal.device import Rays, Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.noise import draw_noise, random_at
from robotcore.hal.sample_text import format_fields
from robotcore.hal.sampling import capture_at_once, delay_samples
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.device_tests.ranges import test_ranges
from robotcore.raycast import FAN_SETBACK_M, Fan

__all__ = ["KIND", "Range", "RangeSensor", "RangeSensorDescription"]

RAYS = 9
"""The number of rays that show the cone of a sensor."""

LOST_IN_A_ROW = 1e-3
"""Nothing is in range after N samples in a row without an echo.

N is the least number for which the probability that all N echoes were lost is at most this.
"""


ALL_LOST = 0.999
"""The share of lost echoes of a sensor that measures nothing. It limits `RangeSensorDescription.echo_free_samples`."""


class RangeSensorDescription(SensorDescription):
    """A sensor that measures the distance to the nearest body in a cone.

    >>> from robotcore.description import Mount
    >>> nose = RangeSensorDescription(
    ...     kind="range_sensor", name="nose", mount=Mount(x_m=0.14, z_m=0.1), min_range_m=0.02, max_range_m=2.0,
    ...     cone_rad=0.52, loss=0.1,
    ... )
    >>> nose.echo_free_samples  # samples without an echo until nothing is in range
    3
    >>> nose.idealise().loss
    0.0
    """

    kind: Literal["range_sensor"]
    mount: Mount
    min_range_m: SensorRange
    """The shortest distance that the sensor measures, in metres. A nearer body is measured at this distance."""
    max_range_m: SensorRange
    """The longest distance that the sensor measures, in metres. For a farther body, the sensor returns ``inf``."""
    cone_rad: Annotated[float, Field(ge=0, lt=math.pi)]
    """The full opening angle of the cone, in radians."""
    offset_m: Annotated[float, Field(ge=-1, le=1), Ideal(0.0)] = 0.0
    """The constant error of the measured distances, in metres. A run compensates it."""
    noise_m: Annotated[float, Field(ge=0, le=1), Ideal(0.0)] = 0.0
    """The standard deviation of the measured distances, in metres."""
    loss: Annotated[float, Field(ge=0, le=1), Ideal(0.0)] = 0.0
    """The share of measurements without an echo, from 0 to 1. Each returns ``inf``, like a body that is too far."""

    @model_validator(mode="after")
    def _ranges_in_order(self) -> RangeSensorDescription:
        if self.min_range_m >= self.max_range_m:
            problem = f"min_range_m, {self.min_range_m:g} m, is not below max_range_m, {self.max_range_m:g} m"
            raise Mistake(problem, "Correct one of them", kind="ranges-in-wrong-order")
        return self

    @property
    def echo_free_samples(self) -> int:
        """The number of samples in a row without an echo that show that nothing is in range.

        With the share ``loss`` of lost echoes, fewer samples in a row may all be lost. See `LOST_IN_A_ROW`.
        """
        if not self.loss:
            return 1
        return math.ceil(math.log(LOST_IN_A_ROW) / math.log(min(self.loss, ALL_LOST)))

    def configure(self, device: RangeSensor) -> None:
        super().configure(device)
        device.echo_free_samples, device.noise = self.echo_free_samples, self.noise_m

    def looks_ahead(self, mount: Mount) -> bool:
        return mount.is_ahead

    def find_nearest_ahead(self, mount: Mount, front_x_m: float) -> float:
        # A sensor that reads too little reads its minimum for a body that is farther away.
        return self.min_range_m - min(self.offset_m, 0.0)

    def arguments(self) -> dict[str, Any]:
        return {"min_range": self.min_range_m, "max_range": self.max_range_m, "cone": self.cone_rad}


@dataclass(frozen=True, slots=True)
class Range:
    """A sample of a range sensor.

    >>> Range(distance=0.84, time=1.25, sequence=25)
    Range 0.84 m at 1.25 s
    """

    distance: Annotated[float, Unit("m")]
    """The distance in metres; ``inf`` if nothing is in range."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""
    point: tuple[float, float, float] | None = None
    """The detected point in the sensor's frame, in metres. Only some simulators provide it."""

    def format_values(self) -> str:
        return "nothing in range" if self.distance == math.inf else format_fields(self)


class RangeSensor(Sensor[Range]):
    """A sensor that measures the distance to the nearest body in a cone, such as an ultrasonic module.

    An app reads the first range sensor as ``robot.range``. A distance is ``inf`` if nothing is in range.

    name: the name of the sensor, as in the robot's file.
    min_range, max_range: the shortest and the longest distance that the sensor measures, in metres. A shorter distance
        is returned as ``min_range``.
    cone: the full opening angle of the cone in radians.

    ``mount`` is the sensor's pose on the robot in the plane. A run sets it from the robot's description.

    >>> import math
    >>> from robotcore.testing import MockRobot
    >>> mock = MockRobot(range=[0.84, math.inf])  # one distance a tick, in metres
    >>> sensor = mock.layered.range
    >>> sensor.read()
    Range 0.84 m at 0.00 s
    >>> mock.advance()
    >>> sensor.read().distance, sensor.max_range
    (inf, 2.0)
    """

    kind = "range_sensor"
    has_rays = True
    echo_free_samples: int = 1
    """The number of samples in a row without an echo that show that nothing is in range.

    A run sets it from the robot's description. It is greater than 1 for a sensor that loses echoes.
    """
    noise: float = 0.0
    """The standard deviation of the distances, in metres. A run sets it from the robot's description."""

    def __init__(self, name: str, *, min_range: float, max_range: float, cone: float) -> None:
        super().__init__(name)
        self.min_range, self.max_range, self.cone = min_range, max_range, cone

    def list_rays(self, sample: Range) -> Rays:
        """Return rays of one distance across the cone, because the echo may come from any direction in it."""
        return Rays(-self.cone / 2, self.cone / 2, (float(sample.distance),) * RAYS)

    def change_distances(self, sample: Range, change: Callable[[float, int], float]) -> Range:
        return self.limit_sample(replace(sample, distance=change(sample.distance, 0)))

    def limit_sample(self, sample: Range) -> Range:
        """Return a sample within the sensor's range.

        A distance below the range becomes the sensor's minimum. A distance beyond the range becomes ``inf``.
        """
        if sample.distance > self.max_range:
            return replace(sample, distance=math.inf, point=None)
        return replace(sample, distance=max(sample.distance, self.min_range))

    def measure_ahead(self, sample: Range, mount: Mount, body: Body) -> float:
        return sample.distance


def validate_sample(_sensor: RangeSensorDescription, sample: Range) -> Range:
    """Return a scripted sample. Raises ValueError if its distance is NaN or negative."""
    if not sample.distance >= 0:
        raise ValueError("a distance in metres, inf")
    return sample


class Echo(NamedTuple):
    """The distance of an echo, and the point that it came from."""

    distance: float
    """The distance in metres; ``inf`` if nothing is within the sensor's range."""
    point: tuple[float, float, float] | None
    """The point in the sensor's frame, in metres; None if it is unknown or nothing is within the sensor's range."""


class EchoErrors:
    """Adds the offset, the noise and the lost echoes of a description to the distances of a simulated sensor.

    The seed, the sensor's name and the time determine the errors.
    """

    def __init__(self, sensor: RangeSensorDescription, seed: int) -> None:
        self._sensor, self._key = sensor, f"{seed}:{sensor.name}"

    def apply(self, reading: Range) -> Range:
        """Return the reading with its errors, within the sensor's range."""
        sensor, time = self._sensor, reading.time
        if sensor.loss and random_at(f"{self._key}:loss", time).random() < sensor.loss:
            return replace(reading, distance=math.inf, point=None)
        if not (sensor.offset_m or sensor.noise_m) or math.isinf(reading.distance):
            return reading
        noise = draw_noise(f"{self._key}:distance", sensor.noise_m, time) if sensor.noise_m else 0.0
        distance = reading.distance + sensor.offset_m + noise
        if distance > sensor.max_range_m:
            return replace(reading, distance=math.inf, point=None)
        return replace(reading, distance=max(distance, sensor.min_range_m))


class SimulatedRangeSensor(RangeSensor):
    """A simulated range sensor, with the latency and the errors of its description.

    measure: returns the echo that the sensor would receive now without errors.
    seed: the seed of the errors.
    """

    def __init__(
        self, description: RangeSensorDescription, clock: Clock, measure: Callable[[], Echo], seed: int
    ) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        errors = EchoErrors(description, seed)

        def take(time: float, sequence: int) -> Range:
            echo = measure()
            return errors.apply(Range(echo.distance, time, sequence, echo.point))

        self._newest_at = delay_samples(clock, description, capture_at_once(take))

    def _newest(self) -> Range:
        return self._newest_at()

    def _release(self) -> None:
        self._newest_at.close()


def simulate(sensor: RangeSensorDescription, state: SimulationState) -> Callable[[float, int], Range]:
    """Return a function that takes a sample: the nearest hit of a fan of rays, with the errors of the description."""
    fan, errors = Fan(sensor.cone_rad, sensor.min_range_m, sensor.max_range_m), EchoErrors(sensor, state.seed)

    def take(time: float, sequence: int) -> Range:
        start, directions = fan.rays(state.joints.locate(sensor.mount))
        lengths = state.cast(start, directions, sensor.max_range_m + 2 * FAN_SETBACK_M)
        return errors.apply(Range(fan.reading(lengths), time, sequence, fan.point(lengths)))

    return take


KIND = Kind(
    "a sensor of the distance to the nearest body",
    RangeSensorDescription,
    RangeSensor,
    Range,
    simulate,
    default_reading=lambda _sensor: math.inf,
    validate_sample=validate_sample,
    test_devices=test_ranges,
)
"""The kind `range_sensor`, which the entry point of this name refers to."""
