"""Transfers by rsync over an open ssh connection."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent.files import FOLDER
from robotcore.deploy.errors import explain_failed_transfer, require_program
from robotcore.deploy.process_output import run_process
from robotcore.deploy.robot_answers import require_remote_folder
from robotcore.deploy.ssh import SshConnection

OnProgress = Callable[[int, float], object]
"""A function that is called with the transferred bytes, and with their fraction of all bytes, 0 to 1."""

TIMEOUT_S = 60
"""The time without data, in s, after which a transfer fails."""

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
"""The options for receiving: only the named files, only plain files, and without execute permission."""

RECORDING = re.compile(r"\w[\w.-]{0,94}\.mcap", re.ASCII)
"""The name of a recording: at most 100 ASCII letters, digits, underscores, dots and dashes, ending in .mcap."""

MAX_OUTPUT_CHARACTERS = 1 << 16
"""The number of characters at the end of rsync's output that are kept. The statistics are there."""

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
    """The number of plain files at the source."""
    changed: int
    """The number of files whose content was transferred, because they are new or differed at the destination."""
    sent: int
    """The number of bytes from this machine to the robot."""
    received: int
    """The number of bytes from the robot to this machine."""


def send(
    link: SshConnection, folder: Path, to: str, copy_from: str | None = None, on_progress: OnProgress | None = None
) -> Transfer:
    """Copy the contents of a folder to the robot, and delete other files in the target folder.

    rsync compares the contents of files instead of their times, because a fresh checkout has new times. It sends a
    different file as a whole, because rsync 3.2.7 of Debian 12 cannot verify a file patched from ``--copy-dest``.

    link: an open connection to the robot.
    folder: the folder on this machine.
    to: an existing folder on the robot, relative to `Layout.root`.
    copy_from: another folder on the robot. A file that is equal to one in it is copied there instead of sent.
    Raises DeployError with a remedy. After another exception of this machine, the robot ends the transfer too.
    """
    options = [*SEND_OPTIONS, "--no-inc-recursive"]
    if copy_from is not None:
        options.append(f"--copy-dest={os.path.relpath(require_remote_folder(copy_from), require_remote_folder(to))}")
    ends = (f"{folder.absolute()}/", f"robot:~/{FOLDER}/{require_remote_folder(to)}/")
    return _run_transfer(link, (*options, *ends), on_progress, where=str(link.host))


def receive(
    link: SshConnection,
    what: Sequence[str],
    folder: Path,
    *,
    partial: Path,
    on_poll: Callable[[], object] | None = None,
    on_progress: OnProgress | None = None,
) -> Transfer:
    """Copy recordings from the robot. They stay on the robot too. Their names go through stdin instead of a shell.

    link: an open connection to the robot.
    what: the names of the recordings.
    folder: the folder on this machine.
    partial: the folder that keeps an incomplete file if the connection breaks. The next call completes that file.
    on_poll: this function is called at least every half second. If it raises an exception, the transfer ends.
    Raises DeployError, as `send` does.
    """
    options = (f"--partial-dir={partial.absolute()}", *RECEIVE_OPTIONS)
    ends = (f"robot:~/{FOLDER}/recordings/", f"{folder.absolute()}/")
    for name in what:
        if not RECORDING.fullmatch(name):
            raise ValueError(f"{name!r} is not the name of a recording")
    names = "".join(f"{name}\0" for name in what).encode()
    return _run_transfer(link, (*options, *ends), on_progress, names, on_poll, where="this machine")


def _run_transfer(
    link: SshConnection,
    arguments: Sequence[str],
    on_progress: OnProgress | None,
    stdin: bytes = b"",
    on_poll: Callable[[], object] | None = None,
    *,
    where: str,
) -> Transfer:
    require_program("rsync", "rsync")
    # messages in English, without the variables that change rsync's options
    environment = {name: value for name, value in os.environ.items() if not name.startswith("RSYNC_")}
    command = ["rsync", *COMMON_OPTIONS, "-e", shlex.join(link.ssh_command[:-1]), *arguments]
    with run_process(command, stdin, environment | {"LC_ALL": "C"}) as output:
        printed = _read(output.read_pieces(), on_progress, on_poll)
    if output.status:
        raise link.find_cause(explain_failed_transfer(link.host, output.status, output.stderr_excerpt, where))
    return Transfer(**{name: int(found[1]) if (found := each.search(printed)) else 0 for name, each in STATS.items()})


def _read(pieces: Iterable[bytes], on_progress: OnProgress | None, on_poll: Callable[[], object] | None) -> str:
    """Report the progress until rsync ends. Return the end of rsync's output without the progress lines."""
    printed = rest = ""
    for piece in pieces:
        if on_poll:
            on_poll()
        *lines, rest = re.split("[\r\n]", rest + piece.decode(errors="replace"))
        for line in lines:
            if found := PROGRESS.match(line):
                if on_progress:
                    on_progress(int(found[1]), int(found[2]) / 100)
            else:
                printed = f"{printed}{line}\n"[-MAX_OUTPUT_CHARACTERS:]
        rest = rest[-MAX_OUTPUT_CHARACTERS:]
    return printed + rest
