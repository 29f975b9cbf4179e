"""Draws the measured motions of a drive over the angles of its wheels."""

from __future__ import annotations

import math
from collections.abc import Sequence

from robotcore.calibration.chart import Chart, Point
from robotcore.calibration.drive.measurement import DriveResult
from robotcore.canvas import FADED, INK, PAPER, RULE, SERIES, Canvas
from robotcore.description import Drive
from robotcore.optics import Image

WIDTH, HEIGHT = 560, 420
"""The size of a chart, in pixels."""

TOP, EDGE = 70, 20
HEADROOM = 1.15


def draw_drive(result: DriveResult, drive: Drive, heading: str) -> Image:
    """Return a picture with a chart of the straight drives, and one of the turns if there are any."""
    columns = 2 if result.track else 1
    canvas = Canvas(2 * EDGE + columns * WIDTH, TOP + HEIGHT + EDGE, PAPER)
    canvas.write_text((EDGE + 20, 34), heading, INK, 18, bold=True)
    canvas.write_text((EDGE + 20, 56), "dots: measured. coloured: fitted. grey: the robot's file", FADED, 11)
    ways = [(each.mean_rad, each.way_m) for each in result.drives]
    labels = ("mean angle of the wheels in rad", f"way in m, by {result.straight_by.value}")
    _draw(canvas, EDGE, ways, result.radius.value, drive.wheel_radius_m, "wheel radius", *labels)
    if result.track:
        turns = [(each.difference_rad, math.degrees(each.turn_rad)) for each in result.spins]
        fitted = math.degrees(result.radius.value / result.track.value)
        present = math.degrees(drive.geometry.wheel_radius / drive.geometry.track)
        labels = ("difference of the wheels' angles in rad", f"turn in degrees, by {result.turns_by.value}")
        _draw(canvas, EDGE + WIDTH, turns, fitted, present, "track", *labels)
    return canvas.render()


def _draw(
    canvas: Canvas,
    left: float,
    points: Sequence[Point],
    fitted: float,
    present: float,
    title: str,
    x_label: str,
    y_label: str,
) -> None:
    reach = HEADROOM * max(abs(x) for x, _ in points)
    height = reach * max(fitted, present)
    chart = Chart(canvas, (left, TOP), (WIDTH, HEIGHT), (-reach, reach), (-height, height))
    chart.draw_axes(title, x_label, y_label)
    for slope, colour, width in ((present, RULE, 4.0), (fitted, SERIES[0], 1.5)):
        chart.draw_curve([(-reach, -reach * slope), (reach, reach * slope)], colour, width)
    chart.draw_points(points, SERIES[0])
