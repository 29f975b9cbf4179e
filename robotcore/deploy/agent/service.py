"""The program that systemd starts on the robot. It runs the robotcore in the release's folder.

The command ``run`` starts the app. ``off`` stops the motors after the app has ended. ``health-check`` runs
the health check of a new release.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from calendar import timegm
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent import files, releases
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, locate_segments, measure_free_space
from robotcore.deploy.agent.releases import ENVIRONMENT, PROJECT, SITE, Release

FAILED, UNUSABLE = 1, 2
"""Exit statuses of this program.

systemd starts the program again after ``FAILED``, such as a read error, but not after ``UNUSABLE``, such as an invalid
release.
"""

KEPT_RECORDINGS = 20
"""The number of recordings on the robot if recordings keep only the end of their runs."""

MIN_RING_BYTES, MAX_RING_BYTES = 10_000_000, 500_000_000
"""The least size limit of such a recording that robotcore accepts, and the greatest that this program sets, in bytes.

The recording is copied once at its end, and systemd waits a minute for that.
"""

_RECORDING_NAME = "%Y-%m-%dT%H-%M-%SZ.mcap"

ROBOTCORE_ARGUMENTS = (
    "-c",
    (
        "import sys; sys.path[:] = [each for each in sys.path if each]; "
        "import runpy; runpy.run_module('robotcore', run_name='__main__', alter_sys=True)"
    ),
)
"""The arguments of Python that run robotcore as ``-m robotcore`` does, but without modules of the working folder.

A folder ``drivers`` of the project would hide robotcore's package of that name. Only Python 3.11 and later have an
environment variable for this.
"""


@dataclass(frozen=True)
class Launch:
    """A command line that runs the robotcore of a release, with its working folder and its environment variables."""

    command: tuple[str, ...]
    folder: Path
    environment: dict[str, str]


def build_launch(release: Path, *arguments: str) -> Launch:
    """Return the command line that runs the robotcore of a release.

    release: the release's folder.
    arguments: the arguments of robotcore.
    """
    python = release / ENVIRONMENT / "bin" / "python"
    isolation = {"PYTHONPATH": str(release / SITE), "PYTHONNOUSERSITE": "1"}
    return Launch((str(python), *ROBOTCORE_ARGUMENTS, *arguments), release / PROJECT, {**os.environ, **isolation})


def main(arguments: Sequence[str] = tuple(sys.argv[1:]), layout: Layout | None = None) -> int:
    """Run the command ``run``, ``off`` or ``health-check`` that systemd passes, and return the exit status."""
    commands: dict[str, Callable[[Layout], int]] = {
        "run": run_app,
        "off": stop_motors,
        "health-check": run_health_check,
    }
    try:
        return commands[arguments[0]](layout or Layout(Path.home()))
    except FileNotFoundError as error:
        return _print_error(f"{error.filename}: {error.strerror}. Push again")
    except OSError as error:
        _print_error(f"{error.filename}: {error.strerror}. Check the disk of the robot, or push again")
        return FAILED
    except (AgentError, ValueError) as error:
        return _print_error(str(error))


def run_app(layout: Layout) -> int:
    """Replace this process by the app of the current release. Return only after a failure.

    The working folder is the release's own folder, so that a change of the link ``current`` does not affect the app.
    """
    folder = layout.current.resolve()
    release = Release.read(folder)
    files.replace_link(releases.find_running_link(), str(folder))
    launch = build_launch(folder, *release.run, *_build_record_options(layout, release))
    print(f"release {release.name}: {release.app} on {release.backend}", flush=True)  # noqa: T201 - into the journal
    os.chdir(launch.folder)
    os.execve(launch.command[0], launch.command, launch.environment)  # noqa: S606 - no shell is wanted


def stop_motors(layout: Layout) -> int:
    """Stop the motors with the release whose app has ended. Return the exit status."""
    running = releases.find_running_link()
    folder = (running if running.exists() else layout.current).resolve()
    if not folder.is_dir():
        return 0
    release = Release.read(folder)
    if not release.stop:
        return 0
    launch = build_launch(folder, *release.stop)
    done = subprocess.run(  # noqa: S603 - no shell
        launch.command, cwd=launch.folder, env=launch.environment, capture_output=True, text=True, check=False
    )
    return _print_error(f"the motors may still turn: {done.stderr or done.stdout}") if done.returncode else 0


def run_health_check(layout: Layout) -> int:
    """Run the pending health check to its end. Return the exit status."""
    # an import error in this module must not affect the other commands
    from robotcore.deploy.agent.health_check import ShutdownError, run_check

    try:
        run_check(layout)
    except ShutdownError as error:
        return _print_error(str(error))
    return 0


def _build_record_options(layout: Layout, release: Release) -> tuple[str, ...]:
    """Return the arguments that record a run into a new file, which may take at most half of the free space.

    If recordings keep only the end of their runs, the oldest recordings are deleted first.

    The name of the file is the time, or the second after the newest recording if the clock has gone back. A Raspberry
    Pi without a real-time clock starts in the past, and the name must not make the newest recording the oldest one.
    """
    if not release.is_recorded:
        return ()
    layout.recordings.mkdir(exist_ok=True)
    starts = _list_starts(layout)
    if release.record_last:
        _delete_recordings(layout, starts[: 1 - KEPT_RECORDINGS])
    path = layout.recordings / _name_recording(max([int(time.time()), *(start + 1 for start in starts[-1:])]))
    limit = max(1, measure_free_space(layout.home) // 2)
    if not release.record_last or limit < MIN_RING_BYTES:
        return ("--record", str(path), "--record-limit", str(limit))
    ring = ("--record-last", release.record_last, "--record-limit", str(min(limit, MAX_RING_BYTES)))
    return ("--record", str(path), *ring)


def _name_recording(start: int) -> str:
    """Return the name of a recording that starts at a Unix time in s."""
    return time.strftime(_RECORDING_NAME, time.gmtime(start))


def _list_starts(layout: Layout) -> list[int]:
    """Return the times in the names of the recordings, the oldest first. Files with other names do not count."""
    starts = []
    for path in layout.recordings.glob("*.mcap"):
        with suppress(ValueError):
            start = timegm(time.strptime(path.name, _RECORDING_NAME))
            if _name_recording(start) == path.name:
                starts.append(start)
    return sorted(starts)


def _delete_recordings(layout: Layout, starts: Sequence[int]) -> None:
    for path in (layout.recordings / _name_recording(start) for start in starts):
        with suppress(OSError):  # the app must start anyway
            path.unlink()
            shutil.rmtree(locate_segments(path), ignore_errors=True)


def _print_error(text: str) -> int:
    print(f"robotcore: {text}", file=sys.stderr)  # noqa: T201 - into the journal
    return UNUSABLE
