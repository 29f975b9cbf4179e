from __future__ import annotations

import math

import pytest

from robotcore.autonomy.vision import HUES, ColourDetector, hue_of
from robotcore.description import COLOURS, hue_degrees
from robotcore.errors import UnknownNameError, UsageError


@pytest.mark.parametrize(
    "hue, degrees", [("green", 128.0), ("red", 0.0), (90, 90.0), ("90", 90.0), (-30, 330.0), (720.5, 0.5)]
)
def test_is_given_by_name_or_degrees(hue: str | float, degrees: float) -> None:
    assert hue_of(hue) == degrees


def test_an_unknown_name_offers_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown hue 'gren'. Did you mean 'green'\?"):
        ColourDetector("gren")


@pytest.mark.parametrize("hue", ["nan", math.inf])
def test_what_is_no_number_is_refused(hue: str | float) -> None:
    with pytest.raises(UsageError, match="the hue is"):
        hue_of(hue)


@pytest.mark.parametrize("name", HUES)
def test_a_named_hue_is_that_of_the_colour_of_that_name_in_a_world(name: str) -> None:
    away = (hue_degrees(COLOURS[name]) - HUES[name] + 180) % 360 - 180
    assert abs(away) < 5
