"""Make the corpus of a release: files as its users have them, and its interface as data.

    python -m tests.compatibility.make_corpus 0.2.0

Run it on the commit of the release. It makes the folder ``tests/compatibility/VERSION``, which is never changed again:
the tests of all later releases read it. ``sources`` has the apps, robots and worlds of the next corpus. They must use
every key.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.cli.main import execute
from robotcore.cli.scaffold import DRIVER, KIND, PROJECT, make
from robotcore.compatibility import read_version
from robotcore.description import read_shipped, robot_names
from robotcore.recording import read
from tests.compatibility.interface import describe_interface
from tests.compatibility.recordings import EVERYTHING, record_all

HERE = Path(__file__).parent
SOURCES = HERE / "sources"
SURVEY = ("survey.py", "--robot", "everything.toml", "--world", "hall.toml", "--set", "duration_s=0.5")
OUTPUTS: dict[str, tuple[str, ...]] = {
    "run": ("run", *SURVEY, "--seed", "3"),
    "unknown-app": ("run", "gren-search"),
    "sweep": ("sweep", *SURVEY, "--seeds", "1-3", "--jobs", "1", "--out", "sweep"),
    "replay": ("replay", "recordings/everything.mcap", "--app", "survey.py"),
    "evaluation": ("replay", "recordings/everything.mcap", "--app", "avoid-obstacles"),
    "compare": ("compare", "recordings/everything.mcap", "recordings/faults.mcap"),
    "info": ("info", "recordings/everything.mcap"),
    "fidelity": ("fidelity", "recordings/skidding.mcap"),
    "apps": ("apps",),
    "backends": ("backends",),
    "faults": ("faults",),
    "kinds": ("kinds",),
    "robots": ("robots",),
    "worlds": ("worlds",),
    "wiring": ("wiring", "everything.toml"),
    "doctor": ("doctor",),
}
"""The command of each output in JSON."""


def main() -> int:
    """Make the corpus of the version in the command line. Return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("version", help="the version of this robotcore, such as 0.2.0")
    version = parser.parse_args().version
    folder = HERE / version
    if version != read_version().partition("rc")[0]:
        sys.exit(
            f"this is robotcore {read_version()}, not {version}. Set the version in pyproject.toml, and install it"
        )
    if folder.exists():
        sys.exit(f"{folder} exists already. A released corpus is not changed")
    with TemporaryDirectory(dir=HERE) as scratch:
        made = Path(scratch, version)
        make_corpus(made)
        made.rename(folder)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    sys.stdout.write(f"{folder} has been made: {size / 1e6:.2f} MB. Commit it with the release\n")
    return 0


def make_corpus(folder: Path) -> None:
    """Make a corpus in a new folder."""
    shutil.copytree(SOURCES, folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in robot_names():
        (folder / f"shipped-{name}.toml").write_text(read_shipped(name), encoding="utf-8")
    for template, name in ((PROJECT, "old-robot"), (DRIVER, "old-board"), (KIND, "old-sensor")):
        make(template, folder / name)
    recordings = folder / "recordings"
    recordings.mkdir()
    with enter_folder(folder), redirect_stdout(StringIO()):
        record_all(recordings)
    _write_json(folder / "recordings.json", {file.name: _describe(file) for file in sorted(recordings.glob("*.mcap"))})
    with enter_folder(folder):
        _write_json(folder / "outputs.json", {name: run_command(*command) for name, command in OUTPUTS.items()})
    _make_map().save(folder / "map.npz")
    _write_json(folder / "interface.json", describe_interface())
    for each in [*folder.rglob("__pycache__"), *folder.rglob("*.lock")]:
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    for name in ("sweep/sweep.json", "outputs.json"):
        file = folder / name
        file.write_text(_hide_folders(file.read_text(encoding="utf-8"), folder), encoding="utf-8")


@contextmanager
def enter_folder(folder: Path) -> Iterator[None]:
    """Make a folder the current one until the context is left."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def _hide_folders(text: str, folder: Path) -> str:
    """Return a text without the paths of this machine."""
    for path, name in ((folder, "/home/user/corpus"), (HERE.parents[1], "/home/user/robotcore")):
        text = text.replace(os.fspath(path), name)
    return text


def _describe(file: Path) -> dict[str, Any]:
    """Return the facts of a recording that every later release must find in it."""
    if file.stem == "killed":  # reading it would join its segments
        return {}
    recording = read(file)
    app = recording.metadata.request.app_reference
    return {
        "ticks": len(recording.ticks),
        "outcome": recording.result.outcome.value if recording.result else None,
        "is_replayable": recording.is_replayable,
        "app": app,
        "samples": len(recording.samples),
        "logged": sum(map(len, recording.logged.values())),
        "printed": sum(map(len, recording.printed.values())),
        "last_pose": list(recording.ticks[-1].pose or ()),
        "is_of_everything": recording.metadata.description.name == Path(EVERYTHING["robot"]).stem,
    }


def run_command(*command: str) -> dict[str, Any]:
    """Run a command with ``--json``. Return its arguments, its exit status and its output."""
    out = StringIO()
    with redirect_stdout(out), redirect_stderr(StringIO()):
        status = execute([*command, "--json"])
    return {"command": list(command), "exit_status": status, "json": json.loads(out.getvalue())}


def _make_map() -> OccupancyGrid:
    grid = OccupancyGrid(2.0, 0.1)
    grid.evidence[5, 5], grid.evidence[6, 6] = 3.0, -3.0
    grid.travelled = 1.5
    return grid


def _write_json(file: Path, content: object) -> None:
    file.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
