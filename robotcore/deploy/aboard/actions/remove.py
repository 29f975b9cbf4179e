"""robotcore leaves the robot."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.aboard import incoming
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.locking import locked
from robotcore.deploy.aboard.manager import systemctl
from robotcore.deploy.aboard.telling import RefusalError

UNITS = ("robotcore.service", "robotcore-trial.service")


def act(layout: Layout, *, keeps_recordings: bool = True) -> dict[str, Any]:
    """Stop what runs, and take away all that deploys have put here; lingering stays as it is.

    What does not stop is refused, and then everything is still there. Returns whether recordings are ``kept``.
    """
    if not layout.root.exists():
        return {"removed": False, "kept": False}
    with locked(layout, "removal"):
        _stop()
        for unit in UNITS:
            layout.units.joinpath(unit).unlink(missing_ok=True)
        systemctl("daemon-reload")
        kept = _clear(layout, keeps_recordings=keeps_recordings)
    return {"removed": True, "kept": kept}


def _stop() -> None:
    """Stop and disable the services, and wait until they have: then the motors stand."""
    for unit in UNITS:
        systemctl("disable", "--now", unit)
        state = systemctl("is-active", unit).strip()
        if state in {"active", "activating", "deactivating", "reloading"}:
            raise RefusalError(f"{unit} does not stop", "Switch the robot off", "running")


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
