"""Draw a recorded run and its simulations: the paths from above, and wheel speeds and ranges over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robotcore.canvas import FADED, INK, SERIES, Canvas, Colour, shorten_text
from robotcore.description import RobotDescription
from robotcore.fidelity.fidelity import Fidelity
from robotcore.fidelity.measures import find_window, measure_speed
from robotcore.fidelity.run_data import SIDES, RangeSeries, RunData
from robotcore.geometry import Pose
from robotcore.optics import Image
from robotcore.view.chart import Box, Chart, Series
from robotcore.view.fidelity_table import build_heading, list_titles
from robotcore.view.overhead import MapPath, Track, TrackPoint, draw_map
from robotcore.view.page import EDGE, HEIGHT, MAP, SIDE, SIDE_WIDTH, TOP, begin_page, finish_page
from robotcore.view.picture import build_empty_world

RECORDED: Colour = (85, 88, 100)
SIMULATED: tuple[Colour, ...] = (SERIES[1], SERIES[0])
"""The colours of the simulation with the recorded description, and of the one with a file."""

MAX_CHARTS = 4
_LEGEND_ROW, _GAP = 26, 14
_WIDE, _NARROW = 4.0, 1.5
"""The widths of the recorded curve and of the simulated curves, in pixels."""


def draw_fidelity(fidelity: Fidelity) -> Image:
    """Return the picture of a comparison: BGR, 1600 pixels wide and 1000 high.

    It shows the paths in the simulated world, the speed of the wheel on each side, and the ranges of the first sensors.
    """
    canvas = begin_page(build_heading(fidelity), "fidelity", INK, fidelity.notes[0])
    top = _draw_legend(canvas, fidelity)
    charts = list(_list_charts(fidelity))[:MAX_CHARTS]
    height = (HEIGHT - EDGE - top) / max(len(charts), 2) - _GAP
    for index, chart in enumerate(charts):
        chart.draw(canvas, Box(SIDE, top + index * (height + _GAP), SIDE_WIDTH, height))
    return finish_page(canvas, _draw_paths(fidelity))


def _draw_legend(canvas: Canvas, fidelity: Fidelity) -> float:
    """Draw a line for each run, and return the top of the charts in pixels."""
    y, rows = TOP + 10.0, [("recorded", "")]
    for title, simulation in zip(list_titles(fidelity), fidelity.simulations, strict=True):
        path = simulation.differences.path
        rows.append((f"simulated, {title}", f"{path.end_m:.3f} m away at the end" if path else ""))
    for (title, words), colour in zip(rows, (RECORDED, *SIMULATED), strict=False):
        canvas.draw_line([(SIDE, y - 5), (SIDE + 40, y - 5)], colour, _WIDE)
        canvas.write_text((SIDE + 52, y), shorten_text(title, SIDE_WIDTH - 290, 14), INK, 14)
        canvas.write_text((SIDE + SIDE_WIDTH - 220, y), words, FADED, 13)
        y += _LEGEND_ROW
    return y


def _draw_paths(fidelity: Fidelity) -> Image:
    recorded = fidelity.recording.metadata.description
    drawn: list[tuple[RobotDescription, RunData, Colour]] = [(recorded, fidelity.recorded.run, RECORDED)]
    for simulation, colour in zip(fidelity.simulations, SIMULATED, strict=False):
        drawn.append((simulation.robot, simulation.run, colour))
    paths = [MapPath(robot, _build_track(run), {}, {"": colour}) for robot, run, colour in drawn]
    world = fidelity.world or build_empty_world([step.pose for path in paths for step in path.track.points])
    return draw_map(world, paths, MAP)


def _build_track(run: RunData) -> Track:
    track = Track()
    for time, pose in zip(run.times.tolist(), run.poses.tolist(), strict=True):
        if np.isfinite(pose).all():
            track.points.append(TrackPoint(time, "", Pose(*pose)))
    return track


def _list_charts(fidelity: Fidelity) -> Iterator[Chart]:
    """Yield the charts over the time of the run."""
    axis: dict[str, Any] = {"x_unit": "s", "x_range": (0.0, fidelity.duration_s)}
    runs = [fidelity.recorded.run, *(simulation.run for simulation in fidelity.simulations)]
    styles = list(zip((RECORDED, *SIMULATED), (_WIDE, _NARROW, _NARROW), strict=True))
    times = fidelity.recorded.run.times
    window = find_window(fidelity.commands, times, fidelity.encoder_step_rad)
    for side in SIDES:
        measured = [(run.angles[side], style) for run, style in zip(runs, styles, strict=False) if side in run.angles]
        if len(measured) > 1:
            curves = [Series(times, measure_speed(series, times, window), *style) for series, style in measured]
            yield Chart(f"{side} wheel, rad/s", curves, **axis)
    for name in runs[0].ranges:
        found = [(run.ranges[name], style) for run, style in zip(runs, styles, strict=False) if name in run.ranges]
        if len(found) > 1:
            curves = [Series(*_find_nearest(series, times), *style) for series, style in found]
            yield Chart(f"{name}, m", curves, **axis)


def _find_nearest(series: RangeSeries, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the times of the samples, and the nearest distance in each."""
    ticks: Sequence[int] = sorted(series.distances)
    return times[ticks], np.array([float(series.distances[tick].min()) for tick in ticks])
