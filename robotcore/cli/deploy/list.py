"""``robotcore deploy list``: list the releases on a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.deploy._options import AnsweringDeployCommand, make_link, robot_argument
from robotcore.cli.output import as_json, write_json, write_line, write_table

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress
    from robotcore.deploy.robot_answers import ListedRelease, ReleasesAnswer, UnreadableRelease


SKIPPED = ": skipped"
"""The end of a skipped check's line in the manifest."""

COLUMNS = ("release", "state", "app", "robot", "from", "checks")


@click.command("list", cls=AnsweringDeployCommand)
@robot_argument
@as_json
def command(host: RobotAddress, *, as_json: bool) -> int:
    """List the releases on HOST, the newest first, and the checks that each passed before it was sent."""
    from robotcore.deploy.robot_answers import ReleasesAnswer

    with make_link(host) as link:
        found = link.call("releases", ReleasesAnswer)
    if as_json:
        write_json(_build_answer(host, found))
    elif found.releases:
        write_table(COLUMNS, [_build_row(each, found.current) for each in found.releases])
    else:
        write_line(f"{host}: no release is on the robot. {host.format_command('push')}")
    return 0


def _build_answer(host: RobotAddress, found: ReleasesAnswer) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore deploy list``.

    The JSON keys:

    host: text; the robot's address.
    releases: list of objects; the releases on the robot, the newest first.
    releases[].*: robotcore.deploy.agent.releases.Release
    releases[].*: robotcore.deploy.robot_answers.UnreadableRelease
    *: robotcore.deploy.robot_answers.ReleasesAnswer
    exit_status: whole number; the exit status.
    """
    return {"host": str(host), **found.model_dump(by_alias=True), "exit_status": 0}


def _build_row(release: ListedRelease | UnreadableRelease, current: str | None) -> list[str]:
    from robotcore.deploy.robot_answers import UnreadableRelease

    if isinstance(release, UnreadableRelease):
        return [release.name, f"cannot be read: {release.unreadable}", "", "", "", ""]
    state = ", ".join(word for word in ("current" if release.name == current else "", release.outcome or "") if word)
    sender = " ".join(part for part in (release.sender, release.revision) if part)
    return [release.name, state, release.app, release.robot, sender, _format_checks(release.checks)]


def _format_checks(checks: Sequence[str]) -> str:
    return "\n".join(line for line in checks if not line.endswith(SKIPPED)) or "nothing"
