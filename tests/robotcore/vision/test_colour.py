from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.description import COLOURS, hue_degrees
from robotcore.devices import Image
from robotcore.errors import UnknownNameError, UsageError
from robotcore.vision import HUES, Blob, ColourDetector, hue_of
from tests.robotcore.vision.pictures import INTRINSICS, bgr, painted

GREEN, RED = bgr(128), bgr(0)


def find(image: Image, detector: ColourDetector | None = None) -> list[Blob]:
    return (detector or ColourDetector("green")).find(image, INTRINSICS)


class TestHue:
    @pytest.mark.parametrize(
        "hue, degrees", [("green", 128.0), ("red", 0.0), (90, 90.0), ("90", 90.0), (-30, 330.0), (720.5, 0.5)]
    )
    def test_is_given_by_name_or_degrees(self, hue: str | float, degrees: float) -> None:
        assert hue_of(hue) == degrees

    def test_an_unknown_name_offers_the_nearest(self) -> None:
        with pytest.raises(UnknownNameError, match=r"unknown hue 'gren'. Did you mean 'green'\?"):
            ColourDetector("gren")

    @pytest.mark.parametrize("hue", ["nan", math.inf])
    def test_what_is_no_number_is_refused(self, hue: str | float) -> None:
        with pytest.raises(UsageError, match="the hue is"):
            hue_of(hue)

    @pytest.mark.parametrize("name", HUES)
    def test_a_named_hue_is_that_of_the_colour_of_that_name_in_a_world(self, name: str) -> None:
        away = (hue_degrees(COLOURS[name]) - HUES[name] + 180) % 360 - 180
        assert abs(away) < 5


class TestFind:
    def test_tells_where_a_patch_is_and_how_large(self) -> None:
        (blob,) = find(painted((GREEN, (10, 20, 8, 6))))
        assert blob.box == (10, 20, 8, 6)
        assert blob.area == 48
        assert blob.centroid == (13.5, 22.5)
        assert blob.radius == 4.0
        assert not blob.is_clipped

    def test_finds_nothing_where_there_is_nothing(self) -> None:
        assert find(painted()) == []

    def test_puts_the_largest_first(self) -> None:
        image = painted((GREEN, (2, 2, 5, 5)), (GREEN, (20, 2, 9, 9)), (GREEN, (40, 2, 7, 7)))
        assert [blob.area for blob in find(image)] == [81, 49, 25]

    def test_leaves_out_what_is_smaller_than_asked_for(self) -> None:
        image = painted((GREEN, (2, 2, 4, 3)), (GREEN, (20, 2, 11, 1)))
        assert [blob.area for blob in find(image)] == [12]
        assert [blob.area for blob in find(image, ColourDetector("green", min_area=11))] == [12, 11]

    @pytest.mark.parametrize("left, sign", [(5, 1), (50, -1)])
    def test_bearing_is_positive_to_the_left(self, left: int, sign: int) -> None:
        (blob,) = find(painted((GREEN, (left, 20, 6, 6))))
        assert math.copysign(1, blob.bearing) == sign
        assert blob.bearing == INTRINSICS.bearing(blob.centroid[0])

    @pytest.mark.parametrize(
        "box, is_clipped",
        [
            ((0, 20, 6, 6), True),
            ((20, 0, 6, 6), True),
            ((58, 20, 6, 6), True),
            ((20, 42, 6, 6), True),
            ((1, 1, 62, 46), False),
        ],
    )
    def test_a_patch_at_the_edge_is_clipped(self, box: tuple[int, int, int, int], is_clipped: bool) -> None:
        (blob,) = find(painted((GREEN, box)))
        assert blob.is_clipped is is_clipped

    @pytest.mark.parametrize("hue", range(0, 360, 15))
    def test_finds_its_own_hue_and_not_one_beyond_the_tolerance(self, hue: int) -> None:
        detector = ColourDetector(hue, tolerance=20)
        for near in (-15, 0, 15):
            assert len(find(painted((bgr(hue + near), (10, 10, 8, 8))), detector)) == 1
        for far in (-26, 26, 180):
            assert find(painted((bgr(hue + far), (10, 10, 8, 8))), detector) == []

    def test_red_is_one_patch_on_both_sides_of_zero(self) -> None:
        image = painted((bgr(350), (10, 10, 8, 8)), (bgr(10), (18, 10, 8, 8)))
        (blob,) = find(image, ColourDetector("red"))
        assert blob.box == (10, 10, 16, 8)

    @pytest.mark.parametrize("saturation, value", [(0.2, 0.8), (1.0, 0.1)])
    def test_what_is_pale_or_dark_is_of_no_hue(self, saturation: float, value: float) -> None:
        assert find(painted((bgr(128, saturation, value), (10, 10, 8, 8)))) == []

    def test_the_picture_stays_as_it_was(self) -> None:
        image = painted((GREEN, (10, 10, 8, 8)))
        before = image.copy()
        assert not image.flags.writeable
        find(image)
        assert (image == before).all()

    @given(st.integers(1, 50), st.integers(1, 35), st.integers(4, 12), st.integers(3, 12))
    def test_a_patch_is_found_wherever_it_is(self, left: int, top: int, width: int, height: int) -> None:
        width, height = min(width, 63 - left), min(height, 47 - top)
        (blob,) = find(painted((GREEN, (left, top, width, height))), ColourDetector("green", min_area=1))
        assert (blob.box, blob.area) == ((left, top, width, height), width * height)
