from __future__ import annotations

import numpy as np
import pytest

from robotcore.runtime.layers.imperfections import Noise

SHAPE = (24, 32, 3)
TIMES = [tick / 20 for tick in range(400)]


def test_an_instant_has_its_noise_however_often_it_is_asked_for() -> None:
    often, seldom = Noise(1, "eye", 4.0), Noise(1, "eye", 4.0)
    for time in TIMES[:10]:
        often.at(time)
        often.over(SHAPE, time)
    assert often.at(0.5) == seldom.at(0.5)
    assert np.array_equal(often.over(SHAPE, 0.5), seldom.over(SHAPE, 0.5))


@pytest.mark.parametrize("other", [Noise(2, "eye", 4.0), Noise(1, "nose", 4.0)], ids=["seed", "device"])
def test_another_seed_or_device_has_another_noise(other: Noise) -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.at(0.5) != other.at(0.5)
    assert not np.array_equal(noise.over(SHAPE, 0.5), other.over(SHAPE, 0.5))


def test_every_instant_has_noise_of_its_own() -> None:
    noise = Noise(1, "eye", 4.0)
    assert len({noise.at(time) for time in TIMES}) == len(TIMES)
    assert len({noise.over(SHAPE, time).tobytes() for time in TIMES}) > 0.98 * len(TIMES)


def test_numbers_err_by_the_deviation_and_not_on_average() -> None:
    noise = Noise(1, "nose", 0.01)
    errors = [noise.at(time) for time in TIMES]
    assert np.std(errors) == pytest.approx(0.01, rel=0.15)
    assert abs(np.mean(errors)) < 0.002


@pytest.mark.parametrize("sigma", [0.1, 0.2, 0.5, 1.0, 4.0, 64.0])
def test_a_picture_errs_by_the_deviation_however_small(sigma: float) -> None:
    picture = Noise(1, "eye", sigma).over((480, 640, 3), 0.5).astype(float)
    assert np.std(picture) == pytest.approx(sigma, rel=0.02)
    assert abs(picture.mean()) < sigma / 100


def test_every_pixel_of_a_picture_errs_by_itself() -> None:
    picture = Noise(1, "eye", 4.0).over((240, 320, 3), 0.5).astype(float)
    assert abs((picture[:, 1:] * picture[:, :-1]).mean()) < 0.3


def test_one_pixel_errs_by_the_deviation_from_instant_to_instant() -> None:
    noise = Noise(1, "eye", 4.0)
    errors = [noise.over(SHAPE, time)[3, 4, 1] for time in TIMES]
    assert np.std(errors) == pytest.approx(4.0, rel=0.15)


def test_noise_is_what_it_was_when_this_was_written() -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.at(0.5) == pytest.approx(3.195127317405856)
    assert noise.over(SHAPE, 0.5)[0, :2].tolist() == [[2, 4, 0], [2, -5, -4]]
