from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.autonomy.vision import Blob, ColourDetector, draw_boxes
from robotcore.autonomy.vision.colour_detector import YELLOW
from robotcore.errors import UsageError
from robotcore.kinds.camera import Frame
from robotcore.optics import Image, Intrinsics
from tests.robotcore.autonomy.vision.pictures import INTRINSICS, bgr, draw_rectangles, draw_round_patch
from tests.texts import Raises

GREEN, RED = bgr(128), bgr(0)


def find(image: Image, detector: ColourDetector | None = None) -> list[Blob]:
    return (detector or ColourDetector("green")).find(image, INTRINSICS)


class TestFind:
    def test_blob_has_position_and_area(self) -> None:
        (blob,) = find(draw_rectangles((GREEN, (10, 20, 8, 6))))
        assert blob.box == (10, 20, 8, 6)
        assert blob.area == 48
        assert blob.centroid == (13.5, 22.5)
        assert blob.radius == 4.0
        assert not blob.is_clipped

    def test_blobs_below_the_least_area_are_left_out(self) -> None:
        image = draw_rectangles((GREEN, (2, 2, 4, 3)), (GREEN, (20, 2, 11, 1)))
        assert [blob.area for blob in find(image)] == [12]
        assert [blob.area for blob in find(image, ColourDetector("green", min_area=11))] == [12, 11]

    @given(st.tuples(st.integers(12, 50), st.integers(12, 35)), st.floats(2, 11), st.sampled_from((1, 2)))
    def test_area_of_discs_and_diamonds_is_their_number_of_pixels(
        self, centre: tuple[int, int], radius: float, norm: int
    ) -> None:
        image = draw_round_patch(GREEN, centre, radius, norm)
        pixels = int((image == GREEN).all(axis=2).sum())
        (blob,) = find(image, ColourDetector("green", min_area=pixels))
        assert blob.area == pixels
        assert blob.centroid == pytest.approx(centre)
        assert find(image, ColourDetector("green", min_area=pixels + 1)) == []

    def test_blob_in_the_box_of_a_larger_one_is_left_out(self) -> None:
        corner = (GREEN, (5, 5, 30, 4)), (GREEN, (5, 5, 4, 30))
        (blob,) = find(draw_rectangles(*corner, (GREEN, (20, 20, 8, 8))))
        assert blob.area == 2 * 120 - 16

    def test_blob_is_found_among_many_specks(self) -> None:
        specks = [(GREEN, (x, y, 2, 2)) for x in range(2, 60, 6) for y in range(26, 44, 6)]
        (blob,) = find(draw_rectangles((GREEN, (30, 4, 10, 10)), *specks))
        assert blob.box == (30, 4, 10, 10)

    def test_of_more_than_eight_patches_the_small_ones_are_left_out(self) -> None:
        places = [(12 * column + 2, top) for top in (2, 24) for column in range(5)]
        patches = [(GREEN, (left, top, 8, 4 + 2 * n)) for n, (left, top) in enumerate(places)]
        assert [blob.box[3] for blob in find(draw_rectangles(*patches))] == [22, 20, 18, 16, 14, 12, 10, 8]

    def test_of_more_than_eight_patches_a_compact_one_comes_before_long_ones_of_fewer_pixels(self) -> None:
        bars = [(GREEN, (left, top, 18, 4)) for left in (2, 26) for top in (2, 14, 26, 38)]
        blobs = find(draw_rectangles((GREEN, (50, 18, 10, 10)), *bars))
        assert [blob.area for blob in blobs] == [100] + 7 * [72]

    @pytest.mark.parametrize("visible", [0.15, 0.2, 0.3, 0.45, 0.5, 0.8, 1.0])
    @pytest.mark.parametrize("side", ["left", "top"])
    def test_radius_is_that_of_the_whole_disc_if_an_obstacle_hides_a_part(self, visible: float, side: str) -> None:
        image = draw_round_patch(GREEN, (32, 24), 20, norm=2)
        covered = image if side == "left" else image.transpose(1, 0, 2)
        covered[:, : round(32 + 20 - 40 * visible) if side == "left" else round(24 + 20 - 40 * visible)] = 128
        (blob,) = find(image)
        assert blob.radius == pytest.approx(20.5, rel=0.06)

    def test_radius_of_a_strip_between_two_obstacles_is_half_its_length(self) -> None:
        image = draw_round_patch(GREEN, (32, 24), 20, norm=2)
        image[:, :29], image[:, 35:] = 128, 128
        (blob,) = find(image)
        assert blob.radius == pytest.approx(20.5)

    @pytest.mark.parametrize("min_area", [0, -3, math.nan])
    def test_area_below_one_pixel_is_refused(self, raises: Raises, min_area: int) -> None:
        with raises(UsageError, "area-too-small"):
            ColourDetector("green", min_area=min_area)

    def test_picture_without_channels_is_refused(self, raises: Raises) -> None:
        with raises(UsageError, "grey-picture", shape=(48, 64)):
            find(np.zeros((48, 64), np.uint8))

    def test_frame_in_place_of_its_picture_is_refused(self, raises: Raises) -> None:
        frame: Any = Frame(draw_rectangles(), time=0.0, sequence=0)
        with raises(UsageError, "not-a-picture"):
            find(frame)

    @pytest.mark.parametrize("left, sign", [(5, 1), (50, -1)])
    def test_bearing_is_positive_to_the_left(self, left: int, sign: int) -> None:
        (blob,) = find(draw_rectangles((GREEN, (left, 20, 6, 6))))
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
            ((0, 0, 64, 48), True),
        ],
    )
    def test_a_patch_at_the_edge_is_clipped(self, box: tuple[int, int, int, int], is_clipped: bool) -> None:
        (blob,) = find(draw_rectangles((GREEN, box)))
        assert (blob.box, blob.is_clipped) == (box, is_clipped)

    @pytest.mark.parametrize("shape", [(1, 1), (2, 3), (47, 63), (239, 321)])
    def test_picture_may_have_any_size(self, shape: tuple[int, int]) -> None:
        image = np.full((*shape, 3), GREEN, np.uint8)
        (blob,) = ColourDetector("green", min_area=1).find(image, Intrinsics(shape[1], shape[0], 1.0))
        assert blob.box == (0, 0, shape[1], shape[0])
        assert blob.area == shape[0] * shape[1]


