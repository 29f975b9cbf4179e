"""What is being sent: a folder for each push, and what says whether that push still lives."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.release import NAME
from robotcore.deploy.agent.system import process

_PUSHED_BY = ".pushed-by"


def open_for(layout: Layout, release: str) -> Path:
    """Return the folder that a release is sent to, whose name is new.

    What a broken push left is taken over, so that only the rest is sent; contents decide what that is.
    """
    folder = layout.incoming / release
    left = list(leftovers(layout))
    before = next((path for path in left if NAME.fullmatch(path.name)), None)
    for path in left:
        if path != before:
            erase(path)
    if before:
        before.rename(folder)
    folder.mkdir(exist_ok=True)
    _owner(layout, release).write_text(process.connection())
    _drop_owners(layout)
    return folder


def leftovers(layout: Layout) -> Iterator[Path]:
    """Yield the folders of pushes that broke off, the newest first, and what was to be thrown away."""
    for path in sorted(layout.incoming.glob("*"), reverse=True):
        if path.suffix != _PUSHED_BY and not process.is_alive(_said(_owner(layout, path.name))):
            yield path


def forget(layout: Layout, release: str) -> bool:
    """Throw away what was sent of a release; return whether there was anything."""
    folder = layout.incoming / release
    was_there = folder.is_dir()
    if was_there:
        throw_away(layout, folder)
    _owner(layout, release).unlink(missing_ok=True)
    return was_there


def throw_away(layout: Layout, folder: Path) -> None:
    """Take a folder away: out of sight in one step, so that nobody ever meets a half of it, and then for good."""
    layout.incoming.mkdir(parents=True, exist_ok=True)
    gone = layout.incoming / f"gone-{os.getpid()}-{folder.name}"
    _let_move(folder)
    folder.rename(gone)
    erase(gone)


def erase(folder: Path) -> None:
    """Delete a folder, with what a project keeps from being written to."""
    if folder.is_symlink() or not folder.is_dir():
        folder.unlink(missing_ok=True)
        return
    for root, _, _ in os.walk(folder):
        _let_move(Path(root))
    shutil.rmtree(folder, ignore_errors=True)


def _let_move(folder: Path) -> None:
    if not folder.is_symlink():
        folder.chmod(folder.stat().st_mode | 0o700)


def _drop_owners(layout: Layout) -> None:
    """Take away what tells of pushes whose folders are gone."""
    for owner in layout.incoming.glob(f"*{_PUSHED_BY}"):
        if not (layout.incoming / owner.stem).exists():
            owner.unlink()


def _owner(layout: Layout, release: str) -> Path:
    return layout.incoming / f"{release}{_PUSHED_BY}"


def _said(owner: Path) -> str:
    try:
        return owner.read_text()
    except OSError:
        return ""
