"""Tracks, and texts on a canvas."""

from __future__ import annotations

import numpy as np

from robotcore.geometry import Pose
from robotcore.view.canvas import Canvas, measure_text
from robotcore.view.overhead import Track, TrackPoint


def test_a_track_has_the_segments_the_durations_and_the_milestones_of_its_states() -> None:
    track = Track()
    assert track.find_milestone_poses({"a": 0.0}) == {}
    track.points = [TrackPoint(float(time), state, Pose(time, 0.0, 0.0)) for time, state in enumerate("aabba")]
    assert track.states == ["a", "b"]
    times = [(state, [step.time for step in steps]) for state, steps in track.list_segments()]
    assert times == [("a", [0, 1]), ("b", [1, 2, 3]), ("a", [3, 4])]
    assert list(track.list_state_durations()) == [("a", 0.0, 2.0), ("b", 2.0, 2.0)]
    assert track.find_milestone_poses({"b": 2.2}) == {"b": Pose(2, 0.0, 0.0)}


def test_text_that_opencv_cannot_write_is_drawn_as_its_escape() -> None:
    sheets = []
    for words in ("\ud800", r"\ud800"):
        sheets.append(Canvas(100, 40, (255, 255, 255)))
        assert sheets[-1].write_text((5, 30), words, (0, 0, 0), 12) == measure_text(words, 12) > 0
    assert np.array_equal(sheets[0].render(), sheets[1].render())
