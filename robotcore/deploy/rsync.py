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
from robotcore.deploy.errors import explain_failed_transfer, explain_missing_program
from robotcore.deploy.host import Host
from robotcore.deploy.process_output import ProcessOutput
from robotcore.deploy.robot_answers import REMOTE_FOLDER
from robotcore.deploy.ssh import Connection

OnProgress = Callable[[int, float], object]
"""The type of a function that is called with the transferred bytes, and with their share of all bytes, 0 to 1."""

OnPoll = Callable[[], object]
"""The type of a function that is called during a transfer. If it raises an exception, the transfer ends."""

TIMEOUT_S = 60
"""A transfer has failed if no data are transferred for this time, in s."""

COMMON_OPTIONS = (
    "--times",
    "--no-protect-args",  # so that the robot's shell expands ~, the only special character in a path
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
"""The options for receiving: only plain files, only those that are named, and none executable."""

RECORDING = re.compile(r"\w[\w.-]{0,94}\.mcap", re.ASCII)
"""The name of a recording: at most 100 ASCII letters, digits, underscores, dots and dashes, ending in .mcap."""

MAX_OUTPUT_CHARACTERS = 1 << 16
"""Of rsync's output, this many characters at the end are kept. They contain the statistics."""

PROGRESS = re.compile(r"\s*(\d{1,18})\s+(\d{1,3})%\s")
STATS = {
    "files": re.compile(r"Number of files: \d+ \(reg: (\d{1,18})"),
    "changed": re.compile(r"Number of regular files transferred: (\d{1,18})"),
    "sent": re.compile(r"Total bytes sent: (\d{1,18})"),
    "received": re.compile(r"Total bytes received: (\d{1,18})"),
}


@dataclass(frozen=True)
class Transfer:
    """The statistics of a transfer."""

    files: int
    """The number of files."""
    changed: int
    """The number of files that were transferred, because they differed."""
    sent: int
    """The bytes from this machine to the robot."""
    received: int
    """The bytes from the robot to this machine."""


def send(
    connection: Connection, host: Host, folder: Path, to: str, copy_from: str | None, on_progress: OnProgress
) -> Transfer:
    """Send the contents of a folder, see `Link.send`.

    rsync compares files by content instead of time, because a fresh checkout has new times. A file that differs is sent
    as a whole: rsync 3.2.7 of Debian 12 cannot verify a file that it patches from a folder of ``--copy-dest``. Other
    files in the target folder are deleted, because an interrupted upload may have left them.
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
    """Copy recordings from the robot, see `Link.receive`. rsync reads their names from stdin, not through a shell."""
    options = RECEIVE_OPTIONS if partial is None else (f"--partial-dir={partial.absolute()}", *RECEIVE_OPTIONS)
    ends = (f"robot:~/{FOLDER}/recordings/", f"{folder.absolute()}/")
    names = b"".join(_require_recording_name(name).encode() + b"\0" for name in what)
    return _transfer(connection, host, (*options, *ends), on_progress, names, on_poll, where="this machine")


def _require_remote_folder(path: str) -> str:
    if not REMOTE_FOLDER.fullmatch(path):
        raise ValueError(f"{path!r} is not a folder of a robot")
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
    stdin: bytes = b"",
    on_poll: OnPoll = lambda: None,
    *,
    where: str,
) -> Transfer:
    """Run rsync, and return the statistics of the transfer.

    where: the machine that receives the files, for an error message.
    """
    if not shutil.which("rsync"):
        raise explain_missing_program("rsync", "rsync")
    command = ["rsync", *COMMON_OPTIONS, "-e", shlex.join(connection.ssh_command[:-1]), *arguments]
    with tempfile.TemporaryFile() as file:
        file.write(stdin)
        file.seek(0)
        with _run(command, file) as process:
            output = ProcessOutput(process)
            printed = _read(output.read_pieces(), on_progress, on_poll)
        if process.returncode:
            raise connection.find_cause(explain_failed_transfer(host, process.returncode, output.stderr_excerpt, where))
    return Transfer(**{name: int(found[1]) if (found := each.search(printed)) else 0 for name, each in STATS.items()})


@contextmanager
def _run(command: Sequence[str], stdin: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """Run rsync during a ``with`` block. Ctrl-C does not reach rsync. If the block raises, rsync and its ssh end."""
    with subprocess.Popen(  # noqa: S603  constants, and a folder of this machine
        command,
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=_build_environment(),
        start_new_session=True,
    ) as process:
        try:
            yield process
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            raise


def _build_environment() -> dict[str, str]:
    """Return the environment without variables that change rsync's options, and with messages in English."""
    return {name: value for name, value in os.environ.items() if not name.startswith("RSYNC_")} | {"LC_ALL": "C"}


def _read(pieces: Iterable[bytes], on_progress: OnProgress, on_poll: OnPoll) -> str:
    """Report the progress while rsync runs, and return the end of its output without the progress lines."""
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
