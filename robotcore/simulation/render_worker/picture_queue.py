"""The pictures of one camera, from their capture until they are read."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from statistics import median

from robotcore.hal.clock import Clock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.camera import Render
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.render_worker.client import RenderWorker

FIRST_PICTURES, MAX_PAUSE = 20, 640
"""The least and the greatest number of pictures that the run renders before the worker renders further ones.

The process starts after the first ones, so a short run starts no process.
"""

MAX_CREDIT = 5.0
"""The time that the worker may lose before it pauses, in pictures that the run would render in this time."""

MIN_PATIENCE_S = 0.001
"""The least time in seconds for which the run waits for a picture of the worker. After it, the run renders it."""

RECENT_PICTURES = 9
"""The number of pictures whose median time counts as the time of a picture."""


class PictureQueue:
    """Lets a worker render the pictures of a camera while that saves time. Otherwise this process renders them.

    On a busy machine, the wait for the other process can take longer than the picture. So the queue compares the wait
    with the time of a picture in this process. If the worker loses time, it pauses for `FIRST_PICTURES`, and twice as
    long at each further loss. An app may leave pictures unread. The worker renders the next ones only if the app has
    read one of the last.

    render: renders a picture in this process. The result is equal to the bit.
    clock: measures the times.
    """

    def __init__(
        self,
        worker: RenderWorker,
        render: Callable[[CameraView], Image],
        lens: Intrinsics,
        pictures: int,
        clock: Clock | None = None,
    ) -> None:
        """Reserve memory in the worker: see `RenderWorker.reserve`."""
        worker.reserve(lens, pictures)
        self._worker, self._render, self._clock = worker, render, clock or MonotonicClock()
        self._pictures, self._unread = pictures, 0
        self._pause = self._remaining_pause = FIRST_PICTURES
        self._times: deque[float] = deque(maxlen=RECENT_PICTURES)
        self._credit_s = self._own_s = 0.0

    def request(self, view: CameraView) -> Render:
        """Let the worker render the picture of a view, and return the function that returns the picture."""
        is_wanted = not self._remaining_pause and self._unread < self._pictures
        number = self._worker.submit(view) if is_wanted else None
        self._unread += 1
        return partial(self._finish, view, number)

    def _finish(self, view: CameraView, number: int | None) -> Image:
        self._unread = 0
        if number is None:
            return self._render_here(view)
        start = self._clock.now()
        image = self._worker.take(number, view.intrinsics, max(2 * self._own_s, MIN_PATIENCE_S))
        if image is None:
            image = self._render_here(view)
        self._update_credit(self._clock.now() - start)
        return image

    def _render_here(self, view: CameraView) -> Image:
        start = self._clock.now()
        image = self._render(view)
        self._times.append(self._clock.now() - start)
        self._own_s = median(self._times)
        if self._remaining_pause:
            self._remaining_pause -= 1
            self._credit_s = MAX_CREDIT * self._own_s
        return image

    def _update_credit(self, duration_s: float) -> None:
        greatest = MAX_CREDIT * self._own_s
        self._credit_s = min(self._credit_s + self._own_s - duration_s, greatest)
        if self._credit_s < 0:
            self._remaining_pause = self._pause
            self._pause = min(2 * self._pause, MAX_PAUSE)
        elif self._credit_s == greatest:
            self._pause = FIRST_PICTURES
