"""``robotcore deploy push``: put a project on a robot and keep it running there."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.deploy._options import DeployCommand, robot_argument
from robotcore.cli.options import parse_pair
from robotcore.cli.output import write_lines
from robotcore.deploy.agent.releases import HEALTHY_WITHIN_S
from robotcore.deploy.agent.systemd_units import START_LIMIT_S

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress
    from robotcore.deploy.project import Project


PROJECT_FOLDER = click.Path(path_type=Path, exists=True, file_okay=False)


@click.command("push", cls=DeployCommand)
@robot_argument
@click.option(
    "--project", "folder", metavar="DIR", type=PROJECT_FOLDER, help="The project's folder. Default: the current folder."
)
@click.option("--app", help="An app's name or file. Default: the project's.")
@click.option("--robot", help="A robot's name or .toml file. Default: the project's.")
@click.option("--world", help="The world of the simulation check. Default: the project's.")
@click.option("--backend", help="The backend on the robot. Default: the project's, or raspberrypi.")
@click.option("--set", "settings", metavar="KEY=VALUE", type=parse_pair, multiple=True, help="A setting of the app.")
@click.option(
    "--option", "options", metavar="KEY=VALUE", type=parse_pair, multiple=True, help="An option of the backend."
)
@click.option("--rate", "rate_hz", metavar="HZ", type=float, help="Ticks a second.")
@click.option("--seeds", help="Seeds of the simulation check: 1-3, or 1,5,9-12.")
@click.option(
    "--require", metavar="BOUND", multiple=True, help='A bound that the simulation check must reach: "verified>=1".'
)
@click.option("--no-record", is_flag=True, help="Do not record runs on the robot.")
@click.option("--record-last", metavar="DURATION", help="Keep this end of each run on the robot: 10min, or all.")
@click.option("--view", "has_view", is_flag=True, help="Run the app with a live page, for `robotcore deploy view`.")
@click.option("--rt", "is_real_time", is_flag=True, help="Give the app's ticks real-time priority.")
@click.option("--skip-checks", is_flag=True, help="Skip the tests, the check and the simulation.")
@click.option("--offline", is_flag=True, help="Send the wheels too, for a robot without a network.")
@click.option(
    "--healthy-within",
    "healthy_within_s",
    metavar="SECONDS",
    type=click.FloatRange(1, START_LIMIT_S),
    default=HEALTHY_WITHIN_S,
    show_default=True,
    help="Roll back if the app has not completed its first tick within this time.",
)
def command(
    host: RobotAddress,
    *,
    skip_checks: bool,
    offline: bool,
    healthy_within_s: float,
    **chosen: Any,
) -> int:
    """Put the project in this folder on HOST, and keep it running there.

    Connects to HOST, then runs the project's tests, checks its descriptions and runs its app in simulation before it
    sends anything. The robot rolls back a release that is not healthy.

    Exit status: 0 the release is healthy, 1 a check failed or the release was rolled back, 2 wrong usage, 3 the robot
    cannot be reached or refuses the release, 128 + the signal's number if interrupted.
    """
    from robotcore.cli.deploy._progress import StepDisplay
    from robotcore.deploy.health_progress import STEP
    from robotcore.deploy.push import PushRequest, describe_state_after, push
    from robotcore.errors import Interrupted, RobotcoreError

    request = PushRequest(
        host,
        _build_project(**chosen),
        is_checked=not skip_checks,
        is_offline=offline,
        healthy_within_s=healthy_within_s,
    )
    with StepDisplay() as display:
        try:
            push(request, display)
        except (Interrupted, RobotcoreError) as error:
            display.close()
            if display.step != STEP or isinstance(error, Interrupted):  # else the error says what runs
                write_lines(describe_state_after(display.step, request), is_error=True)
            raise
    return 0


def _build_project(
    settings: tuple[tuple[str, str], ...],
    options: tuple[tuple[str, str], ...],
    require: tuple[str, ...],
    *,
    no_record: bool,
    **chosen: Any,
) -> Project:
    from robotcore.deploy.project import DeployOptions, build_project

    return build_project(
        DeployOptions(
            **chosen,
            settings=dict(settings),
            options=dict(options),
            require=require or None,
            record=False if no_record else None,
        )
    )