class TestHue:
    def test_finds_its_own_hue_and_not_one_beyond_the_tolerance(self) -> None:
        for hue in range(0, 360, 15):
            detector = ColourDetector(hue, tolerance=20)
            for near in (-15, 0, 15):
                assert len(find(draw_rectangles((bgr(hue + near), (10, 10, 8, 8))), detector)) == 1, hue
            for far in (-26, 26, 180):
                assert find(draw_rectangles((bgr(hue + far), (10, 10, 8, 8))), detector) == [], hue

    def test_red_is_one_patch_on_both_sides_of_zero(self) -> None:
        image = draw_rectangles((bgr(350), (10, 10, 8, 8)), (bgr(10), (18, 10, 8, 8)))
        (blob,) = find(image, ColourDetector("red"))
        assert blob.box == (10, 10, 16, 8)

    @given(st.integers(0, 2**32 - 1), st.integers(0, 359))
    def test_result_is_the_same_for_each_hue(self, seed: int, hue: int) -> None:
        """A rotation of the channels is a shift of the hue by 120 degrees."""
        dice = np.random.default_rng(seed)
        noisy = draw_rectangles((bgr(hue), (20, 15, 14, 12))) + dice.normal(0, 6, (48, 64, 3))
        image = np.clip(noisy, 0, 255).astype(np.uint8)
        rolled = np.ascontiguousarray(np.roll(image, -1, axis=2))
        found, moved = find(image, ColourDetector(hue)), find(rolled, ColourDetector(hue + 120))
        assert found
        assert moved[0].box == found[0].box

    @pytest.mark.parametrize("saturation, value", [(0.2, 0.8), (1.0, 0.02)])
    def test_pale_and_black_colours_have_no_hue(self, saturation: float, value: float) -> None:
        assert find(draw_rectangles((bgr(128, saturation, value), (10, 10, 8, 8)))) == []

    @pytest.mark.parametrize("tolerance", [0, -5, 90, math.nan])
    def test_tolerance_out_of_bounds_is_refused(self, raises: Raises, tolerance: float) -> None:
        with raises(UsageError, "tolerance-out-of-bounds"):
            ColourDetector("green", tolerance=tolerance)


