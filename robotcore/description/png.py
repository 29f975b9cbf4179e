"""Decode PNG pictures from untrusted sources.

Source: Portable Network Graphics, third edition, https://www.w3.org/TR/png-3/.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from robotcore.errors import Mistake

Pixels = NDArray[np.uint8]

MAX_PIXELS = 2**22
"""The greatest number of pixels of a picture. The header of a small file can state any size."""

MAX_SIDE_PX = 10**6
"""The greatest number of pixels along a side of a picture. It is the limit of libpng, which decodes the picture."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHUNK, _CHECKSUM, _SIZE = struct.Struct(">I4s"), struct.Struct(">I"), struct.Struct(">II")
_COLOUR_TYPE_AT, _GREY = 25, 0


def decode_png(content: bytes) -> Pixels:
    """Return the picture of a PNG file, (height, width, 4): blue, green, red and opacity, from 0 to 255.

    Raises Mistake if the content is not an intact PNG, is grey with a transparent grey, has more than `MAX_PIXELS`
    pixels, or more than `MAX_SIDE_PX` along a side.
    """
    import cv2

    _require_intact(content)
    width, height = _SIZE.unpack_from(content, len(_SIGNATURE) + _CHUNK.size)
    if width * height > MAX_PIXELS:
        problem = f"the picture has {width} x {height} pixels, and the limit is {MAX_PIXELS} pixels"
        raise Mistake(problem, "Scale the picture down", kind="too-many-pixels")
    if max(width, height) > MAX_SIDE_PX:
        problem = f"the picture has {width} x {height} pixels, and the limit of a side is {MAX_SIDE_PX} pixels"
        raise Mistake(problem, "Cut or scale the picture", kind="too-long-side")
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    if picture is None or picture.shape[:2] != (height, width):
        raise _build_damage_mistake()
    if picture.dtype == np.uint16:
        picture = (picture // 256).astype(np.uint8)
    conversions = {1: cv2.COLOR_GRAY2BGRA, 3: cv2.COLOR_BGR2BGRA}
    channels = 1 if picture.ndim < 3 else picture.shape[2]
    return np.asarray(cv2.cvtColor(picture, conversions[channels]) if channels in conversions else picture, np.uint8)


def _require_intact(content: bytes) -> None:
    """Raise Mistake unless the content has all chunks of a PNG with their checksums, and no transparent grey.

    OpenCV prints lines for a file that is cut, and some versions return a part of the picture.
    """
    if not content.startswith(_SIGNATURE):
        raise Mistake("the picture is not a PNG", "Convert it to PNG", kind="not-png")
    at, kind = len(_SIGNATURE), b""
    while kind != b"IEND":
        is_first = not kind
        if at + _CHUNK.size > len(content):
            raise _build_damage_mistake()
        length, kind = _CHUNK.unpack_from(content, at)
        end = at + _CHUNK.size + length
        if end + _CHECKSUM.size > len(content) or (is_first and (kind != b"IHDR" or length < _SIZE.size)):
            raise _build_damage_mistake()
        (checksum,) = _CHECKSUM.unpack_from(content, end)
        if zlib.crc32(content[at + 4 : end]) != checksum:
            raise _build_damage_mistake()
        if kind == b"tRNS" and content[_COLOUR_TYPE_AT] == _GREY:  # OpenCV would return this grey as opaque.
            problem = "the picture is grey, and one of its greys is transparent"
            raise Mistake(problem, "Save it as PNG in RGB with opacity", kind="transparent-grey")
        at = end + _CHECKSUM.size


def _build_damage_mistake() -> Mistake:
    return Mistake("the picture is cut or damaged", "Save it as PNG again", kind="damaged-png")
