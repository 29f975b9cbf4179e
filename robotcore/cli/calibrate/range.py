"""``robotcore calibrate range`` measures the errors of a range sensor before a wall."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.calibrate.distances import DistancesType, DistanceType, find_distance_problem
from robotcore.cli.output import write_line, write_table
from robotcore.cli.person import has_terminal
from robotcore.cli.robot_session import BENCH, MeasuringCommand, RobotSession, robot_session_options
from robotcore.errors import CalibrationError, UsageError

if TYPE_CHECKING:
    from robotcore.calibration.range_sensor import RangeFit, WallSamples
    from robotcore.cli.person import TerminalPerson
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.kinds.range_sensor import RangeSensorDescription

RATE_HZ = 50.0
"""The number of ticks in a second, so that no sample is missed."""

DISTANCES = 6
"""The number of distances at which a robot stops that drives towards the wall."""

NEAR_M = 0.25
"""The distance to the wall at which a driving robot turns back at the latest, in metres. The range guard is nearer."""

MIN_M, MAX_M = 0.01, 19.9
"""The limits of a distance from the wall, in metres."""

OFFSET_DEVIATIONS = 2.0
"""A change of the offset is written if it is this many times its standard deviation."""


@click.command("range", cls=MeasuringCommand, short_help="Measure the errors of a range sensor.")
@robot_session_options(BENCH)
@click.option("--sensor", "name", metavar="NAME", help="The name of the range sensor. Default: the first one.")
@click.option(
    "--distances",
    metavar="METRES,…",
    type=DistancesType(MIN_M, MAX_M),
    help="The distances from the sensor to the wall by a tape measure. Default: the command asks for them.",
)
@click.option(
    "--drive",
    "start",
    metavar="METRES",
    type=DistanceType(0.3, 20.0),
    help="Drive towards the wall from this distance, and measure the way by the encoders.",
)
@click.option(
    "--seconds", type=click.FloatRange(0.5, 60.0), default=3.0, show_default=True, help="The time at each distance."
)
def command(
    name: str | None, distances: tuple[float, ...] | None, start: float | None, seconds: float, **values: Any
) -> int:
    """Measure the offset, the noise and the lost echoes of a range sensor before a flat wall.

    Put the robot square before the wall, measure the distance from the sensor to the wall with a tape, and type it.
    Repeat it at four or more distances between the shortest and the longest range. With --drive, the robot drives
    towards the wall itself. In a simulator it does so too, and the true distance takes the place of the tape.

    The results are written to the sensor's description. A run subtracts the offset, and simulators simulate all three.
    After an e-stop, Ctrl-C or an error, the results of the measured distances are shown, but not written.
    """
    from robotcore.calibration.range_sensor import build_error_chart, fit_range

    session, distances = RobotSession(**values), distances or ()
    sensor: RangeSensorDescription = session.find_device("range_sensor", name)
    is_driving = _decide_driving(session, distances, start)
    walls: list[WallSamples] = []
    session.measure(partial(_measure, session, sensor, walls, distances, start, seconds, is_driving=is_driving))
    try:
        fit = fit_range(walls, sensor)
    except CalibrationError as error:
        raise (session.error or error) from None
    if session.error:
        session.changes.refuse("the measurement did not reach its end")
    notes = _apply(session, sensor, fit)
    session.charts.append(build_error_chart(fit, sensor.name))
    answer = _build_answer(sensor.name, fit)
    return session.finish("The range sensor", answer, partial(_write_fit, fit, sensor, notes))


def _build_answer(sensor: str, fit: RangeFit) -> dict[str, Any]:
    """Return the data about the sensor for JSON.

    The JSON keys:

    sensor: text; the name of the range sensor.
    *: robotcore.calibration.range_sensor.RangeFit
    walls[].loss: number; the share of measurements without an echo at this distance, from 0 to 1.
    """
    walls = [{**_drop_nan(asdict(each)), "loss": each.loss} for each in fit.walls]
    return {"sensor": sensor, **asdict(fit), "walls": walls}


def _decide_driving(session: RobotSession, distances: tuple[float, ...], start: float | None) -> bool:
    """Return whether the robot drives to the wall. Raises UsageError for options that do not fit together."""
    has_drive = session.description.drive is not None
    if distances and start is not None:
        raise UsageError("give --distances or --drive, not both", kind="two-sources")
    if distances and session.is_simulated and has_drive:
        text = "a simulated robot drives to the wall itself, by its true distance. Leave --distances out"
        raise UsageError(text, kind="distances-in-simulator")
    if start is not None and session.is_simulated and has_drive:
        text = "a simulated robot drives to the wall from its place in the world. Leave --drive out, or give a --world"
        raise UsageError(text, kind="drive-in-simulator")
    if start is not None and not has_drive:
        raise UsageError(f"{session.description.source} has no drive. Leave --drive out", kind="no-drive")
    is_driving = start is not None or (session.is_simulated and has_drive)
    if not (is_driving or distances or has_terminal()):
        text = "there is no terminal to ask for the distances. Give them: --distances 0.2,0.5,1.0,1.5"
        raise UsageError(text, kind="no-distances")
    return is_driving


def _measure(
    session: RobotSession,
    sensor: RangeSensorDescription,
    walls: list[WallSamples],
    distances: tuple[float, ...],
    start: float | None,
    seconds: float,
    *,
    is_driving: bool,
) -> None:
    """Open the robot, and add the samples at each distance to ``walls``."""
    from robotcore.calibration.range_sensor import collect_samples
    from robotcore.hal.robot import Role

    wants = frozenset({Role.DRIVE}) if is_driving else frozenset()
    with session.open(rate_hz=RATE_HZ, needs={sensor.name}, wants=wants) as live:
        if is_driving and not session.is_simulated:
            session.prepare(
                f"Put the robot square before a wall, its sensor {start:g} m from it. It drives to the wall"
            )
        places = _drive_to_wall(live, sensor, start) if is_driving else _ask_distances(session.person, distances)
        device: Any = live[sensor.name]
        for distance in places:
            write_line(f"measuring at {distance:.3f} m", is_error=True)
            samples = live.run(collect_samples(live, device, distance, seconds))
            walls.append(samples)
            if not is_driving:
                reading = samples.readings[-1].distance
                write_line(f"  {len(samples.readings)} samples, the last one {reading:.3f} m", is_error=True)


def _drive_to_wall(live: LiveRobot, sensor: RangeSensorDescription, start: float | None) -> Iterator[float]:
    """Yield each distance from the wall in metres, while the robot drives towards the wall.

    start: the distance of the sensor from the wall at first, in metres; None for the true distance of a simulator.
    """
    from robotcore.calibration.range_sensor import approach, measure_true_distance

    state = live.ground_truth.state if live.ground_truth else None
    begin = live.drive.pose

    def measure() -> float:
        if state:
            return measure_true_distance(state, sensor.name)
        assert start is not None
        return start - (live.drive.pose.x - begin.x)

    whole = min(measure(), 1.1 * sensor.max_range_m)
    nearest = max(NEAR_M, sensor.min_range_m + 0.02)
    step = max((whole - nearest) / (DISTANCES - 1), 0.02)
    for number in range(DISTANCES):
        distance = measure()
        yield distance
        if number == DISTANCES - 1 or distance - step < nearest - 0.01 or not live.run(approach(live, step)):
            break


def _ask_distances(person: TerminalPerson, distances: tuple[float, ...]) -> Iterator[float]:
    """Yield each distance from the wall in metres, after the person has put the robot there."""
    for distance in distances:
        person.prepare(f"Put the sensor {distance:g} m before the wall")
        yield distance
    prompt = "Distance from the sensor to the wall in metres (Enter = end):"
    while not distances and (typed := person.read_number(prompt, _find_problem)) is not None:
        yield typed


def _find_problem(distance: float) -> str:
    return find_distance_problem(distance, MIN_M, MAX_M)


def _apply(session: RobotSession, sensor: RangeSensorDescription, fit: RangeFit) -> list[str]:
    """Add the changes of the file, and return sentences about them."""
    from robotcore.calibration.range_sensor import build_description_values

    values, notes = build_description_values(fit), []
    if abs(fit.offset_m) > OFFSET_DEVIATIONS * fit.offset_deviation_m:
        values["offset_m"] = round(sensor.offset_m + fit.offset_m, 4)  # a run subtracts the described offset already
    if fit.max_range_m is not None and fit.max_range_m < sensor.max_range_m:
        notes.append(
            f"The sensor saw the wall at {fit.max_range_m:.2f} m, but not farther away. max_range_m is "
            f"{sensor.max_range_m:g} m: measure between them, and lower it."
        )
    session.change_device(sensor, **values)
    return notes


def _drop_nan(values: dict[str, Any]) -> dict[str, Any]:
    """Return values with None in place of NaN, which JSON does not have."""
    return {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in values.items()}


def _write_fit(fit: RangeFit, sensor: RangeSensorDescription, notes: list[str]) -> None:
    rows = [
        (
            f"{each.distance_m:.3f}",
            f"{each.measured_m:.3f}" if each.is_in_range else "-",
            f"{each.error_m:+.3f}" if each.is_in_range else "out of range",
            f"{each.noise_m:.4f}" if each.is_in_range else "-",
            f"{each.loss:.1%}",
        )
        for each in fit.walls
    ]
    write_table(("distance, m", "measured, m", "error, m", "noise, m", "lost"), rows)
    write_line()
    write_line(
        f"{sensor.name}: offset {fit.offset_m:+.4f} m ± {fit.offset_deviation_m:.4f} m, noise {fit.noise_m:.4f} m ± "
        f"{fit.noise_deviation_m:.4f} m, lost echoes {fit.loss:.1%} ± {fit.loss_deviation:.1%}; the fit leaves "
        f"{fit.error_m:.4f} m"
    )
    if fit.scale:
        write_line(
            f"The error grows by {fit.scale:.1%} of the distance. No setting corrects that, but air_temperature_c of "
            "an ultrasonic module: 10 °C are 1.8 %. Check the tape too."
        )
    for note in notes:
        write_line(note)
