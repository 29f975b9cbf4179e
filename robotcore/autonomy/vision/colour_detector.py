"""Finds blobs of one hue in pictures, and draws boxes around them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from robotcore.autonomy.vision.hue_segmentation import (
    Box,
    HueClassifier,
    Region,
    compute_box,
    find_contours,
    find_hue,
    measure_region,
    pixels_in,
)
from robotcore.errors import UnknownNameError, UsageError
from robotcore.optics import Image, Intrinsics

HUES = {
    "red": 0.0,
    "orange": 28.0,
    "yellow": 53.0,
    "green": 128.0,
    "cyan": 184.0,
    "blue": 225.0,
    "purple": 273.0,
    "magenta": 316.0,
}
"""Hues by name, in degrees on the colour circle."""

HUE_RANGES = {
    "red": (-22.0, 14.0),
    "orange": (14.0, 40.5),
    "yellow": (40.5, 90.5),
    "green": (90.5, 158.0),
    "cyan": (158.0, 204.5),
    "blue": (204.5, 249.0),
    "purple": (249.0, 294.5),
    "magenta": (294.5, 338.0),
}
"""The smallest and the largest hue of each name, in degrees. Each hue of the circle belongs to one name.

A range ends in the middle between two named hues. Only that of green ends 2 degrees later, at 30 degrees from green.
"""


def parse_hue(hue: str | float) -> float:
    """Return a hue in degrees, in [0, 360). The argument is a name in `HUES` or any number of degrees.

    Raises UnknownNameError for an unknown name, and UsageError for a number that is not finite.

    >>> parse_hue("green"), parse_hue(-10)
    (128.0, 350.0)
    """
    try:
        degrees = float(hue)
    except ValueError:
        if hue not in HUES:
            raise UnknownNameError("hue", str(hue), list(HUES)) from None
        return HUES[str(hue)]
    if not math.isfinite(degrees):
        raise UsageError(f"the hue is {hue}; take a name or degrees from 0 to 360", kind="no-hue", hue=hue)
    return degrees % 360


def limit_tolerance(hue: str | float, tolerance: float) -> tuple[float, float]:
    """Return the tolerance below and above a hue, in degrees. For a name, both end at the limits of `HUE_RANGES`.

    hue: a name in `HUES`, or degrees.
    tolerance: the greatest difference from the hue, in degrees.

    >>> limit_tolerance("orange", 30), limit_tolerance(28, 30)
    ((14.0, 12.5), (30, 30))
    """
    if hue not in HUES:
        return tolerance, tolerance
    smallest, largest = HUE_RANGES[str(hue)]
    return min(tolerance, HUES[str(hue)] - smallest), min(tolerance, largest - HUES[str(hue)])


SEGMENT_FILL = 0.85
"""A segment of a disc fills less than this fraction of its bounding box: 0.67 if it is narrow, 0.79 if it is half."""


@dataclass(frozen=True, slots=True)
class Blob:
    """A connected region of one colour in a picture, with its holes filled.

    >>> Blob(centroid=(20.0, 15.0), box=(18, 12, 5, 7), area=35, bearing=0.1, is_clipped=False)
    <Blob of 35 pixels at (20, 15), bearing 0.10 rad>
    """

    centroid: tuple[float, float]
    """The column and the row of the region's centroid, in pixels."""
    box: tuple[int, int, int, int]
    """The left edge, the top edge, the width and the height of the region's bounding box, in pixels."""
    area: int
    """The number of pixels in the region."""
    bearing: float
    """The direction of the centroid from the camera's axis, in radians, positive to the left."""
    is_clipped: bool
    """Whether the region touches the picture's edge, so that a part of the body may be outside the picture."""

    def __repr__(self) -> str:
        column, row = self.centroid
        clipped = ", clipped" if self.is_clipped else ""
        return f"<Blob of {self.area} pixels at ({column:.0f}, {row:.0f}), bearing {self.bearing:.2f} rad{clipped}>"

    @property
    def radius(self) -> float:
        """The radius of the ball in the picture, in pixels, also if a vertical or horizontal edge hides a part.

        If less than half the ball is visible at its edge, the region is a segment of a disc, and the radius follows
        from the box's sides, the chord and the sagitta. A region that fills its box is a strip across the whole ball,
        so that its longer side is the diameter, as for a completely visible ball. For a region of a few pixels, and for
        a ball that is hidden from two neighbouring sides, the radius is too small.
        """
        chord, sagitta = max(self.box[2:]), min(self.box[2:]) - 0.5  # the chord is that of the last column's centre
        if sagitta < chord / 2 and self.area < SEGMENT_FILL * self.box[2] * self.box[3]:
            return (chord**2 / 4 + sagitta**2) / (2 * sagitta)
        return chord / 2


