"""Transfers by rsync over an open ssh connection."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from robotcore.deploy.agent.files import FOLDER
from robotcore.deploy.answers import REMOTE_FOLDER
from robotcore.deploy.errors import program_missing, transfer_failed
from robotcore.deploy.host import Host
from robotcore.deploy.process_output import ProcessOutput
from robotcore.deploy.ssh import Connection

OnProgress = Callable[[int, float], object]
"""Hears how many bytes are done with, and which part of all they are, 0 to 1."""

OnPoll = Callable[[], object]
"""Is called while a transfer goes on. An exception that it raises ends the transfer."""

TIMEOUT_S = 60
"""A transfer in which nothing moves for so long has failed."""

COMMON_OPTIONS = (
    "--times",
    "--no-protect-args",  # the robot's shell is to find the home, and no other character means anything to it
    "--no-human-readable",
    "--info=progress2",
    "--stats",
    f"--timeout={TIMEOUT_S}",
)

SEND_OPTIONS = ("--recursive", "--links", "--executability", "--checksum", "--whole-file", "--delete", "--compress")

RECEIVE_OPTIONS = (
    "--no-links",
    "--no-devices",
    "--no-specials",
    "--chmod=F644",
    "--no-relative",
    "--from0",
    "--files-from=-",
)
"""Plain files alone come over, by name, and none can be executed."""

RECORDING = re.compile(r"\w[\w.-]{0,94}\.mcap", re.ASCII)
"""The name of a recording: at most 100 ASCII letters, digits, underscores, dots and dashes, ending in .mcap."""

MAX_OUTPUT_CHARACTERS = 1 << 16
"""Characters that are kept of what rsync prints: its statistics are the last of it."""

PROGRESS = re.compile(r"\s*(\d{1,18})\s+(\d{1,3})%\s")
STATS = {
    "files": re.compile(r"Number of files: \d+ \(reg: (\d{1,18})"),
    "changed": re.compile(r"Number of regular files transferred: (\d{1,18})"),
    "sent": re.compile(r"Total bytes sent: (\d{1,18})"),
    "received": re.compile(r"Total bytes received: (\d{1,18})"),
}


@dataclass(frozen=True)
class Transfer:
    """What went over the line: how many files there are, how many of them were changed, and bytes each way."""

    files: int
    changed: int
    sent: int
    received: int


def send(
    connection: Connection, host: Host, folder: Path, to: str, copy_from: str | None, on_progress: OnProgress
) -> Transfer:
    """Send what is in a folder, as `Link.send` has it.

    Contents decide what is the same, not times: those of a fresh checkout tell nothing. A file that has changed goes
    whole: rsync 3.2.7 as Debian 12 has it fails to verify one that is patched from a folder of --copy-dest. What else
    is there goes: a push takes over what a broken one has sent.
    """
    options = [*SEND_OPTIONS, "--no-inc-recursive"]
    if copy_from is not None:
        options.append(f"--copy-dest={os.path.relpath(_require_remote_folder(copy_from), _require_remote_folder(to))}")
    ends = (f"{folder.absolute()}/", f"robot:~/{FOLDER}/{_require_remote_folder(to)}/")
    return _transfer(connection, host, (*options, *ends), on_progress, where=str(host))


def receive(
    connection: Connection,
    host: Host,
    what: Sequence[str],
    folder: Path,
    partial: Path | None,
    on_poll: OnPoll,
    on_progress: OnProgress,
) -> Transfer:
    """Bring recordings by name, as `Link.receive` has it; the names go through rsync, not through a shell."""
    options = RECEIVE_OPTIONS if partial is None else (f"--partial-dir={partial.absolute()}", *RECEIVE_OPTIONS)
    ends = (f"robot:~/{FOLDER}/recordings/", f"{folder.absolute()}/")
    names = b"".join(_require_recording_name(name).encode() + b"\0" for name in what)
    return _transfer(connection, host, (*options, *ends), on_progress, names, on_poll, where="this machine")


def _require_remote_folder(path: str) -> str:
    if not REMOTE_FOLDER.fullmatch(path):
        raise ValueError(f"{path!r} is no folder of a robot's")
    return path


def _require_recording_name(name: str) -> str:
    if not RECORDING.fullmatch(name):
        raise ValueError(f"{name!r} is not the name of a recording")
    return name


def _transfer(
    connection: Connection,
    host: Host,
    arguments: Sequence[str],
    on_progress: OnProgress,
    given: bytes = b"",
    on_poll: OnPoll = lambda: None,
    *,
    where: str,
) -> Transfer:
    """Let rsync do it; ``where`` is the side that is written to."""
    if not shutil.which("rsync"):
        raise program_missing("rsync", "rsync")
    command = ["rsync", *COMMON_OPTIONS, "-e", shlex.join(connection.client[:-1]), *arguments]
    with tempfile.TemporaryFile() as stdin:
        stdin.write(given)
        stdin.seek(0)
        with _running(command, stdin) as process:
            output = ProcessOutput(process)
            printed = _read(output.pieces(), on_progress, on_poll)
        if process.returncode:
            raise connection.find_cause(transfer_failed(host, process.returncode, output.stderr_excerpt, where))
    return Transfer(**{name: int(found[1]) if (found := each.search(printed)) else 0 for name, each in STATS.items()})


@contextmanager
def _running(command: Sequence[str], stdin: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """Run rsync, apart from the terminal's signals; whatever is raised meanwhile ends it and its ssh."""
    with subprocess.Popen(  # noqa: S603  words of ours, and a folder of this machine
        command,
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=_environment(),
        start_new_session=True,
    ) as process:
        try:
            yield process
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            raise


def _environment() -> dict[str, str]:
    """Return the environment without what would change what rsync does, and with messages as they are known here."""
    return {name: value for name, value in os.environ.items() if not name.startswith("RSYNC_")} | {"LC_ALL": "C"}


def _read(pieces: Iterable[bytes], on_progress: OnProgress, on_poll: OnPoll) -> str:
    """Pass on progress as long as rsync runs, and return the end of what else it printed."""
    printed = rest = ""
    for piece in pieces:
        on_poll()
        *lines, rest = re.split("[\r\n]", rest + piece.decode(errors="replace"))
        for line in lines:
            if found := PROGRESS.match(line):
                on_progress(int(found[1]), int(found[2]) / 100)
            else:
                printed = f"{printed}{line}\n"[-MAX_OUTPUT_CHARACTERS:]
        rest = rest[-MAX_OUTPUT_CHARACTERS:]
    return printed + rest
