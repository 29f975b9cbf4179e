from __future__ import annotations

import pytest

from robotcore.kinds.range_sensor import Range
from robotcore.recording.complete_ticks import CompleteTicks
from robotcore.recording.events import Read, SampleKey
from robotcore.recording.tap import TickEvents


@pytest.mark.parametrize("dropped_until_s, begin_s", [(0.0, 3.0), (1.0, 3.0), (2.0, 5.0), (5.0, 6.0), (9.0, 9.0)])
def test_a_ring_begins_with_the_first_tick_that_has_all_its_samples(dropped_until_s: float, begin_s: float) -> None:
    ticks, sample = CompleteTicks(), Range(1.0, time=0.0, sequence=0)
    new = {0: [0], 2: [1], 5: [2]}
    for number, reads in enumerate([[0], [0], [0, 1], [1], [1], [2], []]):
        events = TickEvents(reads=[Read("nose", number=each) for each in reads])
        events.samples += [(SampleKey("nose", each), sample) for each in new.get(number, [])]
        ticks.add(float(number), events, None)
    assert ticks.find_begin(dropped_until_s) == begin_s
