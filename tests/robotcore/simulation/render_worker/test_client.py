"""The worker: pictures, their memory, and what happens if the process hangs or ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from robotcore.description import load_world
from robotcore.optics import CameraView, Image
from robotcore.simulation.body_cameras import PaintedRenderer
from robotcore.simulation.render_worker import RenderWorker, client, has_free_core
from robotcore.simulation.rigid_body import Renderer
from robotcore.sweep.worker import WorkerProcess
from tests.robotcore.simulation.render_worker.renderers import (
    DIES,
    HANGS,
    LENS,
    SLOW,
    BrokenRenderer,
    PlainRenderer,
    build_view,
)

pytestmark = [pytest.mark.slow, pytest.mark.linux("a worker needs Linux")]
PICTURES = 3
LONG_S = 30.0


@contextmanager
def open_worker(build_renderer: Callable[[], Renderer] = PlainRenderer) -> Iterator[RenderWorker]:
    worker = RenderWorker(build_renderer)
    worker.reserve(LENS, PICTURES)
    try:
        yield worker
    finally:
        worker.close()


def submit_when_ready(worker: RenderWorker, view: CameraView) -> int:
    """Submit a view until the process is ready, and return the picture's number."""
    for _ in range(3000):
        if (number := worker.submit(view)) is not None:
            return number
        time.sleep(0.01)
    raise AssertionError("the process is not ready after 30 s")


def get_level(image: Image | None) -> int:
    assert image is not None
    (level,) = np.unique(image).tolist()
    return int(level)


def get_process(worker: RenderWorker) -> int:
    assert worker._process
    return worker._process._popen.pid


def is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_for_end(process: int) -> bool:
    """Return whether a process ends within 20 seconds."""
    for _ in range(2000):
        if not is_running(process):
            return True
        time.sleep(0.01)
    return False


def test_pictures_can_be_taken_in_any_order() -> None:
    with open_worker() as worker:
        numbers = [submit_when_ready(worker, build_view(x)) for x in (7, 8, 9)]
        levels = [get_level(worker.take(numbers[at], LENS, LONG_S)) for at in (1, 0, 2)]
    assert levels == [8, 7, 9]


def test_a_picture_stays_the_same_after_later_pictures() -> None:
    with open_worker() as worker:
        first = worker.take(submit_when_ready(worker, build_view(1)), LENS, LONG_S)
        for x in range(2, 9):
            worker.take(submit_when_ready(worker, build_view(x)), LENS, LONG_S)
    assert get_level(first) == 1


def test_the_first_view_does_not_wait_for_the_process() -> None:
    with open_worker() as worker:
        assert worker.submit(build_view(1)) is None


def test_a_picture_whose_memory_has_a_later_one_is_not_returned() -> None:
    with open_worker() as worker:
        numbers = [submit_when_ready(worker, build_view(x)) for x in range(PICTURES + 1)]
        assert worker.take(numbers[0], LENS, LONG_S) is None
        assert get_level(worker.take(numbers[-1], LENS, LONG_S)) == PICTURES


def test_a_painted_picture_of_another_process_is_equal() -> None:
    build = partial(PaintedRenderer, load_world("arena"))
    with open_worker(build) as worker:
        view = build_view(0)
        image = worker.take(submit_when_ready(worker, view), LENS, LONG_S)
    assert image is not None
    assert np.array_equal(image, build().picture(view))


@pytest.mark.parametrize("name", ["SIGKILL", "SIGTERM", "SIGSEGV"])
def test_after_the_end_of_the_process_there_are_no_pictures_and_no_other_process(name: str) -> None:
    with open_worker() as worker:
        submit_when_ready(worker, build_view(1))
        process = get_process(worker)
        os.kill(process, signal.Signals[name])
        assert wait_for_end(process)
        late = worker.submit(build_view(2))  # a thread of the process may still hold its socket
        assert late is None or worker.take(late, LENS, LONG_S) is None
        assert worker.submit(build_view(3)) is None
        assert worker._process is None


def test_a_process_that_ends_while_it_renders_gives_no_picture() -> None:
    with open_worker() as worker:
        assert worker.take(submit_when_ready(worker, build_view(DIES)), LENS, LONG_S) is None


def test_a_process_that_hangs_gives_no_picture_and_is_killed_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "CLOSING_S", 0.1)
    with open_worker() as worker:
        number = submit_when_ready(worker, build_view(HANGS))
        process = get_process(worker)
        assert worker.take(number, LENS, 0.01) is None
        assert is_running(process)
    assert not is_running(process)


def test_a_late_picture_can_be_taken_later_and_the_next_ones_are_right() -> None:
    with open_worker() as worker:
        numbers = [submit_when_ready(worker, build_view(x)) for x in (SLOW, 5)]
        assert worker.take(numbers[0], LENS, 0.01) is None
        assert get_level(worker.take(numbers[1], LENS, LONG_S)) == 5
        assert get_level(worker.take(numbers[0], LENS, LONG_S)) == SLOW % 256


def test_a_process_that_is_late_gets_no_more_views_than_its_memory_has_pictures() -> None:
    with open_worker() as worker:
        for x in (SLOW, *range(1, PICTURES)):
            submit_when_ready(worker, build_view(x))
        assert worker.submit(build_view(9)) is None
        assert get_level(worker.take(submit_when_ready(worker, build_view(9)), LENS, LONG_S)) == 9


def test_a_renderer_that_cannot_be_built_gives_no_picture() -> None:
    with open_worker(BrokenRenderer) as worker:
        assert worker.submit(build_view(1)) is None
        assert wait_for_end(get_process(worker))
        assert worker.submit(build_view(1)) is None


def test_a_process_that_the_system_refuses_gives_no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **_options: object) -> None:
        raise OSError("too many processes")

    monkeypatch.setattr(client, "Popen", refuse)
    with open_worker() as worker:
        assert worker.submit(build_view(1)) is None
        assert worker.submit(build_view(1)) is None


def test_closing_ends_the_process() -> None:
    with open_worker() as worker:
        submit_when_ready(worker, build_view(1))
        process = get_process(worker)
    assert not is_running(process)
    assert worker.submit(build_view(1)) is None


PROGRAM = """
import os, sys, time
from tests.robotcore.simulation.render_worker.test_client import build_view, get_process, open_worker, submit_when_ready
with open_worker() as worker:
    submit_when_ready(worker, build_view(1))
    if sys.argv[1] == "fork" and not os.fork():
        time.sleep(60)
    print(get_process(worker), flush=True)
    time.sleep(60)
"""


@pytest.mark.parametrize("way", ["alone", "fork"])
def test_the_process_ends_with_a_run_that_is_killed(way: str) -> None:
    with subprocess.Popen([sys.executable, "-c", PROGRAM, way], stdout=subprocess.PIPE, start_new_session=True) as run:
        assert run.stdout
        process = int(run.stdout.readline())
        assert is_running(process)
        run.kill()
        assert wait_for_end(process)
        if way == "fork":
            os.killpg(run.pid, signal.SIGKILL)


@pytest.mark.parametrize(
    "cores, threads, is_free", [({0, 1}, None, True), ({0, 1}, "2", True), ({1}, None, False), ({0, 1}, "1", False)]
)
def test_a_worker_needs_a_second_core(
    cores: set[int], threads: str | None, is_free: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: cores)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    if threads:
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
    assert has_free_core() is is_free


def test_a_run_of_a_sweep_has_no_free_core() -> None:
    worker = WorkerProcess()
    try:
        assert worker.call(has_free_core, limit_s=60.0) is False
    finally:
        worker.close()
