"""Measures the offset, the noise and the lost echoes of a range sensor before a wall at known distances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.manoeuvres import straight
from robotcore.autonomy.routines import Routine, wait
from robotcore.canvas import SERIES
from robotcore.errors import BlockedError, CalibrationError
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.range_sensor import Range, RangeSensor, RangeSensorDescription
from robotcore.raycast import FAN_SETBACK_M, Fan
from robotcore.view.chart import Chart, Series

Array = NDArray[np.float64]

MIN_ECHOES = 8
"""The least number of echoes at a distance."""

MAX_LOSS = 0.5
"""A distance at which more echoes are lost is out of range."""

MIN_DISTANCES = 2
"""The least number of distances for a fit."""

OUTLIER_FACTOR = 5.0
"""An echo that differs from the median by more standard deviations comes from another thing than the wall."""

MAX_ERROR_M = 0.03
"""The greatest root mean square of the errors that remain after the fit, in metres."""

MIN_SPAN_M = 0.5
"""A scale is fitted if the distances have at least this span, in metres."""

SCALE_DEVIATIONS = 3.0
"""A scale is significant from this many standard deviations on."""

TAPE_M = 0.002
"""The standard deviation of a distance that a person measures by a tape, in metres."""

APPROACH_M_S = 0.1
"""The velocity with which the robot drives towards the wall, in m/s."""

SETTLE_S = 0.5
"""The time for which the robot stands before it measures, in seconds. It is longer than the delay of a sensor."""

MIN_TRUE_M, MAX_TRUE_M = 0.0, 20.0
"""The limits of a true distance, in metres."""


@dataclass
class WallSamples:
    """The samples of a sensor before a wall at one distance."""

    distance_m: float
    """The true distance from the sensor to the wall, in metres."""
    readings: list[Range] = field(default_factory=list)
    """The samples without repetitions, in their order."""
    is_held: bool = False
    """Whether a run repeats the last echo in place of a lost one, because the robot's file describes lost echoes.

    Then each missing sequence number is a lost echo. So the sensor must not be faster than the ticks.
    """

    def add(self, reading: Range) -> None:
        """Add the newest sample. One that was added before is ignored."""
        if not self.readings or reading.sequence != self.readings[-1].sequence:
            self.readings.append(reading)


@dataclass(frozen=True)
class WallResult:
    """The result at one distance."""

    distance_m: float
    """The true distance, in metres."""
    measured_m: float
    """The mean of the echoes from the wall, in metres; NaN if the wall is out of range."""
    noise_m: float
    """The standard deviation of the echoes, in metres; NaN if the wall is out of range."""
    echoes: int
    """The number of echoes."""
    lost: int
    """The number of measurements without an echo."""

    @property
    def loss(self) -> float:
        """The share of measurements without an echo, from 0 to 1."""
        return self.lost / max(self.lost + self.echoes, 1)

    @property
    def is_in_range(self) -> bool:
        """Whether the sensor sees the wall at this distance."""
        return self.echoes >= MIN_ECHOES and self.loss <= MAX_LOSS

    @property
    def error_m(self) -> float:
        """How much the sensor reads too much, in metres."""
        return self.measured_m - self.distance_m


@dataclass(frozen=True)
class RangeFit:
    """The errors of a range sensor."""

    offset_m: float
    """How much the sensor reads too much at each distance, in metres."""
    offset_deviation_m: float
    """The standard deviation of ``offset_m``, in metres."""
    scale: float
    """The part of the error that grows with the distance, per metre; 0 if it is not significant."""
    noise_m: float
    """The standard deviation of a reading, in metres."""
    noise_deviation_m: float
    """The standard deviation of ``noise_m``, in metres."""
    loss: float
    """The share of measurements without an echo in range, from 0 to 1."""
    loss_deviation: float
    """The standard deviation of ``loss``."""
    error_m: float
    """The root mean square of the errors that remain at the distances, in metres."""
    max_range_m: float | None
    """The greatest distance at which the sensor saw the wall, if it did not see it farther away. Otherwise None."""
    walls: tuple[WallResult, ...]
    """The results in the order of their distances."""


def fit_range(walls: Sequence[WallSamples], sensor: RangeSensorDescription) -> RangeFit:
    """Return the errors of a sensor.

    Raises CalibrationError if the sensor sees the wall at too few distances, or if the errors have no common offset.
    """
    period = _find_period(walls)
    results = sorted((_evaluate(samples, period) for samples in walls), key=lambda result: result.distance_m)
    seen = [each for each in results if each.is_in_range and each.distance_m > sensor.min_range_m]
    if len(seen) < MIN_DISTANCES:
        places = ", ".join(f"{each.distance_m:g} m" for each in seen) or "no distance"
        raise CalibrationError(
            f"{sensor.name} measured the wall at {places}. {MIN_DISTANCES} distances are needed between "
            f"{sensor.min_range_m:g} m and {sensor.max_range_m:g} m. The wall must be flat, hard, and square to the "
            "sensor",
            kind="wall-not-seen",
            device=sensor.name,
        )
    distances, errors = (np.array([getattr(each, key) for each in seen]) for key in ("distance_m", "error_m"))
    offset, scale, remaining, deviation = _fit_line(distances, errors)
    error = math.sqrt(float(remaining @ remaining) / len(seen))
    if error > MAX_ERROR_M:
        raise CalibrationError(
            f"the errors of {sensor.name} differ by {error:.3f} m from distance to distance, and the limit is "
            f"{MAX_ERROR_M:g} m. Measure the distances from the sensor to the wall again, and keep other things out of "
            "its cone",
            kind="no-common-offset",
            device=sensor.name,
            error_m=error,
        )
    beyond = [each.distance_m for each in results if not each.is_in_range and each.distance_m > seen[-1].distance_m]
    lost, echoes = sum(each.lost for each in seen), sum(each.echoes for each in seen)
    noise = math.sqrt(sum(each.noise_m**2 * each.echoes for each in seen) / echoes)
    # The share of Agresti and Coull, so that no lost echo of few ones leaves an uncertainty.
    share = (lost + 1) / (lost + echoes + 2)
    return RangeFit(
        offset,
        deviation,
        scale,
        noise,
        noise / math.sqrt(2 * (echoes - len(seen))),
        lost / (lost + echoes),
        math.sqrt(share * (1 - share) / (lost + echoes + 2)),
        error,
        seen[-1].distance_m if beyond else None,
        tuple(results),
    )


def _fit_line(distances: Array, errors: Array) -> tuple[float, float, Array, float]:
    """Return the offset, the scale, the errors that remain, and the standard deviation of the offset."""
    count, offset = len(errors), float(errors.mean())
    remaining = errors - offset
    spread = max(math.sqrt(float(remaining @ remaining) / max(count - 1, 1)), TAPE_M)
    if count > MIN_DISTANCES and float(np.ptp(distances)) >= MIN_SPAN_M:
        away = distances - distances.mean()
        scale = float(away @ errors) / float(away @ away)
        rest = errors - offset - scale * away
        noise = max(math.sqrt(float(rest @ rest) / (count - 2)), TAPE_M)
        if abs(scale) > SCALE_DEVIATIONS * noise / math.sqrt(float(away @ away)):
            middle = float(distances.mean())
            deviation = noise * math.sqrt(1 / count + middle**2 / float(away @ away))
            return offset - scale * middle, scale, rest, deviation
    return offset, 0.0, remaining, spread / math.sqrt(count)


def _find_period(walls: Sequence[WallSamples]) -> float:
    """Return the time between two measurements, in seconds; infinite if it is unknown.

    Sensors differ in what a lost echo is: no sample, so that the next one is late, or a sample with the distance inf.
    """
    gaps = [
        (second.time - first.time) / (second.sequence - first.sequence)
        for samples in walls
        for first, second in pairwise(samples.readings)
    ]
    if not gaps:
        return math.inf
    shortest = float(np.percentile(gaps, 10))
    return float(np.median([gap for gap in gaps if gap < 1.5 * shortest]))


def _evaluate(samples: WallSamples, period: float) -> WallResult:
    distances = np.array([each.distance for each in samples.readings], float)
    echoes = distances[np.isfinite(distances)]
    missing = 0
    for first, second in pairwise(samples.readings):
        cycles = round((second.time - first.time) / period) if period else 0
        missing += max(cycles - (1 if samples.is_held else second.sequence - first.sequence), 0)
    lost = missing + len(distances) - len(echoes)
    if len(echoes) < MIN_ECHOES:
        return WallResult(samples.distance_m, math.nan, math.nan, len(echoes), lost)
    middle = float(np.median(echoes))
    spread = 1.4826 * float(np.median(np.abs(echoes - middle)))
    wall = echoes[np.abs(echoes - middle) <= max(OUTLIER_FACTOR * spread, TAPE_M)]
    return WallResult(samples.distance_m, float(wall.mean()), float(wall.std(ddof=1)), len(echoes), lost)


def measure_true_distance(state: SimulationState, sensor: str) -> float:
    """Return the true distance from a simulated range sensor to the nearest body in its cone, in metres."""
    truth = next(each for each in state.robot.all_of(RangeSensorDescription) if each.name == sensor)
    fan = Fan(truth.cone_rad, MIN_TRUE_M, MAX_TRUE_M)
    start, directions = fan.rays(state.joints.locate(truth.mount))
    return fan.reading(state.cast(start, directions, MAX_TRUE_M + 2 * FAN_SETBACK_M))


def collect_samples(robot: Robot, sensor: RangeSensor, distance_m: float, seconds: float) -> Routine[WallSamples]:
    """Collect the samples of a sensor for a time, while the robot stands.

    distance_m: the true distance to the wall, in metres.
    """
    samples, end = WallSamples(distance_m, is_held=sensor.echo_free_samples > 1), robot.clock.now() + seconds
    while robot.clock.now() < end:
        samples.add(sensor.read())
        yield
    return samples


def approach(robot: Robot, step_m: float) -> Routine[bool]:
    """Drive straight forward. Return False if the range guard stops the robot before the wall.

    step_m: the distance in metres.
    """
    try:
        yield from straight(robot, step_m, speed=APPROACH_M_S)
    except BlockedError:
        return False
    yield from wait(robot, SETTLE_S)
    return True


def build_description_values(fit: RangeFit) -> dict[str, float]:
    """Return the keys of the sensor's table for the errors that no setting of a driver corrects."""
    return {"noise_m": round(fit.noise_m, 4), "loss": round(fit.loss, 3)}


def build_error_chart(fit: RangeFit, sensor: str) -> Chart:
    """Return a chart of the errors at each distance, and of the fit."""
    seen = [each for each in fit.walls if each.is_in_range]
    distances, errors = ([getattr(each, key) for each in seen] for key in ("distance_m", "error_m"))
    series = [
        Series(distances, errors, label="mean of the echoes", has_dots=True),
        Series(distances, [fit.offset_m + fit.scale * each for each in distances], SERIES[1], label="fit"),
    ]
    return Chart(f"Errors of {sensor}", series, "distance in m", "error in m")
