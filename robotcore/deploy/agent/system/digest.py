"""What a file holds, in a few characters."""

from __future__ import annotations

import hashlib
from pathlib import Path

PIECE = 1 << 20


def sha256(file: Path) -> str:
    """Return a file's SHA-256 in hex; it may be larger than the memory."""
    digest = hashlib.sha256()
    with file.open("rb") as content:
        while piece := content.read(PIECE):
            digest.update(piece)
    return digest.hexdigest()
