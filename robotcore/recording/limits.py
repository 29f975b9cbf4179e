"""Limits on the memory that a hostile MCAP file can make the reader use, and the errors of malformed bytes.

The lengths that a file states may be wrong, so the reader must check each of them.
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

A chunk of robotcore has at most 1 MiB and one more message. That message may be a picture of up to 60 MB.
"""

_PROBLEM_LENGTH = 160
"""The most characters of a problem's description in a message."""


class Allowance:
    """Limits the records, the text and the JSON values that may be read, in proportion to the bytes read so far.

    Each method raises ValueError if its limit is exceeded. The limits are about three times what robotcore writes. A
    recording has an index entry of 16 bytes for each record. For each byte of the file, the run of a robot at rest has
    4 bytes of text and 0.3 values.
    """

    MESSAGE_TEXT = 2**22
    """The most bytes of text in one message."""

    def __init__(self) -> None:
        self._records, self._text, self._values = 2**16, 2**22, 2**16

    def grow(self, read_bytes: int) -> None:
        """Raise the limits after ``read_bytes`` more bytes of the file were read."""
        self._records += read_bytes // 8
        self._text += 12 * read_bytes
        self._values += read_bytes

    def take_record(self) -> None:
        """Count a record that was read."""
        self._records -= 1
        if self._records < 0:
            raise ValueError("more records than a file of this size can have")

    def take_text(self, length: int) -> None:
        """Count ``length`` bytes of text that become objects in memory."""
        self._text -= length
        if self._text < 0 or length > self.MESSAGE_TEXT:
            raise ValueError("more text than a file of this size can have")

    def take_values(self, json_text: bytes) -> None:
        """Count the values of a JSON text by its separators and brackets. The result is never too low."""
        self._values -= sum(map(json_text.count, (b",", b"[", b"{")))
        if self._values < 0:
            raise ValueError("more values than a file of this size can have")


def format_damage(offset: int, error: BaseException) -> str:
    """Return one line with the place of a damage in the file, and its kind.

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
