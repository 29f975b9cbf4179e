"""``robotcore calibrate range`` measures the errors of a range sensor before a wall."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.calibrate._options import (
    CalibratedSetup,
    calibrated_robot_options,
    find_described,
    load_calibrated_robot,
)
from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.live_session import open_live_robot
from robotcore.cli.output import as_json, redirect_prints, write_json, write_line, write_table
from robotcore.cli.person import has_terminal, read_number, require_ready
from robotcore.cli.robot_changes import RobotChanges, write_option
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.calibration.range_sensor import RangeFit, Stop
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.kinds.range_sensor import RangeSensorDescription

RATE_HZ = 50.0
"""The number of ticks in a second, so that no sample is missed."""

STOPS = 6
"""The number of distances at which a robot stops that drives towards the wall."""

NEAR_M = 0.25
"""The distance to the wall at which a driving robot turns back at the latest, in metres. The range guard is nearer."""

SIGNIFICANT = 2.0
"""A change of the offset is written if it is this many times its standard deviation."""


def _parse_distances(_context: click.Context, _parameter: click.Parameter, value: str | None) -> tuple[float, ...]:
    if value is None:
        return ()
    try:
        distances = tuple(float(part) for part in value.split(","))
    except ValueError:
        distances = ()
    if not distances or not all(0 < distance < 20 for distance in distances):
        raise click.BadParameter(f"{value!r} is no list of distances in metres. Give them such as 0.2,0.5,1.0")
    return distances


@click.command("range", cls=AnsweringCommand)
@calibrated_robot_options
@click.option("--sensor", "name", metavar="NAME", help="The name of the range sensor. Default: the first one.")
@click.option(
    "--distances",
    metavar="METRES,…",
    callback=_parse_distances,
    help="The distances from the sensor to the wall by a tape measure. Default: they are asked.",
)
@click.option(
    "--drive",
    "start",
    metavar="METRES",
    type=click.FloatRange(0.3, 20.0),
    help="Drive towards the wall from this distance, and measure the way by the encoders.",
)
@click.option(
    "--seconds", type=click.FloatRange(0.5, 60.0), default=3.0, show_default=True, help="The time at each distance."
)
@click.option("--plot", metavar="FILE.png", type=click.Path(path_type=Path), help="Draw the errors and the fit.")
@write_option
@as_json
def command(
    robot: str,
    backend: str,
    world: str | None,
    seed: int | None,
    port: str | None,
    options: tuple[tuple[str, str], ...],
    name: str | None,
    distances: tuple[float, ...],
    start: float | None,
    seconds: float,
    plot: Path | None,
    *,
    is_confirmed: bool,
    is_writing: bool,
    as_json: bool,
) -> int:
    """Measure the offset, the noise and the lost echoes of a range sensor before a flat wall.

    Put the robot square before the wall, measure the distance from the sensor to the wall with a tape, and type it.
    Repeat it at four or more distances between the shortest and the longest range. With --drive, the robot drives
    towards the wall itself. In a simulator it does so too, and the true distance takes the place of the tape.

    The results are written to the sensor's description. A run subtracts the offset, and simulators simulate all three.
    """
    from robotcore.calibration.range_sensor import build_error_chart, fit_range

    setup = load_calibrated_robot(robot, backend, world, seed, options, port=port)
    sensor: RangeSensorDescription = find_described(setup.description, "range_sensor", name)
    if distances and start is not None:
        raise UsageError("give --distances or --drive, not both", kind="two-sources")
    if plot:
        from robotcore.view.page import require_writable

        require_writable(plot)
    changes = RobotChanges(robot, is_writing=is_writing)
    if distances and setup.is_simulated and setup.description.drive:
        text = "a simulated robot drives to the wall itself, by its true distance. Leave --distances out"
        raise UsageError(text, kind="distances-in-simulator")
    is_driving = start is not None or (setup.is_simulated and setup.description.drive is not None)
    if is_driving and setup.description.drive is None:
        raise UsageError(f"{setup.description.source} has no drive. Leave --drive out", kind="no-drive")
    if not (is_driving or distances or has_terminal()):
        text = "there is no terminal to ask for the distances. Give them: --distances 0.2,0.5,1.0,1.5"
        raise UsageError(text, kind="no-distances")
    with redirect_prints(as_json=as_json):
        stops = _measure(setup, sensor, distances, start, seconds, is_driving=is_driving, is_confirmed=is_confirmed)
    fit = fit_range(stops, sensor)
    notes = _apply(changes, sensor, fit)
    changes.finish(setup.backend)
    if plot:
        from robotcore.view.chart import save_charts

        heading = f"The range sensor {sensor.name} of {setup.description.name}"
        save_charts(plot, heading, [build_error_chart(fit, sensor.name)], "--plot")
    if as_json:
        results = [{**_drop_nan(asdict(each)), "loss": each.loss} for each in fit.stops]
        measured = {**asdict(fit), "stops": results}
        answer = {"robot": setup.description.name, "sensor": sensor.name, **measured, "values": changes.values}
        write_json({**answer, "diff": changes.diff, "is_written": changes.is_written, "exit_status": 0})
    else:
        _write_fit(fit, sensor, notes)
        changes.show()
    return 0


def _measure(
    setup: CalibratedSetup,
    sensor: RangeSensorDescription,
    distances: tuple[float, ...],
    start: float | None,
    seconds: float,
    *,
    is_driving: bool,
    is_confirmed: bool,
) -> list[Stop]:
    from robotcore.hal.robot import Role

    wants = frozenset({Role.DRIVE}) if is_driving else frozenset()
    with open_live_robot(**setup.arguments, rate_hz=RATE_HZ, needs={sensor.name}, wants=wants) as live:
        if is_driving:
            if not setup.is_simulated:
                instruction = (
                    f"Put the robot square before a wall, its sensor {start:g} m from it: it drives to the wall"
                )
                require_ready(instruction, live.require_running, is_confirmed=is_confirmed)
            return [*_drive_to_wall(live, sensor, start, seconds)]
        return [*_ask_distances(live, sensor, distances, seconds, is_confirmed=is_confirmed)]


def _drive_to_wall(
    live: LiveRobot, sensor: RangeSensorDescription, start: float | None, seconds: float
) -> Iterator[Stop]:
    """Yield the samples at each distance while the robot drives towards the wall.

    start: the distance of the sensor from the wall at first, in metres; None for the true distance of a simulator.
    """
    from robotcore.calibration.range_sensor import approach, listen, measure_true_distance

    state = live.ground_truth.state if live.ground_truth else None
    device: Any = live[sensor.name]
    begin = live.drive.pose

    def measure() -> float:
        if state:
            return measure_true_distance(state, sensor.name)
        assert start is not None
        return start - (live.drive.pose.x - begin.x)

    whole = min(measure(), 1.1 * sensor.max_range_m)
    nearest = max(NEAR_M, sensor.min_range_m + 0.02)
    step = max((whole - nearest) / (STOPS - 1), 0.02)
    for number in range(STOPS):
        distance = measure()
        write_line(f"measuring at {distance:.3f} m", is_error=True)
        yield live.run(listen(live, device, distance, seconds))
        if number == STOPS - 1 or distance - step < nearest - 0.01 or not live.run(approach(live, step)):
            break


def _ask_distances(
    live: LiveRobot, sensor: RangeSensorDescription, distances: tuple[float, ...], seconds: float, *, is_confirmed: bool
) -> Iterator[Stop]:
    from robotcore.calibration.range_sensor import listen

    device: Any = live[sensor.name]
    listen_at = partial(listen, live, device, seconds=seconds)
    for distance in distances:
        require_ready(f"Put the sensor {distance:g} m before the wall", live.require_running, is_confirmed=is_confirmed)
        yield live.run(listen_at(distance))
    while not distances:
        prompt = "Distance from the sensor to the wall in metres (Enter = end):"
        typed = read_number(prompt, _find_problem, live.require_running)
        if typed is None:
            return
        stop = live.run(listen_at(typed))
        yield stop
        reading = stop.readings[-1].distance
        write_line(f"  {len(stop.readings)} samples, the last one {reading:.3f} m", is_error=True)


def _find_problem(distance: float) -> str:
    return "" if 0 < distance < 20 else f"{distance:g} m is no distance"


def _apply(changes: RobotChanges, sensor: RangeSensorDescription, fit: RangeFit) -> list[str]:
    """Add the changes of the file, and return sentences about them."""
    from robotcore.calibration.range_sensor import build_description_values

    values, notes = build_description_values(fit), []
    if abs(fit.offset_m) > SIGNIFICANT * fit.offset_deviation_m:
        values["offset_m"] = round(sensor.offset_m + fit.offset_m, 4)  # a run subtracts the described offset already
    if fit.max_range_m is not None and fit.max_range_m < sensor.max_range_m:
        notes.append(
            f"The sensor saw the wall at {fit.max_range_m:.2f} m, but not farther away. max_range_m is "
            f"{sensor.max_range_m:g} m: measure between them, and lower it."
        )
    changes.set_device(sensor.name, values)
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
        for each in fit.stops
    ]
    write_table(("distance, m", "measured, m", "error, m", "noise, m", "lost"), rows)
    write_line()
    write_line(
        f"{sensor.name}: offset {fit.offset_m:+.4f} m ± {fit.offset_deviation_m:.4f} m, noise {fit.noise_m:.4f} m, "
        f"lost echoes {fit.loss:.1%}; the fit leaves {fit.error_m:.4f} m"
    )
    if fit.scale:
        write_line(
            f"The error grows by {fit.scale:.1%} of the distance. No setting corrects that, but air_temperature_c of "
            "an ultrasonic module: 10 °C are 1.8 %. Check the tape too."
        )
    for note in notes:
        write_line(note)
