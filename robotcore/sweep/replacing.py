"""Files that are there in whole or as they were before, whatever falls in between."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO


def unfinished(file: Path) -> Path:
    """Return what a file is called while it is written."""
    return file.with_name(f"{file.name}.part")


@contextmanager
def replacing(file: Path, **how: Any) -> Iterator[TextIO]:
    """Give a text file to write, in UTF-8; it takes the place of ``file`` once it is on the disk.

    ``how`` goes to `open`. Leaves nothing behind where the writing fails; an OSError is the caller's to tell.
    """
    part = unfinished(file)
    try:
        with part.open("w", encoding="utf-8", **how) as text:
            yield text
            text.flush()
            os.fsync(text.fileno())
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
