"""The errors of a range sensor, from samples before a wall."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import pytest

from robotcore.calibration.range_sensor import RangeFit, WallSamples, build_error_chart, fit_range
from robotcore.description import load_robot
from robotcore.errors import CalibrationError
from robotcore.kinds.range_sensor import Range, RangeSensorDescription
from tests.texts import Raises

NOSE = load_robot("rover").all_of(RangeSensorDescription)[0]
DISTANCES = (0.2, 0.4, 0.8, 1.2, 1.6)


def collect_samples(
    distance: float, *, offset: float = 0.0, scale: float = 0.0, loss: float = 0.0, is_silent: bool = True
) -> WallSamples:
    """Return the samples of a module. A lost echo is no sample if ``is_silent``, and else one of infinity."""
    draw = random.Random(f"{distance}:{offset}:{loss}")
    stop, time, sequence = WallSamples(distance), 0.0, 0
    for _ in range(200):
        time += 0.06 + draw.gauss(0, 0.0005)
        is_lost = draw.random() < loss
        if is_lost and is_silent:
            continue
        measured = distance * (1 + scale) + offset + draw.gauss(0, 0.004)
        stop.add(Range(math.inf if is_lost or measured > NOSE.max_range_m else measured, time, sequence))
        sequence += 1
    return stop


def fit(walls: Sequence[WallSamples]) -> RangeFit:
    return fit_range(walls, NOSE)


@pytest.mark.parametrize("is_silent", [True, False])
def test_offset_noise_and_lost_echoes_are_measured(*, is_silent: bool) -> None:
    found = fit([collect_samples(distance, offset=0.012, loss=0.1, is_silent=is_silent) for distance in DISTANCES])
    assert found.offset_m == pytest.approx(0.012, abs=0.001)
    assert found.noise_m == pytest.approx(0.004, rel=0.1)
    assert found.loss == pytest.approx(0.1, abs=0.025)
    assert found.scale == 0.0
    assert found.max_range_m is None
    echoes = sum(each.echoes for each in found.walls)
    assert found.noise_deviation_m == pytest.approx(found.noise_m / math.sqrt(2 * echoes), rel=0.02)
    assert found.loss_deviation == pytest.approx(math.sqrt(0.1 * 0.9 / echoes), rel=0.2)


def test_no_lost_echo_of_few_leaves_an_uncertain_loss() -> None:
    found = fit([collect_samples(distance) for distance in DISTANCES])
    assert found.loss == 0.0
    assert 0.0 < found.loss_deviation < 0.01


def test_an_error_that_grows_with_the_distance_is_no_offset() -> None:
    found = fit([collect_samples(distance, offset=0.01, scale=0.03) for distance in DISTANCES])
    assert found.offset_m == pytest.approx(0.01, abs=0.002)
    assert found.scale == pytest.approx(0.03, abs=0.003)


def test_a_wall_out_of_range_limits_the_range_and_counts_no_loss() -> None:
    found = fit([collect_samples(distance) for distance in (*DISTANCES, 2.5)])
    assert found.max_range_m == 1.6
    assert found.loss == 0.0
    assert math.isnan(found.walls[-1].measured_m)


def test_an_echo_of_another_thing_is_no_noise() -> None:
    walls = [collect_samples(distance) for distance in DISTANCES]
    last = walls[0].readings[-1]
    walls[0].add(Range(0.9, last.time + 0.06, last.sequence + 1))
    assert fit(walls).noise_m == pytest.approx(0.004, rel=0.1)


def test_a_sample_that_is_read_twice_counts_once() -> None:
    stop, sample = WallSamples(0.5), Range(0.5, 0.0, 0)
    stop.add(sample)
    stop.add(sample)
    assert stop.readings == [sample]


def test_one_distance_is_refused(raises: Raises) -> None:
    with raises(CalibrationError, "wall-not-seen", device="nose"):
        fit([collect_samples(0.5)])


def test_distances_that_do_not_fit_are_refused(raises: Raises) -> None:
    with raises(CalibrationError, "no-common-offset", device="nose", hide=["0.080", "0.079"]):
        fit([collect_samples(0.3, offset=0.1), collect_samples(0.6, offset=-0.1), collect_samples(0.9, offset=0.1)])


def test_the_chart_has_the_errors_and_the_fit() -> None:
    found = fit([collect_samples(distance, offset=0.012) for distance in DISTANCES])
    chart = build_error_chart(found, "nose")
    assert chart.series[0].xs == list(DISTANCES)
    assert chart.series[1].ys == pytest.approx([found.offset_m] * len(DISTANCES))
