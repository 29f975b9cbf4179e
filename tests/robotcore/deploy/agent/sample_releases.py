"""Sample releases: uploaded and installed ones."""

from __future__ import annotations

import shutil
from pathlib import Path

from robotcore.deploy.agent import files
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import ENVIRONMENT, PROJECT, SITE, Release

OLD, NEW, NEWER = (f"2026-11-21T22-40-0{second}Z" for second in range(3))

DOCTOR = """
import json, os, sys
row = {"about": "machine", "level": "ok", "subject": "arguments"}
row |= {"message": " ".join(sys.argv[1:]), "remedy": os.getcwd()}
print(json.dumps({"findings": [row]}))
"""
"""The source of a robotcore that prints a finding with its arguments and its working folder."""


def send_release(layout: Layout, name: str, *requirements: str, doctor: str = DOCTOR) -> Path:
    """Write the complete upload of a release, and return its folder."""
    shutil.rmtree(layout.incoming / name, ignore_errors=True)
    return _fill_release(layout.incoming / name, name, requirements, doctor)


def put_release(layout: Layout, name: str) -> Path:
    """Write an installed release with an environment of its own, and return its folder."""
    folder = _fill_release(layout.releases / name, name, (), DOCTOR)
    environment = layout.environments / f"digest-{name}"
    environment.mkdir(parents=True)
    (folder / ENVIRONMENT).symlink_to(f"../../environments/{environment.name}")
    return folder


def put_releases(layout: Layout, *names: str, current: str) -> None:
    """Write installed releases, and make one of them the current one."""
    for name in names:
        put_release(layout, name)
    make_current(layout, current)


def make_current(layout: Layout, name: str) -> None:
    """Make a release the current one."""
    files.replace_link(layout.current, f"releases/{name}")


def read_files(folder: Path) -> dict[str, bytes | str]:
    """Return the files below a folder with their contents, and links with their targets, without compiled files."""
    return {
        str(path.relative_to(folder)): str(path.readlink()) if path.is_symlink() else path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if (path.is_symlink() or path.is_file()) and path.suffix != ".pyc"
    }


def _fill_release(folder: Path, name: str, requirements: tuple[str, ...], doctor: str) -> Path:
    (folder / PROJECT).mkdir(parents=True)
    (folder / PROJECT / "my 'robot'.py").write_text(f"# of {name}\n")
    (folder / SITE / "robotcore").mkdir(parents=True)
    (folder / SITE / "robotcore" / "__main__.py").write_text(doctor)
    app = Release(name, "my-robot", "my 'robot'.py", "rover.toml", "raspberrypi", ("run",), ("stop",), requirements)
    app.write(folder)
    return folder
