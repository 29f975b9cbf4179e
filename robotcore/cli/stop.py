"""``robotcore stop``: every motor of a robot made to stand, by a process that has nothing of it open."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from robotcore.cli.options import connection_options, merge_options
from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.hal.backend import Backend, Setup


@click.command("stop")
@click.option("--backend", "name", required=True, help="What the robot runs on, such as raspberrypi.")
@click.option("--robot", default="rover", show_default=True, help="A robot's name, or its .toml file.")
@connection_options
def command(name: str, robot: str, port: str | None, options: tuple[tuple[str, str], ...]) -> int:
    """Make every motor of a robot stand, from any process.

    Nothing is opened but what stops them. No program is ended for it: what one that lives still holds is named, and the
    exit status is 3. A backend whose motors turn no longer than their run has nothing to stop.
    """
    from robotcore.hal.backend import load_backend

    backend = load_backend(name)
    backend.require_installed()
    return _stop(backend, _setup(backend, robot, merge_options(port, options)))


def _setup(backend: Backend, robot: str, options: dict[str, str]) -> Setup:
    """Return the robot with its motors alone: nothing else of it is asked how it stops."""
    from robotcore.description import MotorDescription
    from robotcore.hal.backend import Setup

    described = backend.load_robot(robot, options)
    motors = frozenset(device.name for device in described.devices if isinstance(device, MotorDescription))
    return Setup(described, None, motors, options=options)


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
    for words in report.messages:
        write_line(f"{setup.robot.name}: {words}")
    if report.failed:
        raise BackendError("\n".join(f"CANNOT STOP {fault}. Cut the motors' supply" for fault in report.failed))
    return 0
