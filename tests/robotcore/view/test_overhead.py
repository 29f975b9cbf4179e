"""Tracks, and texts on a canvas."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.geometry import Pose
from robotcore.view.canvas import Canvas, measure_text
from robotcore.view.overhead import Track, TrackPoint


@pytest.fixture
def track() -> Track:
    track = Track()
    track.points = [TrackPoint(float(time), state, Pose(time, 0.0, 0.0)) for time, state in enumerate("aabba")]
    return track


def test_states_are_in_the_order_of_their_first_occurrence(track: Track) -> None:
    assert track.states == ["a", "b"]


def test_segments_join_without_a_gap(track: Track) -> None:
    times = [(state, [step.time for step in steps]) for state, steps in track.list_segments()]
    assert times == [("a", [0, 1]), ("b", [1, 2, 3]), ("a", [3, 4])]


def test_the_duration_of_a_state_is_that_of_all_its_segments(track: Track) -> None:
    assert list(track.list_state_durations()) == [("a", 0.0, 2.0), ("b", 2.0, 2.0)]


def test_a_milestone_has_the_pose_of_its_time(track: Track) -> None:
    assert track.find_milestone_poses({"b": 2.2}) == {"b": Pose(2, 0.0, 0.0)}


def test_an_empty_track_has_no_milestones() -> None:
    assert Track().find_milestone_poses({"a": 0.0}) == {}


def test_text_that_opencv_cannot_write_is_drawn_as_its_escape() -> None:
    sheets = []
    for words in ("\ud800", r"\ud800"):
        sheets.append(Canvas(100, 40, (255, 255, 255)))
        assert sheets[-1].write_text((5, 30), words, (0, 0, 0), 12) == measure_text(words, 12) > 0
    assert np.array_equal(sheets[0].render(), sheets[1].render())
