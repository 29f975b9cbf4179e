"""Uploads: the folders that receive the files of pushes, and the check whether such a push is still connected."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import NAME_PATTERN

_PUSHED_BY = ".pushed-by"

_PROC = Path("/proc")
_CONNECTION_PROGRAMS = ("sshd", "dropbear")
"""The beginnings of the names of programs that serve an ssh connection, such as ``sshd-session`` of OpenSSH 9.8."""


def open_upload(layout: Layout, release: str) -> Path:
    """Create the folder for the upload of a release, and return its path.

    After an interrupted push, the function renames the newest folder of such a push instead. rsync then sends only the
    missing files.
    """
    folder = layout.incoming / release
    leftovers = [path for path in sorted(layout.incoming.iterdir(), reverse=True) if not _is_in_use(path)]
    before = next((path for path in leftovers if NAME_PATTERN.fullmatch(path.name)), None)
    for path in leftovers:
        if path != before:
            delete(path)
    if before:
        before.rename(folder)
    folder.mkdir(exist_ok=True)
    _owner_file(folder).write_text(identify_connection())
    return folder


def _is_in_use(path: Path) -> bool:
    """Return whether the push that made a folder or its owner's file is still connected."""
    owner = path if path.suffix == _PUSHED_BY else _owner_file(path)
    try:
        return is_process_alive(owner.read_text())
    except OSError:  # without an owner's file, or after another process has deleted it
        return False


def discard_upload(layout: Layout, release: str) -> bool:
    """Delete the upload of a release. Return whether such an upload existed. The caller must hold the lock."""
    folder = layout.incoming / release
    was_there = folder.is_dir()
    if was_there:
        discard(layout, folder)
    _owner_file(folder).unlink(missing_ok=True)
    return was_there


def discard(layout: Layout, folder: Path) -> None:
    """Rename a folder, then delete it, so that no other process uses a partly deleted folder."""
    layout.incoming.mkdir(parents=True, exist_ok=True)
    renamed = layout.incoming / f"gone-{os.getpid()}-{folder.name}"
    _make_writable(folder)
    folder.rename(renamed)
    delete(renamed)


def delete(folder: Path) -> None:
    """Delete a file, a link, or a folder with all its files, even in read-only folders."""
    if folder.is_symlink() or not folder.is_dir():
        folder.unlink(missing_ok=True)
        return
    for root, _, _ in os.walk(folder):
        _make_writable(Path(root))
    shutil.rmtree(folder, ignore_errors=True)


def _make_writable(folder: Path) -> None:
    if not folder.is_symlink():
        folder.chmod(folder.stat().st_mode | 0o700)


def _owner_file(folder: Path) -> Path:
    return folder.with_name(folder.name + _PUSHED_BY)


def identify_process(pid: int) -> str:
    """Return a text that identifies a process uniquely: boot, process number, and start time.

    Raises OSError if there is no process of this number.
    """
    boot = (_PROC / "sys/kernel/random/boot_id").read_text().strip()
    return f"{boot} {pid} {_read_process(pid)[2]}"


def is_process_alive(identity: str) -> bool:
    """Return whether the process with this identity runs. ``identity`` is the result of `identify_process`."""
    try:
        return identify_process(int(identity.split()[1])) == identity
    except (OSError, ValueError, IndexError):
        return False


def identify_connection() -> str:
    """Return the identity of the process that serves the client's ssh connection, or else of the parent process.

    This process runs as long as the push is connected.
    """
    servers = (pid for pid in _list_ancestors() if _read_process(pid)[0].startswith(_CONNECTION_PROGRAMS))
    return identify_process(next(servers, os.getppid()))


def _list_ancestors() -> Iterator[int]:
    pid = os.getppid()
    while pid > 1:
        yield pid
        pid = _read_process(pid)[1]


def _read_process(pid: int) -> tuple[str, int, str]:
    """Return a process's name, the number of its parent, and its start time in clock ticks. Source: proc(5)."""
    name, _, rest = (_PROC / str(pid) / "stat").read_text().partition(" (")[2].rpartition(") ")
    fields = rest.split()
    return name, int(fields[1]), fields[19]
