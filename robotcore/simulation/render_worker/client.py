"""The run's side of a render worker: it starts the process, sends views, and takes pictures from the shared memory."""

from __future__ import annotations

import math
import mmap
import os
import pickle
import select
import socket
import sys
from collections.abc import Callable
from contextlib import ExitStack, suppress
from subprocess import DEVNULL, Popen, TimeoutExpired

import numpy as np

from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.render_worker.protocol import READY, count_bytes, pack_view
from robotcore.simulation.rigid_body import Renderer
from robotcore.system import IS_LINUX

CLOSING_S = 1.0
"""The longest wait for the end of the process, in seconds. After it, the process is killed."""

_MODULE = "robotcore.simulation.render_worker.process"


def has_free_core() -> bool:
    """Return whether this process may use more than one core, on a system on which a worker can run.

    OMP_NUM_THREADS=1 says that it may not. The workers of a sweep have this variable, because each has one core.
    """
    if not IS_LINUX:
        return False
    return os.environ.get("OMP_NUM_THREADS") != "1" and len(os.sched_getaffinity(0)) > 1


class RenderWorker:
    """Renders pictures in a process of its own, while this process continues.

    The process starts with the first view. It ends with this process, also after SIGKILL. If it ends or cannot start,
    all pictures are None, and the caller renders them.

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
        message = pack_view(self._submitted % self._slots, view)
        if not self._receive(self._submitted - self._slots, 0.0) or not self._send(message):
            return None
        self._submitted += 1
        return self._submitted - 1

    def take(self, number: int, lens: Intrinsics, timeout_s: float) -> Image | None:
        """Return a picture, (height, width, 3), BGR. Wait until it is rendered.

        Return None if the process has ended or needs too long, or if the picture's memory has another picture.

        number: the number from `submit`.
        lens: the intrinsics of its view.
        timeout_s: the longest wait in seconds, which is rounded up to milliseconds.
        """
        is_kept = self._submitted - number <= self._slots
        if not (is_kept and self._receive(number, timeout_s) and self._process):
            return None
        return self._process.copy_picture(number % self._slots, lens)

    def _receive(self, number: int, timeout_s: float) -> bool:
        """Wait until a picture is rendered. Return False if the process has ended or needs too long."""
        try:
            while self._process and self._finished <= number:
                if not self._process.receive(timeout_s):
                    return False
                self._finished += 1
        except OSError:
            self.close()
        return self._process is not None

    def _send(self, message: bytes) -> bool:
        try:
            if self._process:
                self._process.send(message)
        except OSError:
            self.close()
        return self._process is not None

    def close(self) -> None:
        """End the process, and start no other. Further calls do nothing."""
        self._can_start = False
        if process := self._process:
            self._process = None
            process.close()


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
        self._waiting = select.poll()
        self._waiting.register(self._link, select.POLLIN)

    def is_ready(self) -> bool:
        """Return whether the process has built its renderer, without waiting."""
        if not self._is_ready:
            with suppress(OSError):
                message = self._link.recv(1, socket.MSG_DONTWAIT)
                self._is_ready, self.has_ended = message == READY, not message
        return self._is_ready

    def send(self, message: bytes) -> None:
        """Send a message without waiting. Raises OSError if the process has ended or reads no messages."""
        self._link.send(message, socket.MSG_DONTWAIT)

    def receive(self, timeout_s: float) -> bool:
        """Wait until the process has written its next picture. Return False if that takes too long.

        Raises OSError if the process has ended.
        """
        try:
            message = self._link.recv(1, socket.MSG_DONTWAIT)
        except BlockingIOError:
            if not self._waiting.poll(math.ceil(1000 * timeout_s)):
                return False
            message = self._link.recv(1, socket.MSG_DONTWAIT)
        if not message:
            raise ConnectionResetError
        return True

    def copy_picture(self, slot: int, lens: Intrinsics) -> Image:
        return self._pictures[slot, : count_bytes(lens)].reshape(lens.height, lens.width, 3).copy()

    def close(self) -> None:
        self._link.close()
        try:
            self._popen.wait(CLOSING_S)
        except TimeoutExpired:
            self._popen.kill()
            self._popen.wait()
