"""``robotcore deploy fetch``: copy the recordings of a robot to this machine."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.deploy._options import AnsweringDeployCommand, make_link, robot_argument
from robotcore.cli.deploy._progress import StepDisplay
from robotcore.cli.options import FolderType
from robotcore.cli.output import as_json, write_json, write_line
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.deploy.fetch import FetchResult
    from robotcore.deploy.host import RobotAddress


RECORDINGS = Path("recordings")
"""The folder for recordings in the current folder. It has a folder for each robot."""


@click.command("fetch", cls=AnsweringDeployCommand)
@robot_argument
@click.option(
    "-o", "--out", metavar="DIR", type=FolderType(), help="The folder for the recordings. Default: recordings/HOST."
)
@click.option("--move", "moves", is_flag=True, help="Delete each recording from the robot once its copy is verified.")
@as_json
def command(host: RobotAddress, out: Path | None, *, moves: bool, as_json: bool) -> int:
    """Copy the recordings of HOST that are not in the folder yet.

    Fetches plain files with the names of recordings. Overwrites no file here, and leaves a recording that is still
    being written. Exit status 1 if a file here has the name of a recording but other content.
    """
    from robotcore.deploy.fetch import fetch

    folder = out or _build_default_folder(host)
    with StepDisplay() as display, make_link(host) as link:
        result = fetch(link, folder, _ignore_progress if as_json else display, deletes_on_robot=moves)
    status = 1 if result.different else 0
    if as_json:
        write_json(_build_answer(host, result, status))
    else:
        _write_next_commands(result)
    return status


def _build_default_folder(host: RobotAddress) -> Path:
    folder = RECORDINGS / host.name
    for path in (RECORDINGS, folder):
        if path.is_symlink():
            raise UsageError(
                f"{path} is a symbolic link, which fetch does not follow. To use its target, name that folder: "
                f"-o {shlex.quote(str(path.resolve()))}",
                kind="symbolic-link",
                path=str(path),
            )
    return folder


def _ignore_progress(_progress: object) -> None:
    """Print no progress, because the output is one line of JSON."""


def _build_answer(host: RobotAddress, result: FetchResult, status: int) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore deploy fetch``.

    The JSON keys:

    host: text; the robot's address.
    folder: text; the folder for the recordings on this machine.
    fetched: list of text; the names of the recordings that this command copied.
    present: list of text; the names of the recordings that were in the folder before.
    different: list of text; the names of the recordings of which the folder has a file with other content.
    being_written: list of text; the names of the recordings that an app is writing.
    skipped: list of text; the names of the other files on the robot.
    erased: list of text; the names of the recordings that this command deleted from the robot.
    newest: text or null; the path of the newest recording in the folder.
    exit_status: whole number; the exit status.
    """
    return {
        "host": str(host),
        "folder": str(result.folder),
        "fetched": result.fetched,
        "present": result.present,
        "different": result.different,
        "being_written": result.being_written,
        "skipped": result.skipped,
        "erased": result.erased,
        "newest": str(result.newest) if result.newest else None,
        "exit_status": status,
    }


def _write_next_commands(result: FetchResult) -> None:
    from robotcore.text import escape

    if result.newest:
        file = escape(shlex.quote(str(result.newest)))
        write_line(f"Show the newest: robotcore info {file}")
        write_line(f"Compare it with a simulated run: robotcore compare {file} run.mcap")
