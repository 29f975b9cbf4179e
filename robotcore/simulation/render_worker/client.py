"""The run's side of a render worker: it starts the process, sends views, and takes pictures from the shared memory."""

from __future__ import annotations

import mmap
import os
import pickle
import socket
import struct
import sys
from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from subprocess import DEVNULL, Popen, TimeoutExpired

import numpy as np

from robotcore.kinds.camera import Render
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.render_worker.protocol import DONE, READY, count_bytes, pack_view
from robotcore.simulation.rigid_body import Renderer

FIRST_PICTURES = 20
"""The number of pictures that an app reads before the process starts. So a short run starts no process."""

ANSWER_S = 10
"""The longest wait for a picture, in seconds. After it, the worker counts as hung."""

CLOSING_S = 1.0
"""The longest wait for the end of the process, in seconds. After it, the process is killed."""

_MODULE = "robotcore.simulation.render_worker.process"


def has_free_core() -> bool:
    """Return whether this process may use more than one core, on a system on which a worker can run.

    OMP_NUM_THREADS=1 says that it may not. The workers of a sweep have this variable, because each has one core.
    """
    if sys.platform != "linux":
        return False
    return os.environ.get("OMP_NUM_THREADS") != "1" and len(os.sched_getaffinity(0)) > 1


class RenderWorker:
    """Renders pictures in a process of its own, while this process continues.

    The process starts with the first view. It ends with this process, also after SIGKILL. If it ends, hangs or cannot
    start, all pictures are None, and the caller renders them.

    build_renderer: builds the renderer in the process. `pickle` must be able to send it.
    """

    def __init__(self, build_renderer: Callable[[], Renderer]) -> None:
        self._build_renderer = build_renderer
        self._slots = self._slot_bytes = 0
        self._process: _Process | None = None
        self._can_start = True
        self._submitted = self._finished = 0

    def reserve(self, lens: Intrinsics, pictures: int) -> None:
        """Reserve memory for the pictures of a camera.

        pictures: the number of its pictures that are rendered or wait to be read at the same time.
        """
        self._slots += pictures
        self._slot_bytes = max(self._slot_bytes, count_bytes(lens))

    def submit(self, view: CameraView) -> int | None:
        """Let the process render the picture of a view. Return the picture's number; None if the process is not ready.

        The method does not wait.
        """
        if self._can_start:
            self._can_start = False
            with suppress(OSError, pickle.PicklingError, TypeError, AttributeError):
                self._process = _Process(self._build_renderer, self._slots, self._slot_bytes)
        if self._process is None:
            return None
        if not self._process.is_ready():
            if self._process.has_ended:
                self.close()
            return None
        if not self._process.send(pack_view(self._submitted % self._slots, view)):
            self.close()
            return None
        self._submitted += 1
        return self._submitted - 1

    def take(self, number: int, lens: Intrinsics) -> Image | None:
        """Return a picture, (height, width, 3), BGR. Wait until it is rendered.

        Return None if the process has ended, or if the picture's memory has another picture.

        number: the number from `submit`.
        lens: the intrinsics of its view.
        """
        if self._submitted - number > self._slots:
            return None
        while self._process and self._finished <= number:
            if self._process.receive():
                self._finished += 1
            else:
                self.close()
        return self._process.copy_picture(number % self._slots, lens) if self._process else None

    def close(self) -> None:
        """End the process, and start no other. Further calls do nothing."""
        self._can_start = False
        if process := self._process:
            self._process = None
            process.close()


class PictureQueue:
    """Renders the pictures of one camera in a worker, from their capture until they are read.

    The worker starts after `FIRST_PICTURES`. An app may leave pictures unread. So the worker renders the next ones only
    if the app has read one of the last.

    render: renders a picture in this process. The result is equal to the bit.
    """

    def __init__(
        self, worker: RenderWorker, render: Callable[[CameraView], Image], lens: Intrinsics, pictures: int
    ) -> None:
        """Reserve memory in the worker: see `RenderWorker.reserve`."""
        worker.reserve(lens, pictures)
        self._worker, self._render = worker, render
        self._pictures, self._unread, self._read = pictures, 0, 0

    def begin(self, view: CameraView) -> Render:
        """Let the worker render the picture of a view, and return the function that returns the picture."""
        is_wanted = self._read >= FIRST_PICTURES and self._unread < self._pictures
        number = self._worker.submit(view) if is_wanted else None
        self._unread += 1
        return partial(self._finish, view, number)

    def _finish(self, view: CameraView, number: int | None) -> Image:
        self._unread = 0
        self._read += 1
        image = None if number is None else self._worker.take(number, view.intrinsics)
        return self._render(view) if image is None else image


class _Process:
    """The process, its end of the pair of sockets, and the pictures in the shared memory."""

    def __init__(self, build_renderer: Callable[[], Renderer], slots: int, slot_bytes: int) -> None:
        """Start the process. Raises OSError if the operating system refuses it."""
        packed = pickle.dumps(build_renderer)
        self._is_ready = self.has_ended = False
        with ExitStack() as cleanup:
            file = os.memfd_create("robotcore-pictures")
            cleanup.callback(os.close, file)
            os.truncate(file, slots * slot_bytes + len(packed))
            memory = mmap.mmap(file, 0)
            memory[slots * slot_bytes :] = packed
            self._pictures = np.frombuffer(memory, np.uint8, slots * slot_bytes).reshape(slots, slot_bytes)
            self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            with theirs, ExitStack() as failure:
                failure.callback(self._link.close)
                arguments = theirs.fileno(), file, slots, slot_bytes
                code = f"import sys; sys.path[:] = {sys.path!r}; from {_MODULE} import main; main{arguments}"
                self._popen = Popen(  # noqa: S603  the Python that runs this
                    [sys.executable, "-c", code],
                    stdin=DEVNULL,
                    stdout=DEVNULL,
                    pass_fds=[theirs.fileno(), file],
                    start_new_session=True,
                )
                failure.pop_all()
        # A timeout of Python's socket would also hold for `MSG_DONTWAIT`.
        self._link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("@ll", ANSWER_S, 0))

    def is_ready(self) -> bool:
        """Return whether the process has built its renderer, without waiting."""
        if not self._is_ready:
            with suppress(OSError):
                message = self._link.recv(1, socket.MSG_DONTWAIT)
                self._is_ready, self.has_ended = message == READY, not message
        return self._is_ready

    def send(self, message: bytes) -> bool:
        """Send a message without waiting. Return False if the process has ended or reads no messages."""
        try:
            self._link.send(message, socket.MSG_DONTWAIT)
        except OSError:
            return False
        return True

    def receive(self) -> bool:
        """Wait until the process has written its next picture. Return False if it has ended or hangs."""
        try:
            return self._link.recv(1) == DONE
        except OSError:
            return False

    def copy_picture(self, slot: int, lens: Intrinsics) -> Image:
        return self._pictures[slot, : count_bytes(lens)].reshape(lens.height, lens.width, 3).copy()

    def close(self) -> None:
        self._link.close()
        try:
            self._popen.wait(CLOSING_S)
        except TimeoutExpired:
            self._popen.kill()
            self._popen.wait()
