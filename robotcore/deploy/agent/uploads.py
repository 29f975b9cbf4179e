"""Uploads: a folder for each push, and the process that shows whether that push is still connected."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import NAME_PATTERN

_PUSHED_BY = ".pushed-by"


def open_upload(layout: Layout, release: str) -> Path:
    """Return the folder that a release is sent to, whose name is new.

    What a broken push left is taken over, so that only the rest is sent; contents decide what that is.
    """
    folder = layout.incoming / release
    left = list(list_leftovers(layout))
    before = next((path for path in left if NAME_PATTERN.fullmatch(path.name)), None)
    for path in left:
        if path != before:
            delete(path)
    if before:
        before.rename(folder)
    folder.mkdir(exist_ok=True)
    _owner_file(layout, release).write_text(identify_connection())
    _delete_stale_owners(layout)
    return folder


def list_leftovers(layout: Layout) -> Iterator[Path]:
    """Yield the folders of pushes that broke off, the newest first, and what was to be thrown away."""
    for path in sorted(layout.incoming.glob("*"), reverse=True):
        if path.suffix != _PUSHED_BY and not is_process_alive(_read_owner(_owner_file(layout, path.name))):
            yield path


def discard_upload(layout: Layout, release: str) -> bool:
    """Throw away what was sent of a release; return whether there was anything."""
    folder = layout.incoming / release
    was_there = folder.is_dir()
    if was_there:
        discard(layout, folder)
    _owner_file(layout, release).unlink(missing_ok=True)
    return was_there


def discard(layout: Layout, folder: Path) -> None:
    """Take a folder away: out of sight in one step, so that nobody ever meets a half of it, and then for good."""
    layout.incoming.mkdir(parents=True, exist_ok=True)
    gone = layout.incoming / f"gone-{os.getpid()}-{folder.name}"
    _make_writable(folder)
    folder.rename(gone)
    delete(gone)


def delete(folder: Path) -> None:
    """Delete a folder, with what a project keeps from being written to."""
    if folder.is_symlink() or not folder.is_dir():
        folder.unlink(missing_ok=True)
        return
    for root, _, _ in os.walk(folder):
        _make_writable(Path(root))
    shutil.rmtree(folder, ignore_errors=True)


def _make_writable(folder: Path) -> None:
    if not folder.is_symlink():
        folder.chmod(folder.stat().st_mode | 0o700)


def _delete_stale_owners(layout: Layout) -> None:
    """Take away what tells of pushes whose folders are gone."""
    for owner in layout.incoming.glob(f"*{_PUSHED_BY}"):
        if not (layout.incoming / owner.stem).exists():
            owner.unlink()


def _owner_file(layout: Layout, release: str) -> Path:
    return layout.incoming / f"{release}{_PUSHED_BY}"


def _read_owner(owner: Path) -> str:
    try:
        return owner.read_text()
    except OSError:
        return ""


_PROC = Path("/proc")
_BOOT = _PROC / "sys/kernel/random/boot_id"
_CONNECTION_PROGRAMS = ("sshd", "dropbear")
"""What serves a connection calls itself so; from OpenSSH 9.8 on it is sshd-session."""


def read_boot_id() -> str:
    """Return this boot's name."""
    return _BOOT.read_text().strip()


def identify_process(pid: int) -> str:
    """Return what names a process for ever; raises OSError where there is none."""
    _, _, started = _read_process(pid)
    return f"{read_boot_id()} {pid} {started}"


def is_process_alive(named: str) -> bool:
    """Return whether the process of an identity lives."""
    try:
        return identify_process(int(named.split()[1])) == named
    except (OSError, ValueError, IndexError):
        return False


def identify_connection() -> str:
    """Return the identity of what serves the desk's connection: it lives through all calls and transfers of a push.

    Where there is no such process, that of whoever called.
    """
    served = (pid for pid in _list_ancestors() if _read_process(pid)[0].startswith(_CONNECTION_PROGRAMS))
    return identify_process(next(served, os.getppid()))


def _list_ancestors() -> Iterator[int]:
    pid = os.getppid()
    while pid > 1:
        yield pid
        pid = _read_process(pid)[1]


def _read_process(pid: int) -> tuple[str, int, str]:
    """Return a process's name, its parent, and when it was started. Source: proc(5), /proc/PID/stat."""
    name, _, rest = (_PROC / str(pid) / "stat").read_text().partition(" (")[2].rpartition(") ")
    fields = rest.split()
    return name, int(fields[1]), fields[19]
