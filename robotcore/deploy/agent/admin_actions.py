"""Actions on stored files: list releases and recordings, erase recordings, remove robotcore from the robot."""

from __future__ import annotations

import os
import stat
from collections.abc import Container, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from robotcore.deploy.agent import health_check, releases, run_actions, uploads
from robotcore.deploy.agent import systemctl as systemd
from robotcore.deploy.agent.files import Layout, hash_file
from robotcore.deploy.agent.lock import hold_lock
from robotcore.deploy.agent.releases import HealthResult, Release
from robotcore.deploy.agent.rpc import report_progress
from robotcore.deploy.agent.systemd_units import UNIT_TEXTS, list_installed_units


def list_releases(layout: Layout) -> dict[str, Any]:
    """Return the ``releases``, the newest first, with the names of two of them, ``current`` and ``on_trial``.

    ``on_trial`` is the release whose health check is pending or running, or None. Each release has the fields of its
    manifest, and the ``verdict`` and ``reason`` of its last health check. ``verdict`` is None if there was no check. A
    release with an unreadable manifest has only its ``name`` and ``unreadable``, the cause.
    """
    pending = health_check.read_pending(layout)
    return {
        "releases": [_describe_release(layout, name) for name in releases.list_names(layout)],
        "current": releases.read_current(layout),
        "on_trial": pending.release if pending else None,
    }


def _describe_release(layout: Layout, name: str) -> dict[str, Any]:
    folder = layout.releases / name
    try:
        row = asdict(Release.read(folder))
    except (OSError, ValueError, KeyError, TypeError) as error:
        row = {"name": name, "unreadable": str(error)}
    result = HealthResult.read(folder)
    return {**row, "verdict": result.outcome if result else None, "reason": result.reason if result else ""}


def list_recordings(layout: Layout) -> dict[str, Any]:
    """Return the ``recordings``, each with ``name``, ``bytes``, ``is_file`` and ``is_being_written``.

    ``is_file`` is False for links, folders and devices. They are listed so that the client can report that it does not
    fetch them. Empty files are not listed, because a run on a full disk leaves them.
    """
    open_files = find_open_files()
    listed = [_describe_recording(path, open_files) for path in sorted(layout.recordings.glob("*"))]
    return {"recordings": [each for each in listed if each["bytes"] or each["is_being_written"] or not each["is_file"]]}


def find_open_files() -> set[str]:
    """Return the paths of all files that processes of this user have open."""
    return set(_walk_open_files())


def _describe_recording(path: Path, open_files: Container[str]) -> dict[str, Any]:
    status = path.lstat()
    return {
        "name": os.fsencode(path.name).decode(errors="backslashreplace"),
        "bytes": status.st_size,
        "is_file": stat.S_ISREG(status.st_mode),
        "is_being_written": str(path.resolve()) in open_files,
    }


def _walk_open_files() -> Iterator[str]:
    for process in Path("/proc").glob("[0-9]*/fd"):
        with suppress(OSError):
            for handle in process.iterdir():
                with suppress(OSError):
                    yield str(handle.readlink())


def erase_recordings(layout: Layout, *, recordings: Mapping[str, str]) -> dict[str, Any]:
    """Delete each of these recordings from the robot if its content equals that of the client's copy.

    A recording that a process is still writing is not deleted. Links, folders and devices are not deleted either.

    recordings: the SHA-256 of the client's copy in hex, by the recording's name.
    Returns the names of the ``erased`` recordings, and of those whose content is ``different``.
    """
    open_files = find_open_files()
    erased, different = [], []
    for name, digest in recordings.items():
        path = layout.recordings / name
        if (
            path.parent != layout.recordings
            or path.is_symlink()
            or not path.is_file()
            or str(path.resolve()) in open_files
        ):
            continue
        report_progress(f"comparing {name}")
        if hash_file(path) == digest:
            path.unlink()
            erased.append(name)
        else:
            different.append(name)
    return {"erased": erased, "different": different}


def remove_robotcore(layout: Layout, *, keeps_recordings: bool = True) -> dict[str, Any]:
    """Stop the app and delete everything that deploys have put on the robot.

    The setting of lingering stays as it is. If the app does not stop, AgentError is raised, and nothing is deleted.
    Returns ``removed``, whether anything was deleted, and ``kept``, whether recordings remain on the robot.
    """
    units = list_installed_units(layout)
    if not units and not layout.root.exists():
        return {"removed": False, "kept": False}
    if len(units) == len(UNIT_TEXTS):  # if some are missing, an earlier removal has stopped the app
        run_actions.stop_app(layout)
    with hold_lock(layout, "removal"):
        _remove_units(units)
        kept = _clear_folder(layout, keeps_recordings=keeps_recordings)
    return {"removed": True, "kept": kept}


def _remove_units(units: list[Path]) -> None:
    for unit in units:
        systemd.disable(unit.name)
        unit.unlink()
    if units:
        systemd.reload_units()


def _clear_folder(layout: Layout, *, keeps_recordings: bool) -> bool:
    layout.current.unlink(missing_ok=True)
    kept = keeps_recordings and any(layout.recordings.glob("*"))
    for path in layout.root.iterdir():
        if path not in {layout.lock, layout.incoming} and not (kept and path == layout.recordings):
            uploads.discard(layout, path)
    uploads.delete(layout.incoming)
    layout.lock.unlink()
    if not kept:
        layout.root.rmdir()
    return bool(kept)
