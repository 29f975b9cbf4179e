"""What systemd starts on the robot: the app (``run``), motors off after it (``off``), and a release's ``trial``."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from itertools import chain, count
from pathlib import Path

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.release import Release
from robotcore.deploy.agent.service import launch
from robotcore.deploy.agent.system import durable
from robotcore.deploy.agent.system.disk import free_bytes
from robotcore.deploy.agent.telling import RefusalError

FAILED, UNUSABLE = 1, 2
"""Exit statuses: what may be well the next time, such as a card's reading, and what systemd does not try again."""


def main(arguments: Sequence[str] = tuple(sys.argv[1:]), layout: Layout | None = None) -> int:
    """Do what systemd asks for; return the exit status."""
    works: dict[str, Callable[[Layout], int]] = {"run": run, "off": off, "trial": trial}
    try:
        return works[arguments[0]](layout or Layout(Path.home()))
    except FileNotFoundError as error:
        return _tell(f"{error.filename}: {error.strerror}. Push again")
    except OSError as error:
        _tell(f"{error.filename}: {error.strerror}. Look at the disk there; or push again")
        return FAILED
    except (RefusalError, ValueError, KeyError, TypeError) as error:
        return _tell(str(error))


def run(layout: Layout) -> int:
    """Become the app of the current release; return only where that cannot be.

    The release itself is run, not what ``current`` points to: a swap changes nothing for a process that runs.
    """
    folder = layout.current.resolve()
    release = Release.read(folder)
    durable.link(current.note(), str(folder))
    called = launch.robotcore(folder, *release.run, *_recorded(layout, release))
    print(f"release {release.name}: {release.app} on {release.backend}", flush=True)  # noqa: T201 - into the journal
    os.chdir(called.folder)
    os.execve(called.command[0], called.command, called.environment)  # noqa: S606 - no shell is wanted


def off(layout: Layout) -> int:
    """Let the motors of the release that ran stand; return the exit status of what did."""
    note = current.note()
    folder = (note if note.exists() else layout.current).resolve()
    if not folder.is_dir():
        return 0
    release = Release.read(folder)
    if not release.stop:
        return 0
    called = launch.robotcore(folder, *release.stop)
    done = subprocess.run(  # noqa: S603 - no shell
        called.command, cwd=called.folder, env=called.environment, capture_output=True, text=True, check=False
    )
    return _tell(f"the motors may still turn: {done.stderr or done.stdout}") if done.returncode else 0


def trial(layout: Layout) -> int:
    """Judge the release that is on trial; where the robot goes down meanwhile, systemd starts no more for us.

    What this needs is imported here: whatever is wrong with it keeps no app from running, and no motor from standing.
    """
    from robotcore.deploy.agent.trial.trial import conduct
    from robotcore.deploy.agent.trial.watching import LeavingError

    try:
        conduct(layout)
    except LeavingError as error:
        return _tell(str(error))
    return 0


def _recorded(layout: Layout, release: Release) -> tuple[str, ...]:
    """Return the arguments that record a run, in a file that is not there yet, and in half of the free room at most.

    A robot that is left alone for days must not fill its disk.
    """
    if not release.is_recorded:
        return ()
    layout.recordings.mkdir(exist_ok=True)
    began = time.strftime("%Y-%m-%dT%H-%M-%SZ", time.gmtime())
    paths = (layout.recordings / f"{began}{again}.mcap" for again in chain([""], map("-{}".format, count(2))))
    path = next(path for path in paths if not path.exists())
    return ("--record", str(path), "--record-limit", str(max(1, free_bytes(layout.home) // 2)))


def _tell(fault: str) -> int:
    print(f"robotcore: {fault}", file=sys.stderr)  # noqa: T201 - into the journal
    return UNUSABLE
