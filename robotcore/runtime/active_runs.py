"""The runs that drive real motors on this machine now. `robotcore stop` finds them here.

Each run keeps a small file open in a folder that only its user can write to. The file is deleted at the end of the run.
A file that its process does not have open is left over from a killed run.
"""

from __future__ import annotations

import json
import os
import signal
import stat
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotcore.description import is_own
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import find_holders
from robotcore.system import IS_LINUX, require_linux

FOLDER = "robotcore-runs"
"""The name of the folder of the files, in the user's runtime folder or in the temporary folder."""

KILL_S = 2.0
"""The longest wait for the end of a killed process, in s."""

_POLL_S = 0.02


@dataclass(frozen=True)
class ActiveRun:
    """A run that drives real motors, and the data with which another process can stop them."""

    process: int
    """The PID of the run's process."""
    backend: str
    robot: str
    """The name of a robot description, or the absolute path of its file."""
    options: Mapping[str, Any]
    """The backend's options, by name."""
    file: Path
    """The file of the run, which exists until the robot is closed."""

    @property
    def is_running(self) -> bool:
        """Whether the run's process still has the file of the run open."""
        return self.process in find_holders(str(self.file))

    def send(self, *signals: signal.Signals) -> None:
        """Send signals to the run's process. A process that has ended is ignored."""
        with suppress(OSError):
            for each in signals:
                os.kill(self.process, each)


def end_runs(runs: Sequence[ActiveRun], limit_s: float) -> list[ActiveRun]:
    """End runs: send SIGTERM to all of them at once, so that each stops its motors and closes its robot.

    A run that has not ended within the limit is killed. Its guardian, if it has one, then stops the motors.

    limit_s: the longest wait for the ends of all runs, in s.

    Returns the runs that had to be killed.
    """
    for run in runs:
        # A suspended process does not handle SIGTERM before it continues.
        run.send(signal.SIGTERM, signal.SIGCONT)
    killed = _wait_for_ends(runs, limit_s)
    for run in killed:
        run.send(signal.SIGKILL)
    _wait_for_ends(killed, KILL_S)
    return killed


def _wait_for_ends(runs: Sequence[ActiveRun], limit_s: float) -> list[ActiveRun]:
    """Wait until no run is active. Return the runs that are still active after the limit, in s."""
    clock = MonotonicClock()
    while (active := [run for run in runs if run.is_running]) and clock.now() < limit_s:
        clock.sleep_until(clock.now() + _POLL_S)
    return active


@contextmanager
def register_run(backend: str, robot: str, options: Mapping[str, Any]) -> Iterator[None]:
    """Register a run of this process as active until the end of the ``with`` block.

    Raises OSError if the file of the run cannot be written, or if the system has no ``/proc``.
    """
    if not IS_LINUX:
        raise OSError("this operating system has no /proc, in which a stop finds the process of the run")
    process = os.getpid()
    place = os.path.abspath(robot) if is_own(robot) else robot  # noqa: PTH100  it keeps symbolic links
    with tempfile.NamedTemporaryFile("w", dir=_make_folder(), suffix=".json", encoding="utf-8", delete=False) as file:
        try:
            json.dump(
                {"process": process, "backend": backend, "robot": place, "options": dict(options)}, file, default=str
            )
            file.flush()
            yield
        finally:
            if os.getpid() == process:  # a forked app may end here too
                with suppress(OSError):
                    Path(file.name).unlink()


def list_active_runs() -> list[ActiveRun]:
    """Return this user's active runs on this machine. The files of killed runs are deleted.

    Raises UnsupportedSystemError on a system without ``/proc``.
    """
    remedy = "Name the robot: robotcore stop --backend serial --robot FILE.toml"
    require_linux("robotcore stop without --backend", "the list of processes in /proc", remedy)
    files = [file for folder in _list_folders() if _is_private(folder) for file in sorted(folder.glob("*.json"))]
    return [run for file in files if (run := _read(file))]


def _read(file: Path) -> ActiveRun | None:
    with suppress(OSError, ValueError, TypeError):  # the run has just ended, or has not written its file yet
        run = ActiveRun(**json.loads(file.read_text(encoding="utf-8")), file=file)
        if run.process in find_holders(str(file)):
            return run
        file.unlink()
    return None


def _make_folder() -> Path:
    """Return the first folder for the files of runs that exists or can be made. Raises OSError if there is none."""
    *others, last = _list_folders()
    for folder in others:
        with suppress(OSError):
            return _make_private(folder)
    return _make_private(last)


def _make_private(folder: Path) -> Path:
    folder.mkdir(mode=0o700, exist_ok=True)
    if not _is_private(folder):
        raise PermissionError(f"{folder} belongs to another user, or other users can write to it")
    return folder


def _list_folders() -> list[Path]:
    """Return the possible folders. The first one does not exist for a system service, so a stop checks both."""
    user = os.getuid()
    runtime = Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{user}")
    return [runtime / FOLDER, Path(tempfile.gettempdir(), f"{FOLDER}-{user}")]


def _is_private(folder: Path) -> bool:
    try:
        status = folder.lstat()
    except OSError:
        return False
    is_writable = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not is_writable
