"""The decision which process renders a picture, with a stepped clock and a worker without a process."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.hal.clock import SteppedClock
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.render_worker import PictureQueue, RenderWorker
from robotcore.simulation.render_worker.picture_queue import FIRST_PICTURES, MAX_PAUSE
from tests.robotcore.simulation.render_worker.renderers import LENS, PlainRenderer, build_view

PICTURES = 3
OWN_S = 0.010
"""The time of a picture in this process, in seconds."""


class FakeWorker(RenderWorker):
    """A worker whose pictures take ``wait_s`` at reading. None: it has no picture, after the patience of the run."""

    def __init__(self, clock: SteppedClock) -> None:
        super().__init__(PlainRenderer)
        self._clock = clock
        self.views: list[CameraView] = []
        self.wait_s: float | None = 0.001
        self.is_ready = True

    def submit(self, view: CameraView) -> int | None:
        if not self.is_ready:
            return None
        self.views.append(view)
        return len(self.views) - 1

    def take(self, number: int, lens: Intrinsics, timeout_s: float) -> Image | None:
        self._clock.sleep_until(self._clock.now() + (timeout_s if self.wait_s is None else self.wait_s))
        return None if self.wait_s is None else PlainRenderer().picture(self.views[number])


class Bench:
    """A queue, its worker, and the x of the views that this process has rendered."""

    def __init__(self) -> None:
        self.clock = SteppedClock(1000, lambda steps: None)
        self.worker = FakeWorker(self.clock)
        self.here: list[int] = []
        self.queue = PictureQueue(self.worker, self._render, LENS, PICTURES, self.clock)

    def _render(self, view: CameraView) -> Image:
        self.clock.sleep_until(self.clock.now() + OWN_S)
        self.here.append(int(view.eye[0]))
        return PlainRenderer().picture(view)

    def read(self, pictures: int) -> int:
        """Capture and read pictures, check them, and return how many of them this process rendered."""
        before = len(self.here)
        for number in range(pictures):
            x = number % 256
            assert np.unique(self.queue.request(build_view(x))()).tolist() == [x]
        return len(self.here) - before


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_the_run_renders_the_first_pictures(bench: Bench) -> None:
    assert bench.read(FIRST_PICTURES) == FIRST_PICTURES
    assert not bench.worker.views
    assert bench.read(100) == 0
    assert len(bench.worker.views) == 100


def test_the_run_renders_while_the_process_starts(bench: Bench) -> None:
    bench.worker.is_ready = False
    assert bench.read(FIRST_PICTURES + 7) == FIRST_PICTURES + 7
    bench.worker.is_ready = True
    assert bench.read(5) == 0


def test_pictures_that_no_app_reads_are_not_rendered(bench: Bench) -> None:
    bench.read(FIRST_PICTURES)
    renders = [bench.queue.request(build_view(x)) for x in range(10)]
    assert len(bench.worker.views) == PICTURES
    renders[-1]()
    assert bench.here[-1] == 9
    bench.queue.request(build_view(11))
    assert len(bench.worker.views) == PICTURES + 1


def test_a_worker_that_is_slower_than_the_run_pauses_for_longer_and_longer(bench: Bench) -> None:
    bench.read(FIRST_PICTURES)
    bench.worker.wait_s = 3 * OWN_S
    bench.read(5 * MAX_PAUSE)
    assert len(bench.worker.views) < 5 * MAX_PAUSE / 50


def test_a_worker_that_answers_too_late_costs_little(bench: Bench) -> None:
    bench.read(FIRST_PICTURES)
    bench.worker.wait_s = None
    start = bench.clock.now()
    pictures = 5 * MAX_PAUSE
    assert bench.read(pictures) == pictures
    assert bench.clock.now() - start < 1.1 * pictures * OWN_S


def test_a_worker_that_becomes_fast_again_renders_again(bench: Bench) -> None:
    bench.worker.wait_s = None
    bench.read(200)
    bench.worker.wait_s = 0.1 * OWN_S
    bench.read(MAX_PAUSE)
    assert bench.read(100) == 0
    bench.worker.wait_s = None
    bench.read(5)
    bench.worker.wait_s = 0.1 * OWN_S
    bench.read(FIRST_PICTURES + 10)
    assert bench.read(10) == 0
