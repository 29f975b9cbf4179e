"""Folders that go to a robot and recordings that come back, by rsync over a connection that is there."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from robotcore.deploy.aboard.layout import FOLDER
from robotcore.deploy.connection.failures import no_program, transfer_failed
from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.ssh import Connection
from robotcore.errors import DeployError

OnProgress = Callable[[int, float], object]
"""Hears how many bytes are done with, and which part of all they are, 0 to 1."""

TIMEOUT_S = 60
"""A transfer in which nothing moves for so long has failed."""

COMMON = (
    "--recursive",
    "--links",
    "--times",
    "--no-protect-args",  # the robot's shell is to find the home, and no other character means anything to it
    "--no-human-readable",
    "--info=progress2",
    "--stats",
    f"--timeout={TIMEOUT_S}",
)

PARTIAL = ".partial"
"""Beside what is brought: what is not whole yet."""

PLACE = re.compile(r"\w[\w.-]*(?:/\w[\w.-]*)*", re.ASCII)
"""A folder on the robot: no shell sees more than a name in it, and it leads nowhere else."""

PROGRESS = re.compile(r"\s*(\d+)\s+(\d+)%\s")
STATS = {
    "files": re.compile(r"Number of files: \d+ \(reg: (\d+)"),
    "changed": re.compile(r"Number of regular files transferred: (\d+)"),
    "sent": re.compile(r"Total bytes sent: (\d+)"),
    "received": re.compile(r"Total bytes received: (\d+)"),
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
    options = ["--executability", "--checksum", "--whole-file", "--delete", "--compress", "--no-inc-recursive"]
    if copy_from is not None:
        options.append(f"--copy-dest={os.path.relpath(_place(copy_from), _place(to))}")
    ends = (f"{folder.absolute()}/", f"robot:~/{FOLDER}/{_place(to)}/")
    return _transfer(connection, host, (*options, *ends), on_progress, where=str(host))


def bring(
    connection: Connection, host: Host, what: Sequence[str], folder: Path, on_progress: OnProgress, *, moves: bool
) -> Transfer:
    """Bring recordings by name, as `Link.bring` has it; the names go through rsync, not through a shell."""
    options = [f"--partial-dir={PARTIAL}", "--no-relative", "--from0", "--files-from=-"]
    if moves:
        options.append("--remove-source-files")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DeployError(f"{folder}: {error.strerror}. Name a folder that can be written to") from error
    ends = (f"robot:~/{FOLDER}/recordings/", f"{folder.absolute()}/")
    names = b"".join(os.fsencode(_own(name)) + b"\0" for name in what)
    return _transfer(connection, host, (*options, *ends), on_progress, names, where="this machine")


def _place(path: str) -> str:
    if not PLACE.fullmatch(path):
        raise ValueError(f"{path!r} is no folder of a robot's")
    return path


def _own(name: str) -> str:
    if name in {"", ".", ".."} or "/" in name or "\0" in name:
        raise DeployError(f"{name!r} is no recording's name; nothing was brought")
    return name


def _transfer(
    connection: Connection,
    host: Host,
    arguments: Sequence[str],
    on_progress: OnProgress,
    given: bytes = b"",
    *,
    where: str,
) -> Transfer:
    """Let rsync do it; ``where`` is the side that is written to."""
    if not shutil.which("rsync"):
        raise no_program("rsync", "rsync")
    command = ["rsync", *COMMON, "-e", shlex.join(connection.client[:-1]), *arguments]
    with tempfile.TemporaryFile() as stdin, tempfile.TemporaryFile() as stderr:
        stdin.write(given)
        stdin.seek(0)
        with _running(command, stdin, stderr) as process:
            told = _heard(process, on_progress)
        if process.returncode:
            stderr.seek(0)
            said = stderr.read().decode(errors="replace")
            raise connection.blame(transfer_failed(host, process.returncode, said, where))
    return Transfer(**{name: int(found[1]) if (found := each.search(told)) else 0 for name, each in STATS.items()})


@contextmanager
def _running(command: Sequence[str], stdin: IO[bytes], stderr: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """Run rsync, apart from the terminal's signals; whatever is raised meanwhile ends it and its ssh."""
    with subprocess.Popen(  # noqa: S603  words of ours, and a folder of this machine
        command, stdin=stdin, stdout=subprocess.PIPE, stderr=stderr, env=_environment(), start_new_session=True
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


def _heard(process: subprocess.Popen[bytes], on_progress: OnProgress) -> str:
    """Tell of progress as long as rsync runs, and return what else it said."""
    assert process.stdout
    told = rest = ""
    while more := os.read(process.stdout.fileno(), 1 << 16):
        *lines, rest = re.split("[\r\n]", rest + more.decode(errors="replace"))
        for line in lines:
            if found := PROGRESS.match(line):
                on_progress(int(found[1]), int(found[2]) / 100)
            else:
                told += f"{line}\n"
    return told + rest
