"""``robotcore deploy fetch``: what a robot recorded comes home.

``--json`` prints ``host``, ``folder``; the names ``brought``, ``here`` already, ``different``, ``being_written``,
``left`` on the robot and ``erased`` there; ``newest``, a path or null; and ``exit_status``.
"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.deploy._options import AnsweringDeployCommand, link_to, on_robot
from robotcore.cli.deploy._output import Showing
from robotcore.cli.options import Folder
from robotcore.cli.output import as_json, write_json, write_line
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.deploy.fetch import Fetched
    from robotcore.deploy.host import Host

RECORDINGS = Path("recordings")
"""Here, with a folder for each robot."""


@click.command("fetch", cls=AnsweringDeployCommand)
@on_robot
@click.option("-o", "--out", metavar="DIR", type=Folder(), help="Where to; recordings/HOST if left out.")
@click.option("--move", "moves", is_flag=True, help="Delete there what is here, byte for byte.")
@as_json
def command(host: Host, ssh_config: Path | None, out: Path | None, *, moves: bool, as_json: bool) -> int:
    """Bring the recordings of HOST here: those that are not here yet.

    Fetches plain files with the names of recordings. Overwrites no file here, and leaves a recording that is still
    being written. Exit status 1 if a file here has the name of a recording but other content.
    """
    from robotcore.deploy.fetch import fetch

    folder = out or _default_folder(host)
    with Showing() as showing, link_to(host, ssh_config) as link:
        fetched = fetch(link, folder, _ignore_progress if as_json else showing, moves=moves)
    status = 1 if fetched.different else 0
    if as_json:
        write_json({"host": str(host), **_build_payload(fetched), "exit_status": status})
    else:
        _tell_what_next(fetched)
    return status


def _default_folder(host: Host) -> Path:
    """Return ``recordings/HOST``; raises UsageError if either of its folders is a symbolic link."""
    folder = RECORDINGS / host.name
    for path in (RECORDINGS, folder):
        if path.is_symlink():
            raise UsageError(
                f"{path} is a symbolic link, and fetch writes through no link. To use its target, name that folder: "
                f"-o {shlex.quote(str(path.resolve()))}"
            )
    return folder


def _ignore_progress(_progress: object) -> None:
    """Show nothing: the answer is one line of JSON."""


def _build_payload(fetched: Fetched) -> dict[str, Any]:
    return {
        "folder": str(fetched.folder),
        "brought": fetched.brought,
        "here": fetched.here,
        "different": fetched.different,
        "being_written": fetched.written,
        "left": fetched.left,
        "erased": fetched.erased,
        "newest": str(fetched.newest) if fetched.newest else None,
    }


def _tell_what_next(fetched: Fetched) -> None:
    from robotcore.text import escape

    if fetched.newest:
        file = escape(shlex.quote(str(fetched.newest)))
        write_line(f"Replay the newest: robotcore replay {file}")
        write_line(f"Compare it with a simulated run: robotcore compare {file} run.mcap")
