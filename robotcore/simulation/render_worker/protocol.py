"""The messages between a run and its render worker, over a pair of sockets that keep the boundaries of messages.

The run sends a message for each picture: the number of its slot and its view. The worker writes the picture to this
slot of the memory that both share, and answers with `DONE`. It renders the pictures in the order of the messages.
"""

from __future__ import annotations

import pickle
import struct
from functools import lru_cache

import numpy as np

from robotcore.optics import CameraView, Intrinsics

READY = b"r"
"""The message of the worker after it has built its renderer."""

DONE = b"d"
"""The message of the worker after it has written a picture."""

MAX_BYTES = 4096
"""The greatest length of a message."""

_HEAD = struct.Struct("=I12d")


def pack_view(slot: int, view: CameraView) -> bytes:
    """Return the message for a picture."""
    return _HEAD.pack(slot, *view.eye.tolist(), *view.rotation.ravel().tolist()) + _pack_lens(view.intrinsics)


def unpack_view(message: bytes) -> tuple[int, CameraView]:
    """Return the slot and the view of a message of `pack_view`."""
    slot, *numbers = _HEAD.unpack_from(message)
    lens = _unpack_lens(message[_HEAD.size :])
    return slot, CameraView(lens, np.array(numbers[:3]), np.array(numbers[3:]).reshape(3, 3))


def count_bytes(lens: Intrinsics) -> int:
    """Return the number of bytes of a picture."""
    return lens.height * lens.width * 3


@lru_cache(maxsize=8)
def _pack_lens(lens: Intrinsics) -> bytes:
    return pickle.dumps(lens)


@lru_cache(maxsize=8)
def _unpack_lens(packed: bytes) -> Intrinsics:
    lens: Intrinsics = pickle.loads(packed)  # noqa: S301  from the run that started this process
    return lens
