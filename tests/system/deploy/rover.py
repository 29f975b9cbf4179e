"""The robot as whoever sits at the desk knows it: what is pushed there, and what comes of it."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.system.deploy.desk import Desk
from tests.system.deploy.machine import Machine
from tests.system.deploy.motors import Motors, awaited

BENCH = Path(__file__).parent / "bench"
"""A project with a driver of its own, whose motors write down what they are told."""

SERVICE = "robotcore.service"
Ran = subprocess.CompletedProcess[str]


@dataclass
class Rover:
    """The target, the desk, and a project that is deployed from there."""

    machine: Machine
    desk: Desk
    project: Path
    motors: Motors = field(init=False)

    def __post_init__(self) -> None:
        self.motors = Motors(self.machine)

    def deploy(self, deed: str, *arguments: str) -> Ran:
        """Type a command in the project's folder."""
        return self.desk.deploy(deed, *arguments, project=self.project)

    def done(self, deed: str, *arguments: str) -> str:
        """Type a command that is to succeed; return what it printed."""
        ran = self.deploy(deed, *arguments)
        assert ran.returncode == 0, f"{deed}: exit status {ran.returncode}\n{ran.stdout}{ran.stderr}"
        return ran.stdout

    def push(self, *arguments: str) -> Ran:
        """Push the project as it is now, unproven, with all that pip needs."""
        return self.deploy("push", "--skip-checks", "--offline", *arguments)

    @contextmanager
    def pushing(self, *arguments: str) -> Iterator[subprocess.Popen[str]]:
        """Push as `push` does, beside the check: whatever is done to it meanwhile, it ends with this block."""
        command = self.desk.deploying("push", "--skip-checks", "--offline", *arguments)
        pipe, folder, environment = subprocess.PIPE, self.project, self.desk.environment
        with subprocess.Popen(
            command, cwd=folder, env=environment, stdout=pipe, stderr=pipe, text=True, start_new_session=True
        ) as process:
            try:
                yield process
            finally:
                process.kill()

    def drive(self, rad_s: float) -> str:
        """Push a release that is to live, and drives at this speed; return its name."""
        ran = self.push("--set", f"speed_rad_s={rad_s:g}")
        assert ran.returncode == 0, f"exit status {ran.returncode}\n{ran.stdout}{ran.stderr}"
        self.motors.await_driving(rad_s)
        return self.release

    def status(self) -> dict[str, Any]:
        status: dict[str, Any] = json.loads(self.deploy("status", "--json").stdout)
        return status

    def await_judged(self) -> None:
        """Wait until no release is on trial."""
        trial = self.files / "trial.json"
        awaited(lambda: None if trial.exists() else 1, "the end of a trial", self.status)

    @property
    def files(self) -> Path:
        """Where everything is on the robot."""
        return self.machine.home / "robotcore"

    @property
    def release(self) -> str:
        """The name of the release that is in place, as its folder has it."""
        return (self.files / "current").readlink().name

    @property
    def releases(self) -> list[str]:
        return sorted(path.name for path in (self.files / "releases").iterdir())

    @property
    def process(self) -> int:
        """The app's process, as the target's own systemd counts it; 0 where none runs."""
        shown = self.desk.ssh(f"systemctl --user show --property MainPID --value {SERVICE}")
        return int(shown)


@contextmanager
def with_requirement(project: Path, need: str = "six") -> Iterator[None]:
    """Let it need a package, a small one that nothing else needs: no environment on the robot has it."""
    file = project / "pyproject.toml"
    text = file.read_text()
    with with_text(file, text.replace('version = "0.1.0"', f'version = "0.1.0"\ndependencies = ["{need}"]')):
        yield


@contextmanager
def with_large_file(project: Path, size_mb: int) -> Iterator[None]:
    """Let it have a file that takes a while to send, for no two bytes of it are alike."""
    file = project / "heavy.bin"
    file.write_bytes(os.urandom(size_mb << 20))
    try:
        yield
    finally:
        file.unlink()


@contextmanager
def with_text(file: Path, text: str) -> Iterator[None]:
    """Let a file have another text."""
    before = file.read_text()
    file.write_text(text)
    try:
        yield
    finally:
        file.write_text(before)
