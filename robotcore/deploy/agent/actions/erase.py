"""Delete recordings on the robot that the desk already has, compared by SHA-256."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robotcore.deploy.agent.actions.recordings import open_files
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.system.digest import sha256
from robotcore.deploy.agent.telling import say


def act(layout: Layout, *, recordings: Mapping[str, str]) -> dict[str, Any]:
    """Delete recordings whose content is what the desk has: their names, each with its SHA-256.

    Returns those that were ``erased``, and those that are ``different``. One that is being written, and what is no
    plain file, stays.
    """
    written = open_files()
    erased, different = [], []
    for name, digest in recordings.items():
        path = layout.recordings / name
        if (
            path.parent != layout.recordings
            or path.is_symlink()
            or not path.is_file()
            or str(path.resolve()) in written
        ):
            continue
        say(f"comparing {name}")
        if sha256(path) == digest:
            path.unlink()
            erased.append(name)
        else:
            different.append(name)
    return {"erased": erased, "different": different}
