from __future__ import annotations

from robotcore.hal.devices import Frame
from robotcore.view.recorded import story_of
from tests.robotcore.recording.replay.memory import recorded


def test_a_replay_that_ends_early_has_seen_no_more_than_what_came_by_then() -> None:
    recording = recorded("green-search", seed=3, timeout_s=0.5)
    pictures = []
    for tick in (recording.ticks[1], recording.ticks[-1]):
        key = tick.shown[-1].key
        assert key
        shown = recording.samples[key]
        assert isinstance(shown, Frame)
        pictures.append(shown.image)
    assert story_of(recording, states=["search"] * 2).seen is pictures[0]
    assert story_of(recording).seen is pictures[1] is not pictures[0]
