"""What encoders on pins have in common."""

from __future__ import annotations

import threading
from contextlib import ExitStack

from drivers.raspberrypi.encoders.encoder import PinEncoder
from robotcore.hal.devices import Angle
from robotcore.hal.wall_clock import MonotonicClock

AGES_S = 10.0
"""A thread that has not come by then never will."""

OVERTAKES_S = 0.05
"""A thread that nothing holds up has come by then."""


class SlowCounter:
    """Is held up when it is asked for the first time."""

    def __init__(self) -> None:
        self.asked, self.release = threading.Event(), threading.Event()

    @property
    def edges(self) -> int:
        if not self.asked.is_set():
            self.asked.set()
            self.release.wait(AGES_S)
        return 0


def test_threads_that_read_at_once_get_samples_of_one_row() -> None:
    clock, counter, samples = MonotonicClock(), SlowCounter(), list[Angle]()
    encoder = PinEncoder("left_encoder", clock, counter, 4, ExitStack())
    threads = [threading.Thread(target=lambda: samples.append(encoder.read())) for _ in range(2)]
    threads[0].start()
    assert counter.asked.wait(AGES_S)
    threads[1].start()
    threads[1].join(OVERTAKES_S)
    counter.release.set()
    for thread in threads:
        thread.join(AGES_S)
    clock.close()
    assert [sample.sequence for sample in sorted(samples, key=lambda sample: sample.time)] == [0, 1]