DEFAULT_TOLERANCE = 30.0
"""The default of ``tolerance``, in degrees: the greatest difference between a pixel's hue and that of the ball."""

CAST_FACTOR, MAX_MIN_SATURATION = 0.6, 0.38
"""A candidate needs more saturation if light tinges the whole picture with the hue.

``CAST_FACTOR`` times the picture's mean saturation is added to the threshold, up to ``MAX_MIN_SATURATION``.
"""

CHROMA_SHARE = 0.5
"""A pixel belongs to a region if its chroma is at least this fraction of the region's mean chroma."""

MARGIN_PX = 3
"""The width of the border around a candidate's box in which its region is searched too, in pixels of the picture."""

BLUR_ABOVE, MAX_CANDIDATES = 4, 8
"""More than ``BLUR_ABOVE`` candidates come from noise or texture, so the picture is blurred and searched again.

The ``MAX_CANDIDATES`` largest candidates of the blurred picture are measured.
"""


class ColourDetector:
    """Finds blobs of a hue in BGR pictures.

    The detector finds candidates by saturation and chroma in a picture of half the size. Then it measures the blobs
    near each candidate by hue in the full picture. It omits a blob whose centroid is in the box of a larger blob.

    hue: a name in `HUES`, or degrees.
    tolerance: the greatest difference between a pixel's hue and ``hue``, in degrees, more than 0 and less than 90. If
        ``hue`` is a name, the range also ends where the range of the next name begins, see `HUE_RANGES`.
    min_saturation: the least saturation of a candidate, 0 to 1. In a picture that is tinged with the hue it is higher.
    min_chroma: the least chroma of a candidate above that of ``min_saturation``, in grey levels.
    min_area: the least area of a blob, in pixels.

    >>> import numpy as np
    >>> from robotcore.optics import Intrinsics
    >>> picture = np.full((240, 320, 3), 128, np.uint8)
    >>> picture[100:120, 50:80] = (60, 170, 40)
    >>> [(blob.box, blob.area) for blob in ColourDetector("green").find(picture, Intrinsics(320, 240, 1.0))]
    [((50, 100, 30, 20), 600)]
    >>> ColourDetector("green")
    ColourDetector(hue=128, below=30, above=30, min_area=12)
    """

    def __init__(
        self,
        hue: str | float = "green",
        *,
        tolerance: float = DEFAULT_TOLERANCE,
        min_saturation: float = 0.22,
        min_chroma: float = 8.0,
        min_area: int = 12,
    ) -> None:
        if not 0 < tolerance < 90:
            text = f"the tolerance is {tolerance:g} degrees; take more than 0 and less than 90"
            raise UsageError(text, kind="tolerance-out-of-bounds", tolerance=tolerance)
        if not min_area >= 1:
            text = f"min_area is {min_area} pixels; take 1 or more"
            raise UsageError(text, kind="area-too-small", min_area=min_area)
        self.hue = parse_hue(hue)
        self._tolerances = limit_tolerance(hue, tolerance)
        self._hue_classifier = HueClassifier(self.hue, *self._tolerances)
        self._min_saturation = min_saturation
        self._min_chroma = min_chroma
        self._min_area = min_area

    def find(self, image: Image, intrinsics: Intrinsics) -> list[Blob]:
        """Return the blobs in a picture, the largest first.

        image: a BGR picture, (height, width, 3). The method does not change it.
        intrinsics: the intrinsics of the camera that took the picture.

        Raises UsageError for a grey picture, or if ``image`` is no array.
        """
        if not isinstance(image, np.ndarray):
            text = f"find needs a picture, not {image!r:.100}. Pass its array: robot.camera.read().image"
            raise UsageError(text, kind="not-a-picture")
        if image.ndim != 3:
            text = f"a picture of the shape {image.shape} has no colours; pass a BGR picture, (height, width, 3)"
            raise UsageError(text, kind="grey-picture", shape=image.shape)
        separate: list[Region] = []
        for region in sorted(self._find_regions(image), key=lambda region: region.area, reverse=True):
            if not any(region.lies_in(larger.box) for larger in separate):
                separate.append(region)
        return [_make_blob(region, intrinsics) for region in separate]

    def __repr__(self) -> str:
        below, above = self._tolerances
        return f"ColourDetector(hue={self.hue:g}, below={below:g}, above={above:g}, min_area={self._min_area})"

    def _find_regions(self, image: Image) -> Iterator[Region]:
        height, width = image.shape[:2]
        size = (width + 1) // 2, (height + 1) // 2
        half = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
        for box, chroma in self._find_candidates(half):
            yield from self._measure_regions(image, box, CHROMA_SHARE * chroma)

    def _find_candidates(self, image: Image) -> Iterator[tuple[Box, float]]:
        """Yield the box and the mean chroma of each candidate, in pixels of the half-size picture."""
        tests = self._hue_classifier.of_saturation(self._least_saturation(image), self._min_chroma)
        mask = find_hue(image, tests)
        candidates = find_contours(mask)
        if len(candidates) > BLUR_ABOVE:
            image = np.asarray(cv2.blur(image, (3, 3)), np.uint8)
            mask = find_hue(image, tests)
            candidates = sorted(find_contours(mask), key=pixels_in)[-MAX_CANDIDATES:]
        for candidate in candidates:
            left, top, width, height = box = compute_box(candidate)
            inside = slice(top, top + height), slice(left, left + width)
            yield box, self._hue_classifier.chroma(cv2.mean(image[inside], mask[inside]))

    def _measure_regions(self, image: Image, box: Box, chroma: float) -> Iterator[Region]:
        """Yield the regions with at least this chroma. ``box`` is in pixels of the half-size picture."""
        left, top, width, height = box
        right, bottom = 2 * (left + width) + MARGIN_PX, 2 * (top + height) + MARGIN_PX
        left, top = max(0, 2 * left - MARGIN_PX), max(0, 2 * top - MARGIN_PX)
        window = image[top:bottom, left:right].copy()  # OpenCV is faster with contiguous rows
        for contour in find_contours(find_hue(window, self._hue_classifier.of_chroma(chroma)), (left, top)):
            if pixels_in(contour) >= self._min_area:
                yield measure_region(contour)

    def _least_saturation(self, image: Image) -> float:
        cast = CAST_FACTOR * max(0.0, self._hue_classifier.saturation(cv2.mean(image)))
        return max(self._min_saturation, min(self._min_saturation + cast, MAX_MIN_SATURATION))


