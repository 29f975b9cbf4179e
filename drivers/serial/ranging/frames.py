"""Splits a stream of bytes into frames of one size with a header and a short checksum."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Generic, TypeVar

FULL_BUFFER_BYTES = 4000
"""If a read returns this many bytes or more, the kernel's buffer was full and has dropped data.

Source: Linux, N_TTY_BUF_SIZE."""

FrameT = TypeVar("FrameT")


class FrameParser(ABC, Generic[FrameT]):
    """Splits a stream of bytes, which arrives in pieces of any length, into frames.

    Any part of a frame may look like a header, and a checksum of one byte does not detect all errors. So at the
    beginning and after noise, the parser accepts a frame only if another frame follows it without a gap. After that it
    accepts each frame at once. The parser stores less than two frames.
    """

    header: ClassVar[bytes]
    """The first two bytes of a frame."""
    size: ClassVar[int]
    """The number of bytes of a frame."""

    def __init__(self) -> None:
        self._rest = b""
        self._is_in_step = False

    @abstractmethod
    def parse(self, frame: bytes) -> FrameT | None:
        """Return the content of a frame that begins with the header; None if it is damaged or impossible."""

    def feed(self, data: bytes) -> list[FrameT]:
        """Parse received bytes; return the frames that these bytes complete."""
        stream, at, frames = self._rest + data, 0, list[FrameT]()
        while at + self.size <= len(stream):
            frame = self._parse_at(stream, at)
            if frame and not self._is_in_step:
                if at + 2 * self.size > len(stream):
                    break
                self._is_in_step = self._parse_at(stream, at + self.size) is not None
            if frame and self._is_in_step:
                frames.append(frame)
                at += self.size
            else:
                at = self._skip_to_header(stream, at + 1)
        self._rest = stream[at:]
        return frames

    def _parse_at(self, stream: bytes, at: int) -> FrameT | None:
        return self.parse(stream[at : at + self.size]) if stream.startswith(self.header, at) else None

    def _skip_to_header(self, stream: bytes, at: int) -> int:
        self._is_in_step = False
        found = stream.find(self.header, at)
        if found < 0:
            found = max(at, len(stream) - stream.endswith(self.header[:1]))
        return found
