"""Releases as they come from the desk."""

from __future__ import annotations

import shutil
from pathlib import Path

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.release import ENVIRONMENT, PROJECT, SITE, Release
from robotcore.deploy.agent.system import durable

OLD, NEW, NEWER = (f"2026-11-21T22-40-0{second}Z" for second in range(3))

DOCTOR = """
import json, os, sys
row = {"about": "machine", "level": "ok", "what": "arguments", "said": " ".join(sys.argv[1:]), "remedy": os.getcwd()}
print(json.dumps({"findings": [row]}))
"""
"""A robotcore that tells how it was called."""


def send(layout: Layout, name: str, *requirements: str, doctor: str = DOCTOR) -> Path:
    """Put what the desk sends where the desk sends it, and nothing else there."""
    shutil.rmtree(layout.incoming / name, ignore_errors=True)
    return _fill(layout.incoming / name, name, requirements, doctor)


def put(layout: Layout, name: str) -> Path:
    """Put a release there as an installation leaves it, with an environment of its own."""
    folder = _fill(layout.releases / name, name, (), DOCTOR)
    environment = layout.environments / f"digest-{name}"
    environment.mkdir(parents=True)
    (folder / ENVIRONMENT).symlink_to(f"../../environments/{environment.name}")
    return folder


def let_run(layout: Layout, name: str) -> None:
    """Make a release the current one."""
    durable.link(layout.current, f"releases/{name}")


def files_of(folder: Path) -> dict[str, bytes | str]:
    """Return all that is below a folder: files with what is in them, links with where they lead; nothing compiled."""
    return {
        str(path.relative_to(folder)): str(path.readlink()) if path.is_symlink() else path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if (path.is_symlink() or path.is_file()) and path.suffix != ".pyc"
    }


def _fill(folder: Path, name: str, requirements: tuple[str, ...], doctor: str) -> Path:
    (folder / PROJECT).mkdir(parents=True)
    (folder / PROJECT / "my 'robot'.py").write_text(f"# of {name}\n")
    (folder / SITE / "robotcore").mkdir(parents=True)
    (folder / SITE / "robotcore" / "__main__.py").write_text(doctor)
    app = Release(name, "my-robot", "my 'robot'.py", "rover.toml", "raspberrypi", ("run",), ("stop",), requirements)
    app.write(folder)
    return folder
