"""The robot as the client uses it: a project that is pushed to it, and its state."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.system.deploy.client import Client
from tests.system.deploy.machine import Machine
from tests.system.deploy.motors import Motors, wait_for

BENCH = Path(__file__).parent / "bench"
"""A project with a driver of its own, whose motors write their commands into a log."""

SERVICE = "robotcore.service"
Ran = subprocess.CompletedProcess[str]


@dataclass
class Rover:
    """A robot, the client, and a project that is deployed."""

    machine: Machine
    client: Client
    project: Path
    motors: Motors = field(init=False)

    def __post_init__(self) -> None:
        self.motors = Motors(self.machine)

    def deploy(self, action: str, *arguments: str) -> Ran:
        """Run a command of ``robotcore deploy`` in the project's folder."""
        return self.client.deploy(action, *arguments, project=self.project)

    def run(self, action: str, *arguments: str) -> str:
        """Run a command that must succeed; return its output."""
        done = self.deploy(action, *arguments)
        assert done.returncode == 0, f"{action}: exit status {done.returncode}\n{done.stdout}{done.stderr}"
        return done.stdout

    def push(self, *arguments: str) -> Ran:
        """Push the project without checks, and with wheels."""
        return self.deploy("push", "--skip-checks", "--offline", *arguments)

    @contextmanager
    def run_push(self, *arguments: str) -> Iterator[subprocess.Popen[str]]:
        """Push in another process, which is killed at the end of the block."""
        command = self.client.build_command("push", "--skip-checks", "--offline", *arguments)
        pipe, folder, environment = subprocess.PIPE, self.project, self.client.environment
        with subprocess.Popen(
            command, cwd=folder, env=environment, stdout=pipe, stderr=pipe, text=True, start_new_session=True
        ) as process:
            try:
                yield process
            finally:
                process.kill()

    def drive(self, rad_s: float) -> str:
        """Push a release that drives at this speed, and wait until it does; return its name."""
        done = self.push("--set", f"speed_rad_s={rad_s:g}")
        assert done.returncode == 0, f"exit status {done.returncode}\n{done.stdout}{done.stderr}"
        self.motors.await_driving(rad_s)
        return self.release

    def status(self) -> dict[str, Any]:
        status: dict[str, Any] = json.loads(self.deploy("status", "--json").stdout)
        return status

    def await_health_check(self) -> None:
        """Wait until no health check is pending."""
        check = self.files / "health-check.json"
        wait_for(lambda: None if check.exists() else 1, "the end of a health check", self.status)

    @property
    def files(self) -> Path:
        """robotcore's folder on the robot."""
        return self.machine.home / "robotcore"

    @property
    def release(self) -> str:
        """The name of the current release."""
        return (self.files / "current").readlink().name

    @property
    def releases(self) -> list[str]:
        return sorted(path.name for path in (self.files / "releases").iterdir())

    @property
    def process(self) -> int:
        """The app's process, from the robot's systemd; 0 if none runs."""
        shown = self.client.ssh(f"systemctl --user show --property MainPID --value {SERVICE}")
        return int(shown)


@contextmanager
def add_requirement(project: Path, need: str = "six") -> Iterator[None]:
    """Add a requirement to a project during the block: a small package that no environment on the robot has."""
    file = project / "pyproject.toml"
    text = file.read_text()
    with replace_text(file, text.replace('version = "0.1.0"', f'version = "0.1.0"\ndependencies = ["{need}"]')):
        yield


@contextmanager
def add_large_file(project: Path, size_mb: int) -> Iterator[None]:
    """Add a file of random bytes to a project during the block."""
    file = project / "heavy.bin"
    file.write_bytes(os.urandom(size_mb << 20))
    try:
        yield
    finally:
        file.unlink()


@contextmanager
def replace_text(file: Path, text: str) -> Iterator[None]:
    """Replace the text of a file during the block."""
    before = file.read_text()
    file.write_text(text)
    try:
        yield
    finally:
        file.write_text(before)
