"""What is brought to the robot as it is installed at the desk: robotcore, and packages of the user's."""

from __future__ import annotations

from pathlib import Path

from robotcore.deploy.project import Project


def build_site(project: Project, source: Path, site: Path) -> Path:
    site.mkdir()
    return site
