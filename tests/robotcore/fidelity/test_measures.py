"""The differences of two runs: wheel speeds, paths, ranges and pictures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.fidelity.commands import WheelCommand
from robotcore.fidelity.measures import PictureDifference, RangeDifference, compare, find_window, measure_speed
from robotcore.fidelity.run_data import AngleSeries, Array, PictureSeries, RangeSeries, RunData, shrink, unwrap
from robotcore.geometry import Pose, Wheels

TIMES = np.linspace(0.0, 2.0, 41)
COMMANDS = [WheelCommand(0.0, Wheels(4.0, 4.0))]


def make_run(speed: float = 4.0, ticks: Array = TIMES) -> RunData:
    """Return a run along the x axis with a wheel radius of 0.05 m."""
    ways = 0.05 * speed * ticks
    poses = np.column_stack((ways, np.zeros_like(ways), np.zeros_like(ways)))
    series = AngleSeries(ticks, speed * ticks)
    return RunData(ticks, poses, {"left": series, "right": series})


def test_the_distance_of_two_robots_is_measured_at_the_same_time() -> None:
    path = compare(make_run(4.0), make_run(3.0), COMMANDS).path
    assert path
    assert (path.recorded_m, path.simulated_m, path.end_m) == pytest.approx((0.4, 0.3, 0.1))
    assert (path.largest_m, path.mean_m, path.end_m_per_m) == pytest.approx((0.1, 0.05, 0.25))
    assert path.heading_rad == 0.0


def test_the_difference_of_the_headings_has_whole_turns() -> None:
    recorded, simulated = make_run(), make_run()
    simulated.poses = unwrap(Pose(0.0, 0.0, math.remainder(4 * math.tau * time / 2, math.tau)) for time in TIMES)
    path = compare(recorded, simulated, COMMANDS).path
    assert path
    assert path.heading_rad == pytest.approx(4 * math.tau)
    assert path.heading_rad_per_m == pytest.approx(4 * math.tau / 0.4)


def test_ticks_with_an_unknown_pose_do_not_count() -> None:
    recorded = make_run()
    recorded.poses[5:-1] = np.nan
    path = compare(recorded, make_run(3.0), COMMANDS).path
    assert path
    assert path.end_m == pytest.approx(0.1)
    recorded.poses[:] = np.nan
    assert compare(recorded, make_run(3.0), COMMANDS).path is None


def test_a_robot_that_did_not_drive_has_no_difference_per_metre() -> None:
    path = compare(make_run(0.0), make_run(1.0), COMMANDS).path
    assert path
    assert (path.end_m_per_m, path.heading_rad_per_m) == (None, None)


def test_speeds_are_compared_with_each_other_and_with_the_commands() -> None:
    wheel = compare(make_run(3.0), make_run(3.5), COMMANDS).wheels["left"]
    assert (wheel.rms_rad_s, wheel.largest_rad_s) == pytest.approx((0.5, 0.5))
    assert (wheel.rms_share, wheel.largest_share) == pytest.approx((0.125, 0.125))
    standing = compare(make_run(3.0), make_run(3.5), []).wheels["left"]
    assert (standing.rms_share, standing.largest_share) == (None, None)


def test_samples_at_other_times_than_the_ticks_make_no_difference() -> None:
    late = TIMES[1:] - 0.013
    recorded = make_run()
    recorded.angles["left"] = AngleSeries(late, 4.0 * late)
    assert compare(recorded, make_run(), COMMANDS).wheels["left"].largest_rad_s == pytest.approx(0.0, abs=1e-9)


def test_an_encoder_with_few_counts_has_a_longer_window() -> None:
    windows = [find_window(COMMANDS, TIMES, math.tau / counts) for counts in (4000, 40, 4)]
    assert windows == pytest.approx([0.1, 8 * math.tau / 40 / 4, 0.5])
    assert find_window([], TIMES, 0.1) == 0.5
    speeds = measure_speed(AngleSeries(TIMES, 4 * TIMES), TIMES, 0.5)
    assert np.isnan(speeds[:10]).all()
    assert speeds[10:] == pytest.approx(np.full(31, 4.0))


def make_still_run(ranges: RangeSeries | None = None, pictures: PictureSeries | None = None) -> RunData:
    named = {"nose": ranges} if ranges else {}
    return RunData(TIMES, np.zeros((len(TIMES), 3)), ranges=named, pictures={"eye": pictures} if pictures else {})


def compare_pictures(recorded: PictureSeries, simulated: PictureSeries) -> PictureDifference:
    runs = make_still_run(pictures=recorded), make_still_run(pictures=simulated)
    return compare(runs[0], runs[1], COMMANDS).pictures["eye"]


def make_ranges(distances: list[float], period: float = 0.05) -> RangeSeries:
    series = RangeSeries()
    for tick, distance in enumerate(distances):
        if not math.isnan(distance):  # a sample that is missing
            series.add(tick, np.array([distance]), tick * period)
    return series


def compare_ranges(recorded: RangeSeries, simulated: RangeSeries) -> RangeDifference:
    return compare(make_still_run(recorded), make_still_run(simulated), COMMANDS).ranges["nose"]


def test_ranges_are_compared_where_both_have_an_echo() -> None:
    recorded = make_ranges([1.0, 1.0, math.inf, 1.0, math.nan])
    simulated = make_ranges([1.1, 1.3, 1.0, math.inf, 1.0])
    found = compare_ranges(recorded, simulated)
    assert found.pairs == 2
    assert (found.median_m, found.p95_m) == pytest.approx((0.2, 0.29))


def test_ranges_without_a_common_echo_have_no_difference() -> None:
    found = compare_ranges(make_ranges([math.inf, 1.0]), make_ranges([1.0, math.inf]))
    assert (found.median_m, found.p95_m, found.pairs) == (None, None, 0)


def test_scans_with_another_number_of_rays_are_not_compared() -> None:
    wide = RangeSeries()
    wide.add(0, np.array([1.0, 2.0]), 0.0)
    assert compare_ranges(make_ranges([1.0]), wide).pairs == 0


def test_a_missing_sample_and_a_sample_without_an_echo_are_lost_echoes() -> None:
    assert make_ranges([1.0] * 10).lost_share == 0.0
    assert make_ranges([1.0, 1.0, math.nan, 1.0, math.inf, 1.0, 1.0, 1.0, 1.0, 1.0]).lost_share == pytest.approx(0.2)
    assert RangeSeries().lost_share is None


def test_memory_for_ranges_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.fidelity.run_data.MAX_DISTANCES", 3)
    assert len(make_ranges([1.0] * 5).distances) == 3


def make_pictures(shift_px: int, brightness: int = 0) -> PictureSeries:
    noise = np.random.RandomState(1).randint(0, 200, (30, 52))
    wide = np.kron(noise, np.ones((8, 8))).astype(np.uint8) + np.uint8(brightness)
    series = PictureSeries(320)
    series.add(0, np.ascontiguousarray(wide[:, 40 + shift_px : 360 + shift_px]))
    return series


@pytest.mark.parametrize("shift_px", [0, 8, -12])
def test_the_shift_of_pictures_is_measured_in_pixels_of_the_camera(shift_px: int) -> None:
    pictures = make_pictures(0), make_pictures(shift_px)
    found = compare_pictures(*pictures)
    assert found.shift_px == pytest.approx(abs(shift_px), abs=1.0)
    assert (found.grey_share > 0.02) is bool(shift_px)
    assert compare_pictures(*pictures) == found, "the pictures were changed"


def test_grey_pictures_are_compared_in_shares_of_the_range() -> None:
    assert compare_pictures(make_pictures(0), make_pictures(0, 51)).grey_share == pytest.approx(0.2)


def test_pictures_without_features_have_no_shift() -> None:
    plain = PictureSeries(320)
    plain.pictures[0] = np.full((60, 80), 128.0)
    assert compare_pictures(plain, plain).shift_px is None


def test_colour_and_grey_pictures_shrink_to_the_same_size() -> None:
    assert shrink(np.zeros((240, 320, 3), np.uint8)).shape == shrink(np.zeros((480, 640), np.uint8)).shape == (60, 80)
