"""Builds charts of the measured motions of a drive over the angles of its wheels."""

from __future__ import annotations

import math

from robotcore.calibration.drive.measurement import DriveResult
from robotcore.canvas import RULE, SERIES
from robotcore.description import Drive
from robotcore.view.chart import Chart, Series

HEADROOM = 1.15
"""The ends of the axes, as a share of the greatest measured values."""


def build_drive_charts(result: DriveResult, drive: Drive) -> list[Chart]:
    """Return a chart of the straight drives, and one of the turns if there are any."""
    ways = [(each.mean_rad, each.way_m) for each in result.drives]
    labels = ("mean angle of the wheels in rad", f"way in m, by {result.straight_by.value}")
    charts = [_build_chart("wheel radius", ways, result.radius.value, drive.wheel_radius_m, *labels)]
    if result.track:
        turns = [(each.difference_rad, math.degrees(each.turn_rad)) for each in result.spins]
        fitted = math.degrees(result.radius.value / result.track.value)
        present = math.degrees(drive.geometry.wheel_radius / drive.geometry.track)
        labels = ("difference of the wheels' angles in rad", f"turn in degrees, by {result.turns_by.value}")
        charts.append(_build_chart("track", turns, fitted, present, *labels))
    return charts


def _build_chart(
    title: str, points: list[tuple[float, float]], fitted: float, present: float, x_label: str, y_label: str
) -> Chart:
    """Return a chart of points, of the fitted line and of the line by the robot's file, both through the origin.

    fitted, present: the slopes of both lines.
    """
    xs, ys = ([point[axis] for point in points] for axis in (0, 1))
    reach = HEADROOM * max(abs(x) for x in xs)
    height = reach * max(fitted, present)
    ends = (-reach, reach)
    series = [
        Series(ends, (-reach * present, reach * present), RULE, 4.0, "the robot's file"),
        Series(ends, (-reach * fitted, reach * fitted), SERIES[0], label="fit"),
        Series(xs, ys, SERIES[0], label="measured", has_dots=True),
    ]
    return Chart(title, series, x_label, y_label, x_range=ends, y_range=(-height, height))