class TestInBadLight:
    @given(st.floats(0.3, 1.3), st.floats(0.6, 1.0), st.floats(0.4, 0.95))
    def test_brightness_changes_nothing(self, brightness: float, saturation: float, value: float) -> None:
        image = np.minimum(brightness * draw_rectangles((bgr(128, saturation, value), (20, 15, 9, 7))), 255).astype(
            np.uint8
        )
        (blob,) = find(image)
        assert blob.box == (20, 15, 9, 7)

    @given(st.tuples(st.floats(0.8, 1.2), st.floats(0.9, 1.1), st.floats(0.8, 1.2)))
    def test_a_drift_of_the_white_balance_changes_nothing(self, gains: tuple[float, float, float]) -> None:
        image = np.minimum(draw_rectangles((bgr(128, 0.75, 0.7), (20, 15, 9, 7))) * np.array(gains), 255).astype(
            np.uint8
        )
        (blob,) = find(image)
        assert blob.box == (20, 15, 9, 7)

    @given(st.integers(0, 2**32 - 1), st.integers(10, 245), st.floats(0, 3))
    def test_noise_alone_is_no_ball(self, seed: int, grey: int, sigma: float) -> None:
        noise = np.random.default_rng(seed).normal(grey, sigma, (48, 64, 3))
        assert find(np.clip(noise, 0, 255).astype(np.uint8)) == []

    def test_highlight_belongs_to_the_ball(self) -> None:
        image = draw_rectangles((GREEN, (20, 10, 16, 16)), ((250, 250, 250), (24, 13, 5, 5)))
        (blob,) = find(image)
        assert (blob.box, blob.area) == ((20, 10, 16, 16), 256)

    @pytest.mark.parametrize("sigma", [0.5, 1.0, 2.0, 3.0])
    def test_a_blurred_edge_is_cut_half_way_down(self, sigma: float) -> None:
        import cv2

        image = np.asarray(cv2.GaussianBlur(draw_rectangles((GREEN, (20, 10, 20, 20))), (0, 0), sigma), np.uint8)
        (blob,) = find(image)
        left, top, width, height = blob.box
        assert (left, top, left + width, top + height) == pytest.approx((20, 10, 40, 30), abs=1)
        assert blob.centroid == pytest.approx((29.5, 19.5), abs=0.1)

    def test_a_lawn_is_not_the_ball_that_lies_on_it(self) -> None:
        lawn, ball = bgr(118, 0.48, 0.5), (28, 20, 10, 10)
        assert find(draw_rectangles((lawn, (0, 16, 64, 32)))) == []
        (blob,) = find(draw_rectangles((lawn, (0, 16, 64, 32)), (bgr(128, 0.8, 0.7), ball)))
        assert blob.box == ball

    def test_many_small_dull_patches_are_texture(self) -> None:
        dull = bgr(128, 0.5, 0.6)
        assert len(find(draw_rectangles((dull, (10, 10, 4, 4)), (dull, (40, 20, 4, 4))))) == 2
        blades = [(dull, (x, y, 4, 4)) for x in range(2, 60, 12) for y in range(2, 44, 12)]
        assert find(draw_rectangles(*blades)) == []

    def test_a_dull_ball_is_found_though_it_fills_the_picture(self) -> None:
        (blob,) = find(draw_rectangles((bgr(128, 0.55, 0.7), (0, 0, 64, 48))))
        assert blob.box == (0, 0, 64, 48)

    def test_a_dull_patch_is_found_where_nothing_else_is_of_the_hue(self) -> None:
        (blob,) = find(draw_rectangles((bgr(128, 0.48, 0.5), (28, 20, 10, 10))))
        assert blob.box == (28, 20, 10, 10)

    @pytest.mark.parametrize("hue", [60, 75, 184, 200])
    def test_yellow_green_and_cyan_are_not_green(self, hue: int) -> None:
        assert find(draw_rectangles((bgr(hue, 0.8, 0.7), (10, 10, 30, 20)))) == []


BOX = (20, 15, 8, 6)
IMAGE = draw_rectangles((bgr(128), BOX))
BLOBS = ColourDetector("green").find(IMAGE, INTRINSICS)


def test_a_rectangle_is_drawn_a_pixel_outside_the_blobs_box() -> None:
    left, top, width, height = BOX
    picture = draw_boxes(IMAGE, BLOBS)
    drawn = (picture == YELLOW).all(axis=2)
    for line, begin, length in ((drawn[top], left, width), (drawn[:, left], top, height)):
        before, after = range(begin - 4, begin - 1), range(begin + length + 1, begin + length + 4)
        assert np.flatnonzero(line).tolist() == [*before, *after]
    assert (picture[~drawn] == IMAGE[~drawn]).all()


@pytest.mark.parametrize("box", [(0, 0, 6, 6), (58, 42, 6, 6)])
def test_box_of_a_blob_at_the_edge_is_clipped(box: tuple[int, int, int, int]) -> None:
    image = draw_rectangles((bgr(128), box))
    picture = draw_boxes(image, ColourDetector("green").find(image, INTRINSICS))
    assert picture.shape == image.shape
    assert (picture == YELLOW).all(axis=2).any()


def test_paler_rim_belongs_to_the_region() -> None:
    image = np.full((240, 320, 3), 128, np.uint8)
    green = np.array([-60, 80, -60])
    image[80:140, 120:200] = (128 + 0.5 * green).astype(np.uint8)
    image[90:130, 130:190] = 128 + green
    assert [blob.box for blob in ColourDetector("green").find(image, Intrinsics(320, 240, 1.0))] == [(120, 80, 80, 60)]
