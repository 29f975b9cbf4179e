"""``robotcore stop`` stops every motor of a robot, even while another program drives it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from robotcore.cli.options import connection_options, merge_options
from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.hal.backend import Backend, Setup


@click.command("stop")
@click.option("--backend", "name", required=True, help="The robot's backend, such as raspberrypi.")
@click.option("--robot", default="rover", show_default=True, help="A robot's name, or its .toml file.")
@connection_options
def command(name: str, robot: str, port: str | None, options: tuple[tuple[str, str], ...]) -> int:
    """Stop every motor of a robot, even during a run.

    Uses only the outputs that stop the motors, and ends no program. If another program blocks such an output, prints
    its name and exits with status 3. In a simulator there is nothing to stop.
    """
    from robotcore.hal.backend import load_backend

    backend = load_backend(name)
    backend.require_installed()
    return _stop(backend, _build_motor_setup(backend, robot, merge_options(port, options)))


def _build_motor_setup(backend: Backend, robot: str, options: dict[str, str]) -> Setup:
    from robotcore.description import MotorDescription
    from robotcore.hal.backend import Setup

    description = backend.load_robot(robot, options)
    motors = frozenset(device.name for device in description.devices if isinstance(device, MotorDescription))
    return Setup(description, None, motors, options=options)


def _stop(backend: Backend, setup: Setup) -> int:
    from robotcore.errors import BackendError
    from robotcore.safety.guardian.process import stop_once

    cutoffs = backend.cutoffs(setup)
    if not cutoffs:
        write_line(f"{setup.robot.name}: nothing to stop on {backend.name}")
        return 0
    report = stop_once(cutoffs)
    if report.done:
        write_line(f"{setup.robot.name}: stopped {', '.join(report.done)}")
    for message in report.messages:
        write_line(f"{setup.robot.name}: {message}")
    if report.failed:
        message = "\n".join(f"CANNOT STOP {failure}. Cut the motors' supply" for failure in report.failed)
        raise BackendError(message, kind="motors-not-stopped")
    return 0
