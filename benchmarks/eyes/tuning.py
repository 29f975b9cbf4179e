"""Search for the best thresholds of the rivals, on frames of other seeds than those of `benchmarks.detector`.

    python -m benchmarks.eyes.tuning --seeds 11,12 --frames 600

Each combination of a grid is scored. The one with the best F1 score (the harmonic mean of precision and recall) is
printed. ``benchmarks/detector.py`` contains the printed values.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import product

import cv2

from benchmarks.eyes.frames import draw_frame
from benchmarks.eyes.rivals import BallTracking, ChromaTable, Classical, FindBlobs
from benchmarks.eyes.scoring import Finder, Score, judge_frames
from benchmarks.report import at_least_one


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="11,12")
    parser.add_argument("--frames", type=at_least_one, default=600, help="the number of frames for each seed")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    frames = [draw_frame(int(seed), number) for seed in options.seeds.split(",") for number in range(options.frames)]
    for grid in (plain(), smoothed(), tracking(), blobs(), tables()):
        score, best = max((Score.of(judge_frames(finder, frames)).f1, str(finder)) for finder in grid)
        print(f"F1 {score:.4f}  {best}", flush=True)


def plain() -> Iterator[Finder]:
    for tolerance, saturation, value, area in product((25, 30, 35), (90, 100, 110, 120, 130), (10, 20, 30), (0, 3, 6)):
        yield Classical(tolerance, saturation, value, area)


def smoothed() -> Iterator[Finder]:
    for tolerance, saturation, value, area in product((25, 30, 35), (90, 100, 110, 120, 130), (10, 20, 30), (0, 3, 6)):
        yield Classical(tolerance, saturation, value, area, is_smoothed=True)


def tracking() -> Iterator[Finder]:
    for width, tolerance, saturation, radius, rounds, blur in product(
        (320, 600), (25, 30), (90, 100, 110, 120), (1.0, 2.0), (0, 1), (5, 11)
    ):
        yield BallTracking(width, tolerance, saturation, 15, radius, rounds, blur)


def blobs() -> Iterator[Finder]:
    for weakest, slack, lightness, pixels in product((0.3, 0.4, 0.5, 0.6), (4, 7, 10, 15), (3, 5, 10), (6, 10)):
        yield FindBlobs(weakest, slack, lightness, pixels)


def tables() -> Iterator[Finder]:
    for nearest, beside, luma, area in product((0.35, 0.4, 0.45, 0.5, 0.6), (0.12, 0.15, 0.2), (5, 10, 25), (3, 6)):
        yield ChromaTable(nearest, beside, luma, area)


if __name__ == "__main__":
    main()
