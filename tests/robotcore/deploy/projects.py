"""Sample projects of users."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from robotcore.deploy.project import DeployOptions, Project, build_project

DRIVES_ON = """
from robotcore import Behaviour, Role, Status

class Reflex(Behaviour):
    needs = frozenset({Role.DRIVE, Role.RANGE})

    def step(self, robot):
        is_near = robot.range.read().distance < 0.4
        robot.drive.set_velocity(0.0 if is_near else 0.2, 1.0 if is_near else 0.0)
        return Status.RUNNING
"""

TABLE = """
[tool.robotcore]
app = "app.py"
robot = "rover"

[tool.robotcore.deploy]
backend = "kinematic"
seeds = "1"
record = false
"""


def write(folder: Path, files: dict[str, str]) -> Path:
    """Write files by their names below a folder; return it."""
    for name, content in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
    return folder


def write_project(folder: Path, table: str = TABLE, app: str = DRIVES_ON, **asked: object) -> Project:
    """Return the project of a folder, with an app and a table in it."""
    write(folder, {"app.py": app, "pyproject.toml": table})
    return build_project(DeployOptions(**asked), folder)  # type: ignore[arg-type]


def git(folder: Path, *words: str) -> None:
    """Run git in a folder."""
    subprocess.run([shutil.which("git") or "git", *words], cwd=folder, check=True, capture_output=True)
