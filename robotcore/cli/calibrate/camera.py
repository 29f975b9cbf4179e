"""``robotcore calibrate camera`` measures a camera's lens, noise and delay, and the colour of an object before it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import degrees
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
from robotcore.cli.options import FolderType
from robotcore.cli.output import as_json, redirect_prints, write_failure, write_json, write_line
from robotcore.cli.person import require_ready
from robotcore.cli.robot_changes import RobotChanges, write_option
from robotcore.errors import CalibrationError, UsageError

if TYPE_CHECKING:
    from robotcore.calibration.camera.board import Board, ViewSelection
    from robotcore.description import RobotDescription
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.kinds.camera import Camera, CameraDescription
    from robotcore.optics import Image
    from robotcore.view.chart import Chart

NOISE, COLOUR, INTRINSICS, DELAY = PARTS = ("noise", "colour", "intrinsics", "delay")
"""The parts of a calibration in their order. The robot stands in all of them but the last."""

PICTURES = 20
"""The number of pictures for the noise and for the colour."""

RATE_HZ = 50.0
"""The number of ticks in a second. No camera of a robot is faster."""

MAX_WATCH_S = 300.0
"""The longest time for which a person moves the board, in seconds."""

WATCH_STEP_S = 0.1
"""The time between two pictures in which the board is searched, in seconds."""


@dataclass
class Results:
    """The results of the parts."""

    changes: RobotChanges
    values: dict[str, dict[str, Any]] = field(default_factory=dict)
    """The measured values by part, for JSON."""
    skipped: dict[str, str] = field(default_factory=dict)
    """The reason why a part did not run, by part."""
    failures: dict[str, CalibrationError] = field(default_factory=dict)
    """The errors of parts that had no result, by part."""
    charts: list[Chart] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    """The text for the user."""

    def add(self, part: str, values: Mapping[str, Any], *lines: str) -> None:
        self.values[part] = dict(values)
        self.lines += [f"{part}: {lines[0]}", *(f"  {line}" for line in lines[1:])]


@click.command("camera", cls=AnsweringCommand)
@calibrated_robot_options
@click.option("--camera", "name", metavar="NAME", help="The name of the camera. Default: the first one.")
@click.option("--only", "parts", type=click.Choice(PARTS), multiple=True, help="Measure only this part. Repeatable.")
@click.option("--board", metavar="COLUMNSxROWS", default="9x6", show_default=True, help="The board's inner corners.")
@click.option("--square", metavar="METRES", type=float, default=0.025, show_default=True, help="The side of a square.")
@click.option("--pictures", metavar="FOLDER", type=FolderType(), help="Take the pictures of the board from a folder.")
@click.option(
    "--recording",
    metavar="FILE.mcap",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="Take the pictures of the board from a recording.",
)
@click.option(
    "--colour", default="green", show_default=True, help="About which colour the object has: name or degrees."
)
@click.option("--plot", metavar="FILE.png", type=click.Path(path_type=Path), help="Draw the measurements and the fits.")
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
    parts: tuple[str, ...],
    board: str,
    square: float,
    pictures: Path | None,
    recording: Path | None,
    colour: str,
    plot: Path | None,
    *,
    is_confirmed: bool,
    is_writing: bool,
    as_json: bool,
) -> int:
    """Measure a camera: its lens, its noise, its delay, and the colour of an object in the present light.

    noise: the noise of the pixels, while the robot stands.

    colour: the hue and the tolerance for apps, of a ball or another object before the camera.

    intrinsics: the field of view, the optical axis and the distortion, by a printed chessboard that you move before the
    camera. It must be flat. Its size is the number of inner corners: 9x6 for a board of 10 by 7 squares.

    delay: the time from the capture of a picture until the app gets it. The robot turns to and fro on the spot.

    Without --only, all parts run that can. Exit status: 0 success, 1 a part had no result that is good enough.
    """
    from robotcore.calibration.camera.board import Board

    chessboard = Board.parse(board, square)
    setup = load_calibrated_robot(robot, backend, world, seed, options, port=port)
    camera: CameraDescription = find_described(setup.description, "camera", name)
    if pictures and recording:
        raise UsageError("give --pictures or --recording, not both", kind="two-sources")
    if plot:
        from robotcore.view.page import require_writable

        require_writable(plot)
    results = Results(RobotChanges(robot, is_writing=is_writing))
    reasons = _find_reasons(setup.description, is_simulated=setup.is_simulated, has_files=bool(pictures or recording))
    for part in parts:
        if reason := reasons.get(part):
            raise UsageError(f"--only {part}: {reason}", kind="part-not-possible", part=part)
    chosen = [part for part in PARTS if part in (parts or PARTS) and part not in reasons]
    results.skipped = {part: reasons[part] for part in PARTS if part in reasons and not parts}
    with redirect_prints(as_json=as_json):
        if pictures or recording:
            _run_part(results, INTRINSICS, lambda: _measure_files(results, camera, chessboard, pictures, recording))
        else:
            _measure_live(results, setup, camera, chessboard, colour, chosen, is_confirmed=is_confirmed)
    results.changes.finish(setup.backend)
    if plot and results.charts:
        from robotcore.view.chart import save_charts

        save_charts(plot, f"The camera {camera.name} of {setup.description.name}", results.charts, "--plot")
    return _write_results(results, setup.description, camera, as_json=as_json)


def _find_reasons(description: RobotDescription, *, is_simulated: bool, has_files: bool) -> dict[str, str]:
    """Return the reason for each part that cannot run."""
    if has_files:
        return {part: "pictures of a board give only the intrinsics" for part in PARTS if part != INTRINSICS}
    reasons = {}
    if is_simulated:
        reasons[INTRINSICS] = "no person moves a board in a simulator. Give pictures with --pictures or --recording"
    drive = description.drive
    if drive is None:
        reasons[DELAY] = "the robot has no drive to turn with"
    elif description.min_turn_radius_m:
        reasons[DELAY] = "the robot steers, so it cannot turn on the spot"
    elif not (drive.encoders or description.all_of("imu")):
        reasons[DELAY] = "the robot has neither encoders nor an IMU to compare with"
    return reasons


def _measure_live(
    results: Results,
    setup: CalibratedSetup,
    camera: CameraDescription,
    board: Board,
    colour: str,
    parts: Sequence[str],
    *,
    is_confirmed: bool,
) -> None:
    """Open the robot, and measure parts one after the other. The person prepares each of them."""
    measures: dict[str, tuple[str, Callable[[LiveRobot, Camera], None]]] = {
        NOISE: ("", partial(_measure_noise, results, camera)),
        COLOUR: (f"Hold the {colour} object before the camera", partial(_measure_colour, results, colour)),
        INTRINSICS: (
            "Take the chessboard, and hold it before the camera",
            partial(_measure_board, results, camera, board),
        ),
        DELAY: (
            "Put the robot on the floor with free space around it: it turns to and fro for 12 s",
            partial(_measure_delay, results, camera),
        ),
    }
    wants = setup.list_drive_needs() if DELAY in parts else frozenset()
    with open_live_robot(**setup.arguments, rate_hz=RATE_HZ, needs={camera.name}, wants=wants) as live:
        device: Any = live[camera.name]
        _require_pictures(live, device)
        for part in parts:
            instruction, measure = measures[part]
            if instruction and not setup.is_simulated:
                require_ready(instruction, live.require_running, is_confirmed=is_confirmed)
            _run_part(results, part, partial(measure, live, device))


def _run_part(results: Results, part: str, measure: Callable[[], None]) -> None:
    """Run a part. If it has no result, the other parts still run."""
    write_line(f"measuring: {part}", is_error=True)
    try:
        measure()
    except CalibrationError as error:
        results.failures[part] = error


def _require_pictures(live: LiveRobot, camera: Camera) -> None:
    from robotcore.calibration.camera.measuring import require_content, take_pictures

    require_content(live.run(take_pictures(camera, 2)))


def _measure_noise(results: Results, camera: CameraDescription, live: LiveRobot, device: Camera) -> None:
    from robotcore.calibration.camera.light import measure_noise
    from robotcore.calibration.camera.measuring import take_pictures

    noise = round(measure_noise(live.run(take_pictures(device, PICTURES))), 2)
    results.changes.set_device(camera.name, {"noise_levels": noise})
    results.add(NOISE, {"noise_levels": noise}, f"{noise:g} grey levels (standard deviation of a pixel)")


def _measure_colour(results: Results, colour: str, live: LiveRobot, device: Camera) -> None:
    from dataclasses import asdict

    from robotcore.calibration.camera.light import measure_hue
    from robotcore.calibration.camera.measuring import take_pictures

    fit = measure_hue(live.run(take_pictures(device, PICTURES)), colour, device.intrinsics)
    values = {**asdict(fit), "hues": fit.hues, "saturations": fit.saturations, "values": fit.values}
    results.add(
        COLOUR,
        {**values, "warnings": fit.warnings},
        f"hue {fit.hue:g}°, tolerance {fit.tolerance:g}°",
        f"measured: hue {fit.hues.low:.0f}° to {fit.hues.high:.0f}°, saturation {fit.saturations.low:.2f} to "
        f"{fit.saturations.high:.2f}, value {fit.values.low:.2f} to {fit.values.high:.2f}",
        *(f"warning: {warning}" for warning in fit.warnings),
        f"for an app: robotcore run APP --set hue={fit.hue:g} --set tolerance={fit.tolerance:g}",
        f'in pyproject.toml: [tool.robotcore.deploy.settings] hue = "{fit.hue:g}", tolerance = "{fit.tolerance:g}"',
    )


def _measure_files(
    results: Results, camera: CameraDescription, board: Board, folder: Path | None, recording: Path | None
) -> None:
    from robotcore.calibration.camera.intrinsics import collect_views
    from robotcore.calibration.camera.measuring import read_folder, read_recording

    pictures = read_folder(folder) if folder else read_recording(recording or Path(), camera.name)
    selection, without = collect_views(pictures, board)
    _add_intrinsics(results, camera, board, selection, without)


def _measure_board(results: Results, camera: CameraDescription, board: Board, live: LiveRobot, device: Camera) -> None:
    from robotcore.calibration.camera.measuring import BoardWatch

    write_line(
        "Move the board slowly: to each corner of the picture, near and far, and tilted by 30° to each side. Hold it "
        "still for a moment in each place. Ctrl-C ends.",
        is_error=True,
    )
    watch = BoardWatch(device, board)
    begin = live.clock.now()
    while not watch.is_complete and live.clock.now() - begin < MAX_WATCH_S:
        live.wait(WATCH_STEP_S)
        if watch.look():
            write_line(watch.describe(), is_error=True)
    _add_intrinsics(results, camera, board, watch.selection, watch.without)


def _add_intrinsics(
    results: Results, camera: CameraDescription, board: Board, selection: ViewSelection, without: Sequence[Image]
) -> None:
    from robotcore.calibration.camera.intrinsics import (
        build_description_values,
        build_views_chart,
        fit_intrinsics,
        require_board,
    )

    require_board(selection, board, without)
    results.charts.append(build_views_chart(selection, camera.name))
    fit = fit_intrinsics(selection, board)
    values = build_description_values(fit, camera)
    results.changes.set_device(camera.name, values)
    results.add(
        INTRINSICS,
        {
            **values,
            "fov_deviation_rad": fit.fov_deviation_rad,
            "focal_length_px": fit.focal_length_px,
            "error_px": fit.error_px,
            "views": fit.views,
            "left_out": fit.left_out,
            "uncovered": fit.uncovered,
        },
        f"horizontal field of view {degrees(fit.horizontal_fov_rad):.2f}° ± {degrees(fit.fov_deviation_rad):.2f}°",
        f"optical axis at column {values['centre_px'][0]:g}, row {values['centre_px'][1]:g}; distortion "
        f"{', '.join(f'{value:g}' for value in values['distortion'])}",
        f"{fit.views} views, error of a corner {fit.error_px:.2f} px"
        + (f", {fit.left_out} bad views left out" if fit.left_out else ""),
        *([f"warning: not covered: {', '.join(fit.uncovered)}"] if fit.uncovered else []),
    )


def _measure_delay(results: Results, camera: CameraDescription, live: LiveRobot, device: Camera) -> None:
    from robotcore.calibration.camera.delay import build_delay_chart, fit_delay
    from robotcore.calibration.camera.measuring import find_heading_source, record_turn

    record = live.run(record_turn(live, device, RATE_HZ))
    fit = fit_delay(record, device.intrinsics.horizontal_fov, 1 / RATE_HZ)
    latency = max(0.0, round(fit.latency_s, 3))
    results.charts.append(build_delay_chart(fit, camera.name))
    results.changes.set_device(camera.name, {"latency_s": latency})
    results.add(
        DELAY,
        {
            "latency_s": latency,
            "deviation_s": fit.deviation_s,
            "stamp_error_s": fit.stamp_error_s,
            "scale": fit.scale,
            "share": fit.share,
            "pictures": fit.pictures,
            "sensor": find_heading_source(live),
        },
        f"{latency:.3f} s ± {fit.deviation_s:.3f} s from the capture until the app gets the picture",
        f"the time stamps are {abs(fit.stamp_error_s):.3f} s {'late' if fit.stamp_error_s >= 0 else 'early'}; compared "
        f"with {find_heading_source(live)}; the fit explains {fit.share:.1%} of the rotation",
    )


def _write_results(results: Results, description: RobotDescription, camera: CameraDescription, *, as_json: bool) -> int:
    status = 1 if results.failures else 0
    if as_json:
        failures = {part: {"error": str(error), "kind": error.kind} for part, error in results.failures.items()}
        write_json(
            {
                "robot": description.name,
                "camera": camera.name,
                "parts": results.values,
                "skipped": results.skipped,
                "failures": failures,
                "diff": results.changes.diff,
                "is_written": results.changes.is_written,
                "exit_status": status,
            }
        )
        return status
    for line in results.lines:
        write_line(line)
    for part, reason in results.skipped.items():
        write_line(f"{part}: not measured: {reason}")
    results.changes.show()
    for part, error in results.failures.items():
        write_failure(f"{part}: {error}")
    return status
