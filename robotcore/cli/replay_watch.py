"""Replay a recording again each time that the file of its app is saved."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from robotcore.cli.output import write_line
from robotcore.errors import Interrupted, UsageError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.apps import app_path, is_app_file

POLL_S = 0.2
"""The interval at which the files are checked, in seconds."""

END_S, FORWARDED_END_S = 1.0, 10.0
"""The longest waits for the end of a command after a signal, and after the same signal was sent to it, in seconds."""

_PROGRAM = "import sys; sys.path[:] = filter(None, sys.path); from robotcore.cli.main import main; main()"
"""The command line of robotcore, without the current folder in the import path."""

FileVersions = dict[Path, tuple[int, int]]
"""The time of the last change in nanoseconds and the size in bytes of each file."""


def watch_app(app: str, first: Sequence[str], later: Sequence[str], *, is_quiet: bool) -> int:
    """Run a command of robotcore at once, and again when a ``.py`` file in the folder of an app is saved.

    Each command has a process of its own. So it imports all modules of the app anew, and its crash does not end the
    watch.
    Return the exit status of the signal that ends the watch, such as that of Ctrl-C. A usage error of the first command
    ends the watch too.

    app: the file of the app, such as ``my_app.py`` or ``my_app.py:MyApp``.
    first: the arguments of the first command.
    later: the arguments of each other command.
    is_quiet: whether to write nothing beside the output of the commands.
    """
    path = app_path(app)
    if not is_app_file(app) or not path.is_file():
        raise UsageError(f"--watch {app}: there is no such .py file. Name the file of the app", kind="no-such-file")
    clock, arguments = MonotonicClock(), first
    try:
        while True:
            before = _list_versions(path)
            status = _run(arguments)
            if arguments is first and status == UsageError.exit_status:
                return status
            if not is_quiet:
                write_line(f"Watching {path}. Ctrl-C ends.")
            while not _has_settled(path, before, clock):
                pass
            arguments = later
    except Interrupted as interrupt:
        return interrupt.exit_status


def _run(arguments: Sequence[str]) -> int:
    with subprocess.Popen([sys.executable, "-c", _PROGRAM, *arguments]) as child:  # noqa: S603  robotcore itself
        try:
            return child.wait()
        except Interrupted as interrupt:
            _end(child, interrupt.signal_number)
            raise


def _end(child: subprocess.Popen[bytes], signal_number: int) -> None:
    """Let a command end its recording after a signal, and kill it if it does not end.

    A terminal sends the signal of Ctrl-C to the command too. A second one would interrupt its end.
    """
    try:
        child.wait(END_S)
    except subprocess.TimeoutExpired:
        child.send_signal(signal_number)
        with suppress(subprocess.TimeoutExpired):
            child.wait(FORWARDED_END_S)
    finally:
        child.kill()


def _has_settled(path: Path, before: FileVersions, clock: MonotonicClock) -> bool:
    """Wait, and return whether a file has changed before the wait, but not during it. An editor may write in steps."""
    present = _list_versions(path)
    clock.sleep_until(clock.now() + POLL_S)
    return path in present and present != before and _list_versions(path) == present


def _list_versions(path: Path) -> FileVersions:
    """Return the versions of the ``.py`` files in the folder of a file."""
    versions: FileVersions = {}
    for file in path.parent.glob("*.py"):
        with suppress(OSError):  # an editor may replace the file just now
            status = file.stat()
            versions[file] = status.st_mtime_ns, status.st_size
    return versions
