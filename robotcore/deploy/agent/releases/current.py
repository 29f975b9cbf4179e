"""Which release is in place, which one runs, and which one was there before."""

from __future__ import annotations

from pathlib import Path

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.release import NAME
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.system import durable, session


def name_of(layout: Layout) -> str | None:
    """Return the name of the current release; None where none is, or where it is no longer there."""
    try:
        name = layout.current.readlink().name
    except OSError:
        return None
    return name if NAME.fullmatch(name) and (layout.releases / name).is_dir() else None


def swap(layout: Layout, name: str | None) -> None:
    """Make a release the current one, or none, from one moment to the next; raises OSError."""
    if name is None:
        layout.current.unlink(missing_ok=True)
        durable.settle(layout.root)
    elif name_of(layout) != name:
        durable.link(layout.current, f"{layout.releases.name}/{name}")


def note() -> Path:
    """Return where a link to the release that runs is, as long as its service is not down; systemd makes the folder.

    It is not always the current one: a swap comes first, then the restart.
    """
    return session.runtime() / "robotcore" / "release"


def running() -> str | None:
    """Return the name of the release that runs; None where none does."""
    name = note().resolve().name
    return name if NAME.fullmatch(name) else None


def names(layout: Layout) -> list[str]:
    """Return the names of all releases, the newest first."""
    return sorted((folder.name for folder in layout.releases.glob("*") if NAME.fullmatch(folder.name)), reverse=True)


def before(layout: Layout) -> str | None:
    """Return the last healthy release that is older than the current one; None where there is none."""
    now = name_of(layout)
    older = [name for name in names(layout) if now is None or name < now]
    return next((name for name in older if is_healthy(layout, name)), None)


def is_healthy(layout: Layout, name: str) -> bool:
    """Whether a release was, on its last trial."""
    verdict = Verdict.read(layout.releases / name)
    return verdict is not None and verdict.is_healthy
