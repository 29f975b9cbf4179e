"""Measure how well and how fast the colour detector finds a ball, in easy and in hard pictures.

    python -m benchmarks.detector
    python -m benchmarks.detector --tune --seed 11 --frames 600

`benchmarks.frames` draws the pictures from a seed, with two renderers. The detector is compared with the
usual pipeline of OpenCV. Each method gives one answer for each frame. The unit of time is the copy of a frame. With
`--tune`, the script prints the pipeline's best thresholds by F1, the harmonic mean of precision and recall, on the
frames of two seeds. The exit status is 1 if the detector is worse than the tuned pipeline.
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from time import perf_counter
from typing import NamedTuple

import cv2
import numpy as np

from benchmarks.frames import LabelledFrame, draw_frame
from benchmarks.report import Interval, compute_median, parse_options, print_table
from robotcore.autonomy.navigation.ball import MIN_BLOB_PX
from robotcore.autonomy.vision import ColourDetector
from robotcore.optics import Image, Intrinsics

INTRINSICS = Intrinsics(320, 240, math.radians(62))

Finder = Callable[[Image, float], "tuple[float, float] | None"]
"""A function that returns the position of the ball in pixels, or None, for a BGR picture and a hue in degrees."""


class Detector:
    """The project's `ColourDetector` as a finder: returns the first blob, as green-search does."""

    def __init__(self) -> None:
        self._of_hue: dict[float, ColourDetector] = {}

    def __call__(self, image: Image, hue: float) -> tuple[float, float] | None:
        if hue not in self._of_hue:
            self._of_hue[hue] = ColourDetector(hue, min_area=MIN_BLOB_PX)
        blobs = self._of_hue[hue].find(image, INTRINSICS)
        return blobs[0].centroid if blobs else None


@dataclass(frozen=True)
class Classical:
    """The usual pipeline: HSV, ``inRange``, ``findContours``, and the largest contour.

    The default thresholds are from OpenCV's tutorial "Changing Colorspaces": a hue ± 10 of 180, saturation and value
    from 50.
    """

    tolerance: float = 20.0
    min_saturation: int = 50
    min_value: int = 50
    min_area: int = 0

    def __call__(self, image: Image, hue: float) -> tuple[float, float] | None:
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        low, high = math.ceil((hue - self.tolerance) / 2), math.floor((hue + self.tolerance) / 2)
        mask = np.zeros(image.shape[:2], np.uint8)
        for turn in (-180, 0, 180):
            first, last = max(0, low + turn), min(179, high + turn)
            if first <= last:
                least, most = (first, self.min_saturation, self.min_value), (last, 255, 255)
                mask |= np.asarray(cv2.inRange(hsv, least, most), np.uint8)
        outlines = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)[0]
        best = max(outlines, key=cv2.contourArea, default=None)
        if best is None or cv2.contourArea(best) < self.min_area:
            return None
        if (moments := cv2.moments(best))["m00"]:
            return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
        u, v = np.asarray(best, np.float64).reshape(-1, 2).mean(axis=0)
        return float(u), float(v)


class Score(NamedTuple):
    """The score of a finder: precision (hits / answers), recall (hits / balls), and errors of the centroid in pixels.

    An answer is a hit within the bounding box of the ball's visible pixels.
    """

    precision: float
    recall: float
    errors_px: Sequence[float]

    @property
    def f1(self) -> float:
        both = self.precision + self.recall
        return 2 * self.precision * self.recall / both if both else 0.0

    @classmethod
    def from_frames(cls, finder: Finder, frames: Iterable[LabelledFrame]) -> Score:
        """Return the score of a finder on frames."""
        balls, answers, errors = 0, 0, []
        for frame in frames:
            place = finder(frame.image, frame.hue)
            balls += frame.has_ball
            answers += place is not None
            if place is not None and frame.holds(*place):
                errors.append(math.dist(place, frame.centroid))
        return cls(len(errors) / max(1, answers), len(errors) / max(1, balls), sorted(errors))

    def format_error(self) -> str:
        """Return the median and the 95th percentile of the errors."""
        if not self.errors_px:
            return ""
        tail = self.errors_px[int(0.95 * (len(self.errors_px) - 1))]
        return f"{statistics.median(self.errors_px):.2f}, 95 %: {tail:.1f}"


