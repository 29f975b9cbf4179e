"""Measure how well and how fast the colour detector finds a ball, in easy and in hard pictures.

    python -m benchmarks.detector

Two renderers draw the pictures from a seed, and `benchmarks/eyes` degrades them. Each method gives one answer for each
frame. The thresholds of the other methods were tuned on frames of other seeds (`benchmarks.eyes.tuning`). The exit
status is 1 if the detector is worse than the tuned classical pipeline, or slower than its bound.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence

import cv2

from benchmarks.eyes.frames import LabelledFrame, draw_frame
from benchmarks.eyes.masks import Point
from benchmarks.eyes.rivals import BallTracking, ChromaTable, Classical, FindBlobs
from benchmarks.eyes.scoring import Finder, Score, Verdict, judge_frames
from benchmarks.eyes.timing import measure_copies
from benchmarks.report import at_least_one, machine, print_table
from robotcore.autonomy.navigation.ball import KEPT_PX
from robotcore.autonomy.vision import ColourDetector
from robotcore.hal.devices import Image
from robotcore.optics import Intrinsics

BOUND_COPIES = 15.0
INTRINSICS = Intrinsics(320, 240, math.radians(62))


class Detector:
    """The project's `ColourDetector` as a finder: returns the first blob, as green-search does."""

    def __init__(self) -> None:
        self._of_hue: dict[float, ColourDetector] = {}

    def __call__(self, image: Image, hue: float) -> Point | None:
        if hue not in self._of_hue:
            self._of_hue[hue] = ColourDetector(hue, min_area=KEPT_PX)
        blobs = self._of_hue[hue].find(image, INTRINSICS)
        return blobs[0].centroid if blobs else None


OWN, CLASSICAL = "ColourDetector", "HSV, largest contour, tuned"
FINDERS: Mapping[str, Finder] = {
    OWN: Detector(),
    CLASSICAL: Classical(25, 120, 30, 3),
    "HSV, largest contour, as published": Classical(),
    "HSV with blur and opening, tuned": Classical(25, 120, 30, 0, is_smoothed=True),
    "HSV with blur and opening, as published": Classical(is_smoothed=True),
    "Ball Tracking with OpenCV, tuned": BallTracking(600, 25, 120, 15, 1.0, 1, 5),
    "Ball Tracking with OpenCV, as published": BallTracking(),
    "OpenMV find_blobs, L*a*b* box, tuned": FindBlobs(0.5, 10, 3, 6),
    "CMVision, YUV box, tuned": ChromaTable(0.4, 0.12, 5, 3),
}


def main() -> int:
    """Score and time every finder, and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--frames", type=at_least_one, default=1000)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    frames = [draw_frame(options.seed, number) for number in range(options.frames)]
    print(machine())
    print(f"{len(frames)} frames, {sum(one.has_ball for one in frames)} with a ball; every second frame is hard")
    verdicts = {name: judge_frames(finder, frames) for name, finder in FINDERS.items()}
    columns = ("precision / recall, %", "easy", "hard", "all", "centroid off by, px", "ColourDetector, same frames")
    print_table(columns, [_build_row(name, frames, verdicts) for name in FINDERS])
    print()
    ratio = _print_times(frames)
    return int(not _is_ahead(frames, verdicts) or ratio > BOUND_COPIES)


def _build_row(name: str, frames: Sequence[LabelledFrame], verdicts: Mapping[str, list[Verdict]]) -> tuple[str, ...]:
    score = Score.of(verdicts[name])
    shared = [own for own, other in zip(verdicts[OWN], verdicts[name], strict=True) if own.is_hit and other.is_hit]
    also = [other for own, other in zip(verdicts[OWN], verdicts[name], strict=True) if own.is_hit and other.is_hit]
    halves = [_score_half(frames, verdicts[name], is_hard=is_hard) for is_hard in (False, True)]
    rates = [f"{100 * each.precision:.1f} / {100 * each.recall:.1f}" for each in (*halves, score)]
    return (name, *rates, _format_error(Score.of(also)), _format_error(Score.of(shared)))


def _score_half(frames: Sequence[LabelledFrame], verdicts: Sequence[Verdict], *, is_hard: bool) -> Score:
    return Score.of(verdict for one, verdict in zip(frames, verdicts, strict=True) if one.is_hard is is_hard)


def _format_error(score: Score) -> str:
    return f"{score.median_px:.2f}, 95 %: {score.p95_px:.1f}"


def _print_times(frames: Sequence[LabelledFrame]) -> float:
    """Print the time of a call of each finder, in copies of a frame. Return the detector's median without a cache."""
    rows = []
    medians = []
    for name, finder in FINDERS.items():
        cells = []
        for in_cache in (False, True):
            ratio, seconds = measure_copies(finder, frames, in_cache=in_cache)
            cells += [f"{ratio.median:.1f} ({ratio.low:.1f} to {ratio.high:.1f})", f"{1e6 * seconds:.0f}"]
            medians.append(ratio.median)
        rows.append((name, *cells))
    print_table(("median (95 %)", "copies, as frames come", "µs", "copies, in the cache", "µs"), rows)
    return medians[0]


def _is_ahead(frames: Sequence[LabelledFrame], verdicts: Mapping[str, list[Verdict]]) -> bool:
    """Return whether the detector is no worse than the tuned classical pipeline, and better on hard frames."""
    own, rival = Score.of(verdicts[OWN]), Score.of(verdicts[CLASSICAL])
    own_hard, rival_hard = (_score_half(frames, verdicts[name], is_hard=True) for name in (OWN, CLASSICAL))
    is_no_worse = own.precision >= rival.precision and own.recall >= rival.recall
    return is_no_worse and own_hard.precision > rival_hard.precision and own_hard.recall > rival_hard.recall


if __name__ == "__main__":
    sys.exit(main())