def _make_blob(region: Region, intrinsics: Intrinsics) -> Blob:
    left, top, width, height = region.box
    is_clipped = left == 0 or top == 0 or left + width == intrinsics.width or top + height == intrinsics.height
    return Blob(region.centroid, region.box, region.area, intrinsics.bearing(*region.centroid), is_clipped)


YELLOW = (0, 255, 255)


def draw_boxes(image: Image, blobs: Iterable[Blob]) -> Image:
    """Return a copy of a BGR picture with a yellow rectangle around each blob, one pixel outside the blob's box.

    image: the picture, ``uint8`` of shape (height, width, 3).
    blobs: the blobs, such as those that a `ColourDetector` has found.

    >>> import numpy as np
    >>> from robotcore.autonomy.vision import Blob
    >>> picture = np.zeros((48, 64, 3), np.uint8)
    >>> blob = Blob(centroid=(20.0, 15.0), box=(18, 12, 5, 7), area=35, bearing=0.1, is_clipped=False)
    >>> draw_boxes(picture, [blob])[12, 16].tolist()
    [0, 255, 255]
    """
    picture = image.copy()
    for blob in blobs:
        left, top, width, height = blob.box
        cv2.rectangle(picture, (left - 3, top - 3), (left + width + 2, top + height + 2), YELLOW, 2)
    return picture
