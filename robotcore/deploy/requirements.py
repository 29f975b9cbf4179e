"""What pip installs on the robot: what is brought needs it, and it is not brought itself."""

from __future__ import annotations

from pathlib import Path

from robotcore.deploy.project import Project


def requirements_of(project: Project, site: Path) -> tuple[str, ...]:
    return ()
