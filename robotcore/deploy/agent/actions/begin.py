"""A push begins: room, and a folder to send to."""

from __future__ import annotations

import time
from calendar import timegm
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current, incoming, pruning
from robotcore.deploy.agent.releases.release import NAME, TIME, require_name
from robotcore.deploy.agent.system import disk
from robotcore.deploy.agent.system.locking import locked
from robotcore.deploy.agent.telling import RefusalError

SPARE = 100_000_000
"""Bytes that stay free: with none the system itself stops working."""


def act(layout: Layout, *, release: str, size: int) -> dict[str, Any]:
    """Make room for so many bytes; return the ``release``'s name, where it goes (``to``), and the folder to copy from.

    It is named as the desk asks for, by the time there, or by the second after the newest that is here: no two pushes
    share a name, and names sort in the order of pushing, whatever a desk's clock tells. Both folders are below the
    robot's own folder; ``copy_from`` is None where there is none. Raises RefusalError where there is too little room,
    though what nobody needs was thrown away; then nothing is left of this push.
    """
    with locked(layout, f"push of {require_name(release)}"):
        for room in (layout.incoming, layout.releases, layout.recordings):
            room.mkdir(parents=True, exist_ok=True)
        pruning.prune(layout, keep=1 if _lacks(layout, size) else pruning.KEPT)
        release = _named(layout, release)
        folder = incoming.open_for(layout, release)
        if short := _lacks(layout, size - disk.size_of(folder)):
            incoming.forget(layout, release)
            raise _refusal(layout, size, short)
        before = current.name_of(layout) or next(iter(current.names(layout)), None)
    return {"release": release, "to": f"incoming/{release}", "copy_from": f"releases/{before}" if before else None}


def _named(layout: Layout, asked: str) -> str:
    there = [*current.names(layout), *(path.name for path in layout.incoming.glob("*") if NAME.fullmatch(path.name))]
    newest = max(there, default="")
    return asked if asked > newest else time.strftime(TIME, time.gmtime(timegm(time.strptime(newest, TIME)) + 1))


def _lacks(layout: Layout, size: int) -> int:
    """Return how many bytes are missing."""
    return max(0, size + SPARE - disk.free_bytes(layout.root))


def _refusal(layout: Layout, size: int, short: int) -> RefusalError:
    recorded = disk.size_of(layout.recordings)
    fault = f"the robot's disk is full: {disk.in_words(size)} are to be sent, {disk.in_words(short)} are missing"
    take = f"recordings take {disk.in_words(recorded)}; robotcore deploy fetch --move takes them home"
    remedy = f"Make room there: {take if recorded else 'what takes it is told by df -h and du -xh ~ | sort -h'}"
    return RefusalError(fault, remedy, "disk")
