"""The parts of ``robotcore calibrate camera``: each measures a property of a camera, and reports it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from math import degrees
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

from robotcore.cli.output import write_failure, write_line
from robotcore.errors import CalibrationError

if TYPE_CHECKING:
    from robotcore.calibration.camera.board import Board, ViewSelection
    from robotcore.calibration.camera.delay import DelayFit
    from robotcore.calibration.camera.object_colour import HueFit
    from robotcore.cli.robot_session import RobotSession
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.kinds.camera import Camera, CameraDescription
    from robotcore.optics import Image

NOISE, COLOUR, INTRINSICS, DELAY = PARTS = ("noise", "colour", "intrinsics", "delay")
"""The parts of a calibration in their order. The robot stands in all of them but the last."""

PICTURES = 20
"""The number of pictures for the noise and for the colour."""

APPS_WITHOUT_TOLERANCE = "mark-green and pan-search"

VIEWS = 30
"""The number of rendered pictures of a board in a simulator."""

MAX_WATCH_S = 300.0
"""The longest time for which a person moves the board, in seconds."""

WATCH_STEP_S = 0.1
"""The time between two pictures in which the board is searched, in seconds."""


class CameraParts:
    """Measures the parts of a camera, and collects their results.

    session: gets the changes of the robot's file, and the charts.
    camera: the description of the camera.
    """

    def __init__(self, session: RobotSession, camera: CameraDescription) -> None:
        self._session, self.camera = session, camera
        self.values: dict[str, dict[str, Any]] = {}
        """The measured values by part, for JSON."""
        self.skipped: dict[str, str] = {}
        """The reason why a part did not run, by part."""
        self.failures: dict[str, CalibrationError] = {}
        """The errors of parts that had no result, by part."""
        self._lines: list[str] = []

    def run(self, part: str, measure: Callable[[], None]) -> None:
        """Run a part. If it has no result, the other parts still run."""
        write_line(f"measuring: {part}", is_error=True)
        try:
            measure()
        except CalibrationError as error:
            self.failures[part] = error

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON.

        The JSON keys:

        camera: text; the name of the camera.
        parts: object; the results of the parts that have one.
        parts.noise: object; the noise of the pixels. Only with a result.
        parts.noise.noise_levels: number, grey levels; the standard deviation of a pixel.
        parts.colour: object; the colour of an object. Only with a result.
        parts.colour.*: robotcore.calibration.camera.object_colour.HueFit
        parts.colour.warnings: list of text; the problems of the object and the light.
        parts.intrinsics: object; the lens. Only with a result.
        parts.intrinsics.horizontal_fov_rad: number, rad; the horizontal field of view.
        parts.intrinsics.centre_px: list of two numbers, pixels; the column and the row of the optical axis.
        parts.intrinsics.distortion: list of numbers; the coefficients of the distortion.
        parts.intrinsics.fov_deviation_rad: number, rad; the standard deviation of ``horizontal_fov_rad``.
        parts.intrinsics.focal_length_px: number, pixels; the focal length.
        parts.intrinsics.error_px: number, pixels; the error of a corner of the board.
        parts.intrinsics.views: whole number; the number of views in the fit.
        parts.intrinsics.left_out: whole number; the number of bad views that were left out.
        parts.intrinsics.uncovered: list of text; the parts of the picture that the views do not cover.
        parts.delay: object; the delay of the pictures. Only with a result.
        parts.delay.*: robotcore.cli.calibrate.camera_parts._build_delay_values
        skipped: object of text; why a part did not run, by part.
        failures: object; the errors of parts without a result, by part.
        failures.PART.error: text; the message. Only after a failure.
        failures.PART.kind: text; a stable identifier of the error. Only after a failure.
        """
        failures = {part: {"error": str(error), "kind": error.kind} for part, error in self.failures.items()}
        return {"camera": self.camera.name, "parts": self.values, "skipped": self.skipped, "failures": failures}

    def write(self) -> None:
        """Write the results on stdout, and the failures on stderr."""
        for line in self._lines:
            write_line(line)
        for part, reason in self.skipped.items():
            write_line(f"{part}: not measured: {reason}")
        for part, error in self.failures.items():
            write_failure(f"{part}: {error}")

    def _add(self, part: str, values: Mapping[str, Any], *lines: str) -> None:
        self.values[part] = dict(values)
        self._lines += [f"{part}: {lines[0]}", *(f"  {line}" for line in lines[1:])]

    def measure_noise(self, live: LiveRobot, device: Camera) -> None:
        """Measure the noise of the pixels, while the robot stands."""
        from robotcore.calibration.camera.measuring import take_pictures
        from robotcore.calibration.camera.pixel_noise import measure_noise

        noise = round(measure_noise(live.run(take_pictures(device, PICTURES))), 2)
        self._session.change_device(self.camera, noise_levels=noise)
        self._add(NOISE, {"noise_levels": noise}, f"{noise:g} grey levels (standard deviation of a pixel)")

    def measure_colour(self, colour: str, live: LiveRobot, device: Camera) -> None:
        """Measure the hue of an object before the camera.

        colour: about which colour it has, by name or in degrees.
        """
        from robotcore.calibration.camera.measuring import take_pictures
        from robotcore.calibration.camera.object_colour import measure_hue

        fit = measure_hue(live.run(take_pictures(device, PICTURES)), colour, device.intrinsics)
        values = {**asdict(fit), "hues": fit.hues, "saturations": fit.saturations, "values": fit.values}
        self._add(
            COLOUR,
            {**values, "warnings": fit.warnings},
            f"hue {fit.hue:g}°, tolerance {fit.tolerance:g}°",
            f"measured: hue {fit.hues.low:.0f}° to {fit.hues.high:.0f}°, saturation {fit.saturations.low:.2f} to "
            f"{fit.saturations.high:.2f}, value {fit.values.low:.2f} to {fit.values.high:.2f}",
            *(f"warning: {warning}" for warning in fit.warnings),
            *self._list_uses(fit),
        )

    def _list_uses(self, fit: HueFit) -> list[str]:
        """Return the commands and the lines of files by which apps get the colour."""
        session = self._session
        name, settings = "mark-green", {"hue": f"{fit.hue:g}"}
        if session.description.drive:
            name, settings = "green-search", {**settings, "tolerance": f"{fit.tolerance:g}"}
        words = ["robotcore", "run", name, "--robot", session.robot, "--backend", session.backend.name]
        for key, value in session.options.items():
            words += ["--option", f"{key}={value}"]
        for key, value in settings.items():
            words += ["--set", f"{key}={value}"]
        inline = ", ".join(f"{key} = {value}" for key, value in settings.items())
        return [
            "The colour is a setting of an app. The robot's file does not have it. Try it now:",
            f"  {shlex.join(words)}",
            f"{APPS_WITHOUT_TOLERANCE} have the setting hue, and not tolerance.",
            "To deploy it, set it in the project's pyproject.toml, below [tool.robotcore.deploy]:",
            f"  settings = {{ {inline} }}",
            f"In an app of your own: ColourDetector({fit.hue:g}, tolerance={fit.tolerance:g})",
        ]

    def measure_files(self, board: Board, folder: Path | None, recording: Path | None) -> None:
        """Fit the lens to the pictures of a folder, or else of a recording."""
        from robotcore.calibration.camera.intrinsics import collect_views
        from robotcore.calibration.camera.measuring import read_folder, read_recording

        pictures = read_folder(folder) if folder else read_recording(recording or Path(), self.camera.name)
        selection, without = collect_views(pictures, board)
        self._add_intrinsics(board, selection, without)

    def measure_board(self, board: Board, live: LiveRobot, device: Camera) -> None:
        """Fit the lens to pictures of a board that the person moves."""
        from robotcore.calibration.camera.measuring import BoardViewCollector

        write_line(
            "Move the board slowly: to each corner of the picture, near and far, and tilted by 30° to each side. Hold "
            "it still for a moment in each place. Ctrl-C ends the command.",
            is_error=True,
        )
        watch = BoardViewCollector(device, board)
        begin = live.clock.now()
        while not watch.is_complete and live.clock.now() - begin < MAX_WATCH_S:
            live.wait(WATCH_STEP_S)
            if watch.look():
                write_line(watch.describe(), is_error=True)
        self._add_intrinsics(board, watch.selection, watch.without)

    def render_board(self, board: Board, _live: LiveRobot, device: Camera) -> None:
        """Fit the lens of a simulated camera to rendered pictures of a board, which no world of a simulator has."""
        from robotcore.calibration.camera.board_renderer import BoardRenderer
        from robotcore.calibration.camera.intrinsics import collect_views

        robot = self._session.load_true_robot()
        cameras: dict[str, CameraDescription] = {each.name: each for each in robot.all_of("camera")}
        true = cameras[self.camera.name]  # the simulator has opened it
        write_line(
            f"The simulated world has no board, so the board is rendered in {VIEWS} places, as the camera of the "
            "simulated robot sees it",
            is_error=True,
        )
        renderer = BoardRenderer(true.intrinsics, true.noise_levels)
        selection, without = collect_views(renderer.render_views(board, VIEWS, Random(self._session.seed or 0)), board)
        self._add_intrinsics(board, selection, without)

    def _add_intrinsics(self, board: Board, selection: ViewSelection, without: Sequence[Image]) -> None:
        from robotcore.calibration.camera.intrinsics import (
            build_description_values,
            build_views_chart,
            fit_intrinsics,
            require_board,
        )
        from robotcore.calibration.least_squares import format_digits

        require_board(selection, board, without)
        self._session.charts.append(build_views_chart(selection, self.camera.name))
        fit = fit_intrinsics(selection, board)
        values = build_description_values(fit, self.camera)
        self._session.change_device(self.camera, **values)
        self._add(
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
            f"{', '.join(format_digits(value, 4) for value in values['distortion'])}",
            f"{fit.views} views, error of a corner {fit.error_px:.2f} px"
            + (f", {fit.left_out} bad views left out" if fit.left_out else ""),
            *([f"warning: not covered: {', '.join(fit.uncovered)}"] if fit.uncovered else []),
        )

    def measure_delay(self, rate_hz: float, live: LiveRobot, device: Camera) -> None:
        """Turn the robot to and fro, and compare the rotation of the pictures with that of other sensors.

        rate_hz: the number of ticks in a second.
        """
        from robotcore.calibration.camera.delay import build_delay_chart, fit_delay
        from robotcore.calibration.camera.measuring import find_heading_source, record_turn

        record = live.run(record_turn(live, device, rate_hz))
        fit = fit_delay(record, device.intrinsics.horizontal_fov, 1 / rate_hz)
        latency = max(0.0, round(fit.latency_s, 3))
        self._session.charts.append(build_delay_chart(fit, self.camera.name))
        self._session.change_device(self.camera, latency_s=latency)
        self._add(
            DELAY,
            _build_delay_values(fit, latency, find_heading_source(live)),
            f"{latency:.3f} s ± {fit.deviation_s:.3f} s from the capture until the app gets the picture",
            f"the time stamps are {abs(fit.stamp_error_s):.3f} s {'late' if fit.stamp_error_s >= 0 else 'early'}; "
            f"compared with {find_heading_source(live)}; the fit explains {fit.share:.1%} of the rotation",
        )


def _build_delay_values(fit: DelayFit, latency_s: float, sensor: str) -> dict[str, Any]:
    """Return the data about the delay for JSON.

    The JSON keys:

    latency_s: number, s; the time from the capture of a picture until the app gets it.
    deviation_s: number, s; the standard deviation of ``latency_s``.
    stamp_error_s: number, s; the time from the capture of a picture to its time stamp.
    scale: number; the rotation in the pictures, divided by that of the sensor.
    share: number; the share of the pictures' rotation that the sensor's rotation explains, from 0 to 1.
    pictures: whole number; the number of pictures in the fit.
    sensor: text; the sensor of the rotation.
    """
    names = ("deviation_s", "stamp_error_s", "scale", "share", "pictures")
    return {"latency_s": latency_s, **{name: getattr(fit, name) for name in names}, "sensor": sensor}
