"""Score the answers of a finder on labelled frames."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from benchmarks.eyes.frames import LabelledFrame
from benchmarks.eyes.masks import Point
from robotcore.hal.devices import Image

Finder = Callable[[Image, float], "Point | None"]
"""A function that returns the position of the ball in pixels, or None, for a BGR picture and a hue in degrees."""


class Verdict(NamedTuple):
    """The verdict on an answer of a finder. ``error_px`` is the error of the centroid; None if the ball was missed."""

    has_ball: bool
    is_answered: bool
    error_px: float | None

    @property
    def is_hit(self) -> bool:
        return self.error_px is not None


class Score(NamedTuple):
    """The score of a finder: precision (hits / answers), recall (hits / balls), and error of the centroid.

    The error is given as median and 95th percentile, in pixels.
    """

    precision: float
    recall: float
    median_px: float
    p95_px: float

    @property
    def f1(self) -> float:
        both = self.precision + self.recall
        return 2 * self.precision * self.recall / both if both else 0.0

    @classmethod
    def of(cls, verdicts: Iterable[Verdict]) -> Score:
        """Return the score of all verdicts together."""
        verdicts = list(verdicts)
        errors = sorted(one.error_px for one in verdicts if one.error_px is not None)
        precision = len(errors) / max(1, sum(one.is_answered for one in verdicts))
        recall = len(errors) / max(1, sum(one.has_ball for one in verdicts))
        return cls(precision, recall, *_middle_and_tail(errors))


def judge_frames(finder: Finder, frames: Iterable[LabelledFrame]) -> list[Verdict]:
    """Return a verdict for each frame. An answer is a hit within the bounding box of the ball's visible pixels."""
    return [_verdict(frame, finder(frame.image, frame.hue)) for frame in frames]


def _verdict(frame: LabelledFrame, place: Point | None) -> Verdict:
    if place is None or not frame.holds(*place):
        return Verdict(frame.has_ball, place is not None, None)
    return Verdict(has_ball=True, is_answered=True, error_px=math.dist(place, frame.centroid))


def _middle_and_tail(ordered: Sequence[float]) -> tuple[float, float]:
    if not ordered:
        return math.nan, math.nan
    return statistics.median(ordered), ordered[math.floor(0.95 * (len(ordered) - 1))]
