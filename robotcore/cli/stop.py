"""``robotcore stop`` stops every motor of a robot, even while another program drives it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import backend_option, merge_options, port_option, refuse_without
from robotcore.cli.output import write_line
from robotcore.errors import BackendError, BackendMissingError, UsageError

if TYPE_CHECKING:
    from robotcore.hal.backend import Backend, Setup
    from robotcore.runtime.active_runs import ActiveRun

END_S = 5.0
"""The longest wait for the end of a run, in seconds. Its motors stand long before its devices are closed."""


@click.command("stop")
@click.option("--backend", "name", help="The robot's backend, such as raspberrypi.")
@click.option("--robot", help="A robot's name, or its .toml file. With --backend, the default is rover.")
@port_option
@backend_option
def command(name: str | None, robot: str | None, port: str | None, options: tuple[tuple[str, str], ...]) -> int:
    """Stop every motor of a robot, even during a run.

    Without --backend, ends your runs that drive a robot on this machine, and stops the motors. A run that does not end
    within 5 s is killed. If there is no run, stops the robot that the pyproject.toml in this folder names.

    With --backend, uses only the outputs that stop the motors, and ends no program. If another program blocks such an
    output, prints its name and exits with status 3. In a simulator there is nothing to stop.
    """
    if name is not None:
        return _stop(name, robot or "rover", merge_options(options, port=port))
    remedy = "Add the robot's backend, such as --backend raspberrypi"
    refuse_without("--backend", remedy, robot=robot is not None, port=port is not None, option=bool(options))
    from robotcore.runtime.active_runs import list_active_runs

    runs = list_active_runs()
    return _end_runs(runs) if runs else _stop_robot_of_project()


def _end_runs(runs: list[ActiveRun]) -> int:
    """End runs, and stop the motors of their robots. A failure for one robot does not prevent the stop of another."""
    from robotcore.runtime.active_runs import end_runs

    killed = end_runs(runs, END_S)
    failures: list[Exception] = []
    for run in runs:
        state = f"was killed, because it had not ended within {END_S:g} s" if run in killed else "has ended"
        try:
            _stop(run.backend, run.robot, run.options)
            write_line(f"process {run.process}: its run of {run.robot} on {run.backend} {state}")
        except Exception as failure:  # noqa: BLE001  the other robots must be stopped too
            failures.append(failure)
    if len(failures) > 1:
        raise BackendError("\n".join(map(str, failures)), kind="motors-not-stopped") from failures[0]
    if failures:
        raise failures[0]
    return 0


def _stop_robot_of_project() -> int:
    from pathlib import Path

    from robotcore.deploy.project import FILE, read_tables
    from robotcore.description import is_own
    from robotcore.hal.backend import load_backend

    folder = Path.cwd()
    table = read_tables(folder).robotcore
    if table is None or table.robot is None:
        raise UsageError(
            f"you have no run that drives a robot on this machine, and no {FILE} in this folder names a robot. Name "
            "the robot: robotcore stop --backend raspberrypi --robot FILE.toml. To stop a robot that you deployed to: "
            "robotcore deploy stop HOST",
            kind="nothing-runs",
        )
    name = table.deploy.backend
    robot = str(folder / table.robot) if is_own(table.robot) else table.robot
    try:
        status = _stop(name, robot, table.deploy.options)
    except BackendError as error:
        if "ModuleNotFoundError" not in str(error) or load_backend(name).is_native_host:
            raise
        raise BackendMissingError(
            f"you have no run that drives a robot on this machine, and it cannot reach the motors of {table.robot}, "
            f"the robot of {FILE}: libraries of the backend {name!r} are not installed here. To stop a robot that you "
            "deployed to: robotcore deploy stop HOST"
        ) from error
    write_line(
        f"You have no run that drives a robot on this machine, so the robot of {FILE} was stopped: {table.robot} on "
        f"{name}. To stop a robot that you deployed to: robotcore deploy stop HOST"
    )
    return status


def _stop(name: str, robot: str, options: Mapping[str, Any]) -> int:
    from robotcore.hal.backend import load_backend

    backend = load_backend(name)
    backend.require_installed()
    return _stop_motors(backend, _build_motor_setup(backend, robot, options))


def _build_motor_setup(backend: Backend, robot: str, options: Mapping[str, Any]) -> Setup:
    from robotcore.hal.backend import Setup
    from robotcore.kinds.motor import MotorDescription

    description = backend.load_robot(robot, options)
    motors = frozenset(device.name for device in description.devices if isinstance(device, MotorDescription))
    return Setup(description, None, motors, options=options)


def _stop_motors(backend: Backend, setup: Setup) -> int:
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
