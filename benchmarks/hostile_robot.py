"""Run `robotcore deploy` against hostile robots. They may not run, write or break anything at the client.

    python -m benchmarks.hostile_robot
    python -m benchmarks.hostile_robot --kinds 12 --verbose

Each kind is a robot that answers one command of `robotcore deploy`. The command runs in another process, over a real
sshd on loopback. The benchmark counts:

- files that a hostile string made (`executed`)
- changes at the client outside of ``recordings/HOST``, and anything but plain recordings in it (`written`)
- tracebacks
- control characters on stdout or stderr (`raw`)
- commands that take longer than a minute (`hung`)

The exit status is 1 if any is not 0. It needs sshd, ssh and rsync.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from benchmarks.hostile_answers import CANARY, ENDLESS, RECORDING, RELEASE, HostileRobot, build_hostile_robots
from benchmarks.report import parse_options, print_table
from robotcore.deploy.fetch import PARTIAL
from tests.robotcore.deploy.sshd import Sshd, serving

LIMIT_S = 60.0
ALLOWED_RECORDINGS = (RECORDING, "evil.mcap")
"""The names of recordings that a client may fetch."""

TRACEBACK = "Traceback (most recent call last)"
FAILURES = ("executed", "written", "tracebacks", "raw", "hung")

APP = """
from robotcore import Behaviour, Role, Status


