"""The process that renders pictures for a run."""

from __future__ import annotations

import mmap
import os
import pickle
from contextlib import suppress
from socket import socket
from typing import NoReturn

import numpy as np

from robotcore.simulation.render_worker.protocol import DONE, MAX_BYTES, READY, count_bytes, unpack_view

PARENT_CHECK_S = 1.0
"""The time between two checks whether the run's process exists, in seconds.

Usually the end of its socket ends the worker. A process that the run has forked may keep the socket open.
"""


def main(handle: int, memory_file: int, slots: int, slot_bytes: int) -> NoReturn:
    """Render the views that the run sends, until the run ends. An error is written on stderr, and ends the process.

    handle: the file descriptor of the worker's end of the pair of sockets.
    memory_file: the file descriptor of the shared memory: the slots, and then the pickled function that builds the
        renderer.
    """
    status = 0
    try:
        with suppress(OSError):  # the run has ended
            _serve(socket(fileno=handle), mmap.mmap(memory_file, 0), slots, slot_bytes)
    except Exception as error:  # noqa: BLE001  the run renders the pictures itself
        status = 1
        os.write(2, f"note: the run renders its pictures itself, because {type(error).__name__}: {error}\n".encode())
    finally:
        os._exit(status)  # without the output of libraries at exit, such as that of OpenGL


def _serve(link: socket, memory: mmap.mmap, slots: int, slot_bytes: int) -> None:
    import cv2

    cv2.setNumThreads(1)
    parent = os.getppid()
    render = pickle.loads(memory[slots * slot_bytes :])().picture  # noqa: S301  from the run that started this process
    pictures = np.frombuffer(memory, np.uint8, slots * slot_bytes).reshape(slots, slot_bytes)
    link.send(READY)
    link.settimeout(PARENT_CHECK_S)
    while os.getppid() == parent:
        with suppress(TimeoutError):
            if not (message := link.recv(MAX_BYTES)):
                return
            slot, view = unpack_view(message)
            pictures[slot, : count_bytes(view.intrinsics)] = render(view).ravel()
            link.send(DONE)
