"""Times that tell contents apart: a file changed in a second and of the same size is seen, a fresh checkout is not."""

from __future__ import annotations

import os
from hashlib import sha256
from pathlib import Path

FIRST = 631_152_000
"""1990 began, in seconds of Unix time; so much later at most, 17 years, no file is from the future."""

SPAN = 2**29


def stamp(folder: Path) -> None:
    """Give each file below a time made of what is in it, in whole seconds.

    rsync, and Python of what it has compiled, take a file of the same size and time for the same. Links keep theirs.
    """
    for place, _, files in os.walk(folder):
        for file in (Path(place, name) for name in files):
            if not file.is_symlink():
                digest = sha256(file.read_bytes()).digest()
                time = FIRST + int.from_bytes(digest[:8], "big") % SPAN
                os.utime(file, (time, time))
