"""robotcore leaves the robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from robotcore.deploy.agent.actions import stop
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import incoming
from robotcore.deploy.agent.service import systemd
from robotcore.deploy.agent.service.units import TEXTS, installed
from robotcore.deploy.agent.system.locking import locked


def act(layout: Layout, *, keeps_recordings: bool = True) -> dict[str, Any]:
    """Stop what runs, and take away all that deploys have put here; lingering stays as it is.

    Where it does not stop, RefusalError is raised, and all is still there. Returns whether there was anything to be
    ``removed``, and whether recordings are ``kept``.
    """
    units = installed(layout)
    if not units and not layout.root.exists():
        return {"removed": False, "kept": False}
    if len(units) == len(TEXTS):  # else somebody was killed over this, after all was stopped
        stop.act(layout)
    with locked(layout, "removal"):
        _take_away(units)
        kept = _clear(layout, keeps_recordings=keeps_recordings)
    return {"removed": True, "kept": kept}


def _take_away(units: list[Path]) -> None:
    for unit in units:
        systemd.disable(unit.name)
        unit.unlink()
    if units:
        systemd.reload()


def _clear(layout: Layout, *, keeps_recordings: bool) -> bool:
    layout.current.unlink(missing_ok=True)
    kept = keeps_recordings and any(layout.recordings.glob("*"))
    for path in layout.root.iterdir():
        if path not in {layout.lock, layout.incoming} and not (kept and path == layout.recordings):
            incoming.throw_away(layout, path)
    incoming.erase(layout.incoming)
    layout.lock.unlink()
    if not kept:
        layout.root.rmdir()
    return bool(kept)
