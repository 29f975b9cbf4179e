"""``robotcore deploy rollback`` and ``remove``: run an earlier release again, or remove all releases."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, make_link, robot_argument
from robotcore.cli.output import write_line, write_lines
from robotcore.errors import Interrupted, UsageError

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


def _parse_release(value: str) -> str:
    from robotcore.deploy.agent.releases import require_name

    try:
        return require_name(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


@click.command("rollback", cls=DeployCommand)
@robot_argument
@click.argument("release", required=False, type=_parse_release)
def rollback(host: RobotAddress, release: str | None) -> int:
    """Run the last healthy release before the current one on HOST again, or RELEASE.

    The robot checks its health as after a push. If it is not healthy, the current release runs again. `robotcore deploy
    list` lists the releases.
    """
    from robotcore.cli.deploy._progress import StepDisplay
    from robotcore.deploy import health_progress

    with StepDisplay() as display:
        try:
            health_progress.rollback(host, release, display)
        except Interrupted:
            display.close()
            if display.step == health_progress.STEP:
                write_lines(health_progress.build_status_hint(host), is_error=True)
            raise
    return 0


@click.command("remove", cls=DeployCommand)
@robot_argument
@click.option("--recordings", is_flag=True, help="Remove the recordings too.")
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
def remove(host: RobotAddress, *, recordings: bool, yes: bool) -> int:
    """Stop the app on HOST and remove all that was deployed; keep the recordings unless --recordings."""
    from robotcore.deploy.robot_answers import RemoveAnswer

    what = "all releases and all recordings" if recordings else "all releases, but not the recordings"
    if not yes and not _confirm(f"Stop {host}, and remove {what}?"):
        write_line("Nothing was removed")
        return 1
    with make_link(host) as link:
        has_recordings = link.call("remove", RemoveAnswer, keeps_recordings=not recordings).has_recordings
    note = f". The recordings are still there: {host.format_command('fetch')}" if has_recordings else ""
    write_line(f"{host}: robotcore was removed{note}")
    return 0


def _confirm(question: str) -> bool:
    if not sys.stdin.isatty():
        raise UsageError(
            "remove asks for confirmation, but stdin is not a terminal. To remove without a question: --yes",
            kind="no-terminal",
        )
    return click.confirm(question, err=True)
