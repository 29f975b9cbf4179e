"""Whether there is room for recordings."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

from robotcore.hal.finding import Finding

WHAT = "disk"
ENOUGH_GB, LEAST_GB = 2.0, 0.2
"""A recording with pictures takes up to a gigabyte in an hour; with nothing free the system itself stops working."""

REMEDY = "Delete old recordings; sudo apt clean"


def disk(root: Path) -> Iterator[Finding]:
    """Look how much is free where the system is."""
    free = shutil.disk_usage(root).free / 1e9
    said = f"{free:.1f} GB are free"
    if free < LEAST_GB:
        yield Finding.error(WHAT, said, REMEDY)
    elif free < ENOUGH_GB:
        yield Finding.warning(WHAT, said, REMEDY)
    else:
        yield Finding.ok(WHAT, said)
