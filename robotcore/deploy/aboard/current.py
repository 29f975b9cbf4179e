"""Which release is the one that runs: where the link ``current`` points to."""

from __future__ import annotations

from robotcore.deploy.aboard import durable
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.release import NAME


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