class Still(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        return Status.SUCCESS
"""
PROJECT = """
[tool.robotcore]
app = "app.py"
robot = "rover"

[tool.robotcore.deploy]
backend = "kinematic"
"""

ROBOT = """
import os, pathlib, re, sys

folder = pathlib.Path({folder!r})
command = os.environ.get("SSH_ORIGINAL_COMMAND", "")
if command == "cat":
    os.execlp("cat", "cat")
if command.startswith("rsync"):
    script = folder / "rsync"
    os.chdir(folder / "home")
    words = command.replace("~/", "").split()
    os.execlp("sh", "sh", "-c", script.read_text() if script.exists() else 'exec rsync "$@"', *words)
script = sys.stdin.read()
action = re.findall(r"board\\(.*, '(\\w+)', ", script)[-1]
answer = folder / "answers" / action
if not answer.exists():
    os.environ["HOME"] = str(folder / "home")
    sys.argv = ["-"]
    exec(compile(script, "-", "exec"))
said, _, endless = answer.read_bytes().partition({endless!r})
out = sys.stdout.buffer
try:
    out.write(said)
    while endless:
        out.write(endless)
    out.flush()
except BrokenPipeError:
    os._exit(1)
"""


@dataclass(frozen=True)
class RobotResult:
    """The result of one hostile robot: the client's command, its seconds, and the harm that it did."""

    command: str
    seconds: float
    failures: tuple[str, ...]


def main() -> bool:
    """Print the results of each command. Return whether no robot did harm."""
    options = parse_options(__doc__, kinds=1000, verbose=False)
    robots = build_hostile_robots()[: options.kinds]
    with TemporaryDirectory(prefix="hostile-robot-") as folder:
        results = [
            _run_robot(Path(folder, str(number)), robot, is_verbose=options.verbose)
            for number, robot in enumerate(robots)
        ]
    commands = sorted({result.command for result in results})
    print_table(
        ("command", "kinds", *FAILURES, "median s", "worst s"),
        [_row(name, [each for each in results if each.command == name]) for name in commands] + [_row("all", results)],
    )
    print(f"Most memory of a process: {getrusage(RUSAGE_CHILDREN).ru_maxrss / 1000:.0f} MB")
    return not any(result.failures for result in results)


def _row(name: str, results: Sequence[RobotResult]) -> list[str]:
    counts = [sum(failure in result.failures for result in results) for failure in FAILURES]
    seconds = [result.seconds for result in results]
    return [name, *map(str, (len(results), *counts)), f"{median(seconds):.1f}", f"{max(seconds):.1f}"]


def _run_robot(folder: Path, robot: HostileRobot, *, is_verbose: bool) -> RobotResult:
    folder.mkdir()
    client = _build_client(folder, robot)
    script = folder / "robot.py"
    with serving(folder / "sshd", f"ForceCommand {sys.executable} -I {script}") as server:
        script.write_text(ROBOT.format(folder=str(server.folder), endless=ENDLESS))
        _write_recordings(server, robot)
        before = dict(_list_digests(client))
        written, status, seconds = _run_command(server, client, robot)
        failures = list(_find_failures(written, status))
        if any(path.name.startswith(CANARY) for path in folder.rglob("*")):
            failures.append("executed")
        if dict(_list_digests(client)) != before:
            failures.append("written")
    shutil.rmtree(folder)
    if failures or is_verbose:
        print(f"{robot.name}: {', '.join(failures) or 'harmless'}, status {status}, {seconds:.1f} s: {written[:300]!a}")
    return RobotResult(robot.command[0], seconds, tuple(failures))


def _build_client(folder: Path, robot: HostileRobot) -> Path:
    client = folder / "client"
    for name in ("home", "tmp", "project"):
        (client / name).mkdir(parents=True)
    (client / "project" / "app.py").write_text(APP)
    (client / "project" / "pyproject.toml").write_text(PROJECT)
    if robot.write_client_files:
        robot.write_client_files(client / "project")
    return client


def _write_recordings(server: Sshd, robot: HostileRobot) -> None:
    recordings = server.home / "robotcore" / "recordings"
    for room in (recordings, server.home / "robotcore" / "incoming" / RELEASE, server.folder / "answers"):
        room.mkdir(parents=True)
    for action, answer in robot.answers.items():
        (server.folder / "answers" / action).write_bytes(answer)
    if robot.write_recordings:
        robot.write_recordings(recordings)
    if robot.rsync:
        (server.folder / "rsync").write_text(robot.rsync)


def _run_command(server: Sshd, client: Path, robot: HostileRobot) -> tuple[str, int | None, float]:
    """Execute the command at the client. Return its output, its exit status (None if it hangs), and its seconds."""
    name, *options = robot.command
    target = [server.address.name, "--ssh-config", str(server.config)]
    command = [sys.executable, "-m", "robotcore", "deploy", name, *target, *options]
    own = {"HOME": str(client / "home"), "TMPDIR": str(client / "tmp"), "PYTHONDONTWRITEBYTECODE": "1"}
    begun = perf_counter()
    with (client.parent / "out").open("wb+") as out:
        try:
            status = subprocess.run(  # noqa: S603  the command line that is measured
                command,
                cwd=client / "project",
                env=os.environ | own,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
                timeout=LIMIT_S,
                check=False,
            ).returncode
        except subprocess.TimeoutExpired:
            status = None
        out.seek(0)
        return out.read().decode(errors="replace"), status, perf_counter() - begun


def _find_failures(written: str, status: int | None) -> Iterator[str]:
    if status is None:
        yield "hung"
    if TRACEBACK in written:
        yield "tracebacks"
    if not written.replace("\n", "").replace("\t", "").isprintable():
        yield "raw"


def _list_digests(client: Path) -> Iterator[tuple[str, str]]:
    """Yield the client's files with their digests, except plain recordings in the folder of the robot."""
    own = client / "project" / "recordings" / "robot"
    for path in client.rglob("*"):
        if path == own / PARTIAL:
            continue
        if path.is_symlink():
            yield str(path), f"link to {path.readlink()}"
        elif path.is_file() and not (
            path.parent == own and path.name in ALLOWED_RECORDINGS and not path.stat().st_mode & 0o7111
        ):
            yield str(path), hashlib.sha256(path.read_bytes()).hexdigest()
        elif path.is_dir() and path not in {own, own.parent, client / "tmp"}:
            yield str(path), "folder"


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
