"""Limits on the memory that the reader uses for an MCAP file, and the errors of malformed files.

A file may be hostile: each length in it may be wrong.
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
"""The exceptions that reading a malformed chunk can raise."""

MAX_RECORD_BYTES = 2**26
"""The maximum size of a record, packed or unpacked, in bytes.

A chunk that robotcore wrote has at most 1 MiB plus its last message, which may be a picture of up to 60 MB.
"""

_PROBLEM_LENGTH = 160


class Allowance:
    """Limits the records, the text and the JSON values of a file, in proportion to the bytes that were read.

    The methods named ``take_`` raise ValueError if a limit is exceeded. The limits are about three times what robotcore
    writes for a robot at rest: an index entry of 16 bytes for each record, 4 bytes of text and 0.3 JSON values for each
    byte of the file.
    """

    MESSAGE_TEXT = 2**22
    """The maximum text in one message, in bytes."""

    def __init__(self) -> None:
        self._records, self._text, self._values = 2**16, 2**22, 2**16

    def grow(self, read_bytes: int) -> None:
        """Raise the limits, because ``read_bytes`` more bytes of the file were read."""
        self._records += read_bytes // 8
        self._text += 12 * read_bytes
        self._values += read_bytes

    def take_record(self) -> None:
        """Count one record."""
        self._records -= 1
        if self._records < 0:
            raise ValueError("the file has too many records for its size")

    def take_text(self, length: int) -> None:
        """Count ``length`` bytes of text."""
        self._text -= length
        if self._text < 0 or length > self.MESSAGE_TEXT:
            raise ValueError("the file has too much text for its size")

    def take_values(self, json_text: bytes) -> None:
        """Count the values of a JSON text, or more: a comma or bracket inside a string counts too."""
        self._values -= sum(map(json_text.count, (b",", b"[", b"{")))
        if self._values < 0:
            raise ValueError("the file has too many JSON values for its size")


def format_damage(offset: int, error: BaseException) -> str:
    """Return the place and the problem of damaged bytes in one line, such as ``byte 1024, the checksum is wrong``.

    offset: the place in the file, in bytes.
    """
    problem = str(error)
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        problem = ": ".join(filter(None, (".".join(map(str, first["loc"])), first["msg"])))
    elif isinstance(error, MemoryError):
        problem = "there is not enough memory"
    elif not problem or isinstance(error, LookupError):
        problem = f"{type(error).__name__} {problem}".strip()
    return f"byte {offset}, {escape(problem[:_PROBLEM_LENGTH])}"