OWN, CLASSICAL = "ColourDetector", "HSV, largest contour, tuned"
FINDERS: Mapping[str, Finder] = {
    OWN: Detector(),
    CLASSICAL: Classical(25, 120, 30, 3),
    "HSV, largest contour, as published": Classical(),
}


def main() -> int:
    """Score and time every finder, and print the table."""
    options = parse_options(__doc__, seed=0, frames=1000, tune=False)
    cv2.setNumThreads(1)
    seeds = (options.seed, options.seed + 1) if options.tune else (options.seed,)
    frames = [draw_frame(seed, number) for seed in seeds for number in range(options.frames)]
    if options.tune:
        grid = product((25, 30, 35), (90, 100, 110, 120, 130), (10, 20, 30), (0, 3, 6))
        f1, best = max(
            (Score.from_frames(finder, frames).f1, str(finder)) for finder in (Classical(*values) for values in grid)
        )
        print_table(("best thresholds", "F1"), [(best, f"{f1:.4f}")])
        return 0
    print(f"{len(frames)} frames, {sum(one.has_ball for one in frames)} with a ball; every second frame is hard")
    halves = {"easy": [one for one in frames if not one.is_hard], "hard": [one for one in frames if one.is_hard]}
    scores = {
        name: {half: Score.from_frames(finder, some) for half, some in (*halves.items(), ("all", frames))}
        for name, finder in FINDERS.items()
    }
    times = {name: _measure_copies(finder, frames) for name, finder in FINDERS.items()}
    columns = ("precision / recall, %", "easy", "hard", "all", "centroid off by, px", "time, copies", "µs")
    print_table(columns, [_build_row(name, scores[name], *times[name]) for name in FINDERS])
    return int(not _is_ahead(scores[OWN], scores[CLASSICAL]))


def _build_row(name: str, scores: Mapping[str, Score], copies: Interval, seconds: float) -> tuple[str, ...]:
    rates = (f"{100 * each.precision:.1f} / {100 * each.recall:.1f}" for each in scores.values())
    median, interval = copies.format_cells(".1f")
    return (name, *rates, scores["all"].format_error(), f"{median} ({interval})", f"{1e6 * seconds:.0f}")


def _measure_copies(finder: Finder, frames: Sequence[LabelledFrame]) -> tuple[Interval, float]:
    """Return the time of a call, in copies of a frame, and the median time of a call in seconds.

    Call and copy are measured in alternating order. Each frame is used once, as a camera delivers it.
    """
    target, ratios, calls = np.empty_like(frames[0].image), [], []
    works = (lambda frame: np.copyto(target, frame.image)), (lambda frame: finder(frame.image, frame.hue))
    for number, frame in enumerate(frames):
        times = {which: _time_call(works[which], frame) for which in ((0, 1) if number % 2 else (1, 0))}
        ratios.append(times[1] / times[0])
        calls.append(times[1])
    return compute_median(ratios), statistics.median(calls)


def _time_call(work: Callable[[LabelledFrame], object], frame: LabelledFrame) -> float:
    start = perf_counter()
    work(frame)
    return perf_counter() - start


def _is_ahead(own: Mapping[str, Score], rival: Mapping[str, Score]) -> bool:
    """Return whether the detector is no worse than the tuned pipeline, and better on hard frames."""
    is_no_worse = own["all"].precision >= rival["all"].precision and own["all"].recall >= rival["all"].recall
    is_better = own["hard"].precision > rival["hard"].precision and own["hard"].recall > rival["hard"].recall
    return is_no_worse and is_better


if __name__ == "__main__":
    sys.exit(main())
