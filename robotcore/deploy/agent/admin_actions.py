"""Actions on stored files: list releases and recordings, erase recordings, remove robotcore from the robot."""

from __future__ import annotations

import os
import stat
import subprocess
from collections.abc import Container, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from robotcore.deploy.agent import health_check, releases, run_actions, uploads
from robotcore.deploy.agent import systemctl as systemd
from robotcore.deploy.agent.files import Layout, hash_file, hold_lock, locate_segments
from robotcore.deploy.agent.releases import HealthResult, Release
from robotcore.deploy.agent.rpc import report_progress
from robotcore.deploy.agent.service import build_launch
from robotcore.deploy.agent.systemd_units import UNIT_TEXTS, list_installed_units


def list_releases(layout: Layout) -> dict[str, Any]:
    """Return the releases, the newest first, see `robot_answers.ReleasesAnswer`."""
    pending = health_check.read_pending(layout)
    return {
        "releases": [_describe_release(layout, name) for name in releases.list_names(layout)],
        "current": releases.read_current(layout),
        "pending": pending.release if pending else None,
    }


def _describe_release(layout: Layout, name: str) -> dict[str, Any]:
    folder = layout.releases / name
    try:
        row = Release.read(folder).to_fields()
    except (OSError, ValueError) as error:
        row = {"name": name, "unreadable": str(error)}
    result = HealthResult.read(folder)
    return {**row, "outcome": result.outcome if result else None, "reason": result.reason if result else ""}


def list_recordings(layout: Layout) -> dict[str, Any]:
    """Return the entries of the folder of recordings, see `robot_answers.RecordingsAnswer`.

    The list also has links, folders and devices, so that the client can report that it does not fetch them. It has no
    empty files, which a run on a full disk leaves, and no segments of recordings that are being written.
    """
    open_files = _find_open_files()
    _finish_recordings(layout, open_files)
    hidden = {locate_segments(Path(file)) for file in open_files if Path(file).name}  # the root folder has no name
    paths = (path for path in sorted(layout.recordings.glob("*")) if path.resolve() not in hidden)
    listed = [_describe_recording(path, open_files) for path in paths]
    return {"recordings": [each for each in listed if each["bytes"] or each["is_being_written"] or not each["is_file"]]}


def _finish_recordings(layout: Layout, open_files: Container[str]) -> None:
    """Join the segments that killed runs have left, with the robotcore of the current release.

    A recording whose segments cannot be joined stays as it is.
    """
    for path in sorted(layout.recordings.glob("*.mcap")):
        is_left = locate_segments(path).is_dir() and str(path.resolve()) not in open_files
        if is_left and layout.current.exists():
            report_progress(f"finishing {path.name}")
            launch = build_launch(layout.current.resolve(), "info", "--json", str(path))
            with suppress(OSError):
                subprocess.run(  # noqa: S603  no shell
                    launch.command, cwd=launch.folder, env=launch.environment, capture_output=True, check=False
                )


def _describe_recording(path: Path, open_files: Container[str]) -> dict[str, Any]:
    status = path.lstat()
    return {
        "name": os.fsencode(path.name).decode(errors="backslashreplace"),
        "bytes": status.st_size,
        "is_file": stat.S_ISREG(status.st_mode),
        "is_being_written": str(path.resolve()) in open_files,
    }


def _find_open_files() -> set[str]:
    """Return the paths of all files that are open in processes of this user."""
    found = set()
    for process in Path("/proc").glob("[0-9]*/fd"):
        with suppress(OSError):
            for handle in process.iterdir():
                with suppress(OSError):
                    found.add(str(handle.readlink()))
    return found


def erase_recordings(layout: Layout, *, recordings: Mapping[str, str]) -> dict[str, Any]:
    """Delete each of these recordings if its content equals the client's copy. See `robot_answers.EraseAnswer`.

    The function does not delete a recording that a process is still writing. It deletes no link, folder or device.

    recordings: the SHA-256 of the client's copy in hex, by the recording's name.
    """
    open_files = _find_open_files()
    erased, different = [], []
    for name, digest in recordings.items():
        path = layout.recordings / name
        is_closed_file = path.is_file() and not path.is_symlink() and str(path.resolve()) not in open_files
        if path.parent != layout.recordings or not is_closed_file:
            continue
        report_progress(f"comparing {name}")
        if hash_file(path) == digest:
            path.unlink()
            erased.append(name)
        else:
            different.append(name)
    return {"erased": erased, "different": different}


def remove_robotcore(layout: Layout, *, keeps_recordings: bool = True) -> dict[str, Any]:
    """Stop the app, and delete all files that deploys have put on the robot. See `robot_answers.RemoveAnswer`.

    The function does not change the user's lingering. It raises AgentError and deletes nothing if the app does not
    stop.
    """
    units = list_installed_units(layout)
    if not units and not layout.root.exists():
        return {"removed": False, "has_recordings": False}
    if len(units) == len(UNIT_TEXTS):  # if some are missing, an earlier removal has stopped the app
        run_actions.stop_app(layout)
    with hold_lock(layout, "removal"):
        for unit in units:
            systemd.systemctl("disable", unit.name)
            unit.unlink()
        if units:
            systemd.systemctl("daemon-reload")
        has_recordings = _clear_folder(layout, keeps_recordings=keeps_recordings)
    return {"removed": True, "has_recordings": has_recordings}


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
