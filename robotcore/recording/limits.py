"""Limits on what a hostile MCAP file makes the reader do, and the errors of malformed bytes.

Each length in a file is only a claim.
"""

from __future__ import annotations

import struct

from mcap.exceptions import McapError
from pydantic import ValidationError
from zstandard import ZstdError

from robotcore.text import escape

DAMAGE = (
    *(McapError, ZstdError, struct.error, ValueError, LookupError, OverflowError),
    *(RecursionError, MemoryError),
)
"""The errors that malformed bytes can raise while a chunk is read."""

MAX_RECORD_BYTES = 2**26
"""The most bytes of one record, packed or unpacked.

A chunk of robotcore has 1 MiB and one more message, for example a picture of at most 60 MB.
"""

_PROBLEM_LENGTH = 160
"""The most characters of a problem in a message."""


class Allowance:
    """Limits the records, the text and the JSON values that may be read, in proportion to the bytes read so far.

    Each method raises ValueError if its limit is exceeded. A recording of robotcore has an index entry of 16 bytes for
    each record. With its index, a run that stands still has 4 bytes of text and 0.3 values for each byte. Each limit
    leaves room for about three times as much.
    """

    MESSAGE_TEXT = 2**22
    """The most bytes of text in one message."""

    def __init__(self) -> None:
        self._records, self._text, self._values = 2**16, 2**22, 2**16

    def grow(self, read_bytes: int) -> None:
        """Raise the limits, after ``read_bytes`` more bytes were read."""
        self._records += read_bytes // 8
        self._text += 12 * read_bytes
        self._values += read_bytes

    def take_record(self) -> None:
        """Count a record."""
        self._records -= 1
        if self._records < 0:
            raise ValueError("more records than a file of this size can have")

    def take_text(self, length: int) -> None:
        """Count ``length`` bytes of text that become objects in memory."""
        self._text -= length
        if self._text < 0 or length > self.MESSAGE_TEXT:
            raise ValueError("more text than a file of this size can have")

    def take_values(self, json_text: bytes) -> None:
        """Count the values of a JSON text by its separators and brackets. The count is never too low."""
        self._values -= sum(map(json_text.count, (b",", b"[", b"{")))
        if self._values < 0:
            raise ValueError("more values than a file of this size can have")


def format_damage(offset: int, error: BaseException) -> str:
    """Return the place and the kind of a damage as one line.

    offset: the place in the file, in bytes.
    """
    problem = str(error)
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        problem = ": ".join(filter(None, (".".join(map(str, first["loc"])), first["msg"])))
    elif isinstance(error, MemoryError):
        problem = "there is not enough memory for it"
    elif not problem or isinstance(error, LookupError):
        problem = f"{type(error).__name__} {problem}".strip()
    return f"byte {offset}, {escape(problem[:_PROBLEM_LENGTH])}"
