"""The program that systemd starts on the robot, and the calls of a release's own robotcore.

``run`` starts the app, ``off`` stops the motors after it, ``trial`` checks the health of a new release.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path

from robotcore.deploy.agent import files, releases
from robotcore.deploy.agent.files import Layout, measure_free_space
from robotcore.deploy.agent.releases import ENVIRONMENT, PROJECT, SITE, Release
from robotcore.deploy.agent.rpc import AgentError

FAILED, UNUSABLE = 1, 2
"""Exit statuses: what may be well the next time, such as a card's reading, and what systemd does not try again."""


def main(arguments: Sequence[str] = tuple(sys.argv[1:]), layout: Layout | None = None) -> int:
    """Do what systemd asks for; return the exit status."""
    works: dict[str, Callable[[Layout], int]] = {"run": run_app, "off": stop_motors, "trial": run_health_check}
    try:
        return works[arguments[0]](layout or Layout(Path.home()))
    except FileNotFoundError as error:
        return _print_fault(f"{error.filename}: {error.strerror}. Push again")
    except OSError as error:
        _print_fault(f"{error.filename}: {error.strerror}. Look at the disk there; or push again")
        return FAILED
    except (AgentError, ValueError, KeyError, TypeError) as error:
        return _print_fault(str(error))


def run_app(layout: Layout) -> int:
    """Become the app of the current release; return only where that cannot be.

    The release itself is run, not what ``current`` points to: a swap changes nothing for a process that runs.
    """
    folder = layout.current.resolve()
    release = Release.read(folder)
    files.replace_link(releases.find_running_link(), str(folder))
    called = build_launch(folder, *release.run, *_build_record_options(layout, release))
    print(f"release {release.name}: {release.app} on {release.backend}", flush=True)  # noqa: T201 - into the journal
    os.chdir(called.folder)
    os.execve(called.command[0], called.command, called.environment)  # noqa: S606 - no shell is wanted


def stop_motors(layout: Layout) -> int:
    """Let the motors of the release that ran stand; return the exit status of what did."""
    note = releases.find_running_link()
    folder = (note if note.exists() else layout.current).resolve()
    if not folder.is_dir():
        return 0
    release = Release.read(folder)
    if not release.stop:
        return 0
    called = build_launch(folder, *release.stop)
    done = subprocess.run(  # noqa: S603 - no shell
        called.command, cwd=called.folder, env=called.environment, capture_output=True, text=True, check=False
    )
    return _print_fault(f"the motors may still turn: {done.stderr or done.stdout}") if done.returncode else 0


def run_health_check(layout: Layout) -> int:
    """Judge the release that is on trial; where the robot goes down meanwhile, systemd starts no more for us.

    What this needs is imported here: whatever is wrong with it keeps no app from running, and no motor from standing.
    """
    from robotcore.deploy.agent.health_check import ShutdownError, run_check

    try:
        run_check(layout)
    except ShutdownError as error:
        return _print_fault(str(error))
    return 0


def _build_record_options(layout: Layout, release: Release) -> tuple[str, ...]:
    """Return the arguments that record a run, in a file that is not there yet, and in half of the free room at most.

    A robot that is left alone for days must not fill its disk.
    """
    if not release.is_recorded:
        return ()
    layout.recordings.mkdir(exist_ok=True)
    began = time.strftime("%Y-%m-%dT%H-%M-%SZ", time.gmtime())
    paths = (layout.recordings / f"{began}{again}.mcap" for again in chain([""], map("-{}".format, count(2))))
    path = next(path for path in paths if not path.exists())
    return ("--record", str(path), "--record-limit", str(max(1, measure_free_space(layout.home) // 2)))


def _print_fault(fault: str) -> int:
    print(f"robotcore: {fault}", file=sys.stderr)  # noqa: T201 - into the journal
    return UNUSABLE


ROBOTCORE_ARGUMENTS = (
    "-c",
    (
        "import sys; sys.path[:] = [each for each in sys.path if each]; "
        "import runpy; runpy.run_module('robotcore', run_name='__main__', alter_sys=True)"
    ),
)
"""Arguments of Python's: ``-m robotcore`` that looks for no module in the working folder, so that no ``drivers`` of a
project's is taken for ours. Python has a variable for that from 3.11 on, too late."""


@dataclass(frozen=True)
class Launch:
    """A command of robotcore's, ready for a process."""

    command: tuple[str, ...]
    folder: Path
    environment: dict[str, str]


def build_launch(release: Path, *arguments: str) -> Launch:
    """Return how robotcore is called in a release's folder."""
    python = release / ENVIRONMENT / "bin" / "python"
    kept_apart = {"PYTHONPATH": str(release / SITE), "PYTHONNOUSERSITE": "1"}
    return Launch((str(python), *ROBOTCORE_ARGUMENTS, *arguments), release / PROJECT, {**os.environ, **kept_apart})
