"""Performs the runs of ``robotcore calibrate motors`` and ``robotcore calibrate drive``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotcore.calibration.excitation_runs import ExcitationRunner
    from robotcore.cli.robot_session import RobotSession
    from robotcore.runtime.observer import Observer
    from robotcore.runtime.request import RunRequest
    from robotcore.runtime.result import RunResult


def build_runner(session: RobotSession) -> ExcitationRunner:
    """Return what drives the robot of a session by plans of commands.

    Raises BackendMissingError for a backend that is not installed, and the errors of `CalibratedRobot.load`.
    """
    from robotcore.calibration.calibrated_robot import CalibratedRobot
    from robotcore.calibration.excitation_runs import ExcitationRunner

    session.backend.require_installed()
    robot = CalibratedRobot.load(session.robot, session.backend, session.options)

    def perform(request: RunRequest, observers: Sequence[Observer]) -> RunResult:
        session.note_simulated_file()
        return perform_run(request, observers)

    return ExcitationRunner(robot, perform, session.person, session.world, session.seed)


def perform_run(request: RunRequest, observers: Sequence[Observer]) -> RunResult:
    """Perform a run. In a terminal, the space bar is the e-stop, and a line shows the progress."""
    from robotcore.cli.estop_key import NO_ESTOP_KEY_NOTE, EmergencyStopKey, can_listen, is_estop_key_missing
    from robotcore.cli.output import write_line
    from robotcore.runtime.session import run

    with ExitStack() as stack:
        in_terminal: list[Any] = []
        key = stack.enter_context(closing(EmergencyStopKey())) if can_listen() else None
        if key:
            in_terminal.append(key)
        if is_estop_key_missing():
            write_line(f"note: {NO_ESTOP_KEY_NOTE}", is_error=True)
        if sys.stderr and sys.stderr.isatty():
            from robotcore.view.progress import ProgressLine

            in_terminal.append(stack.enter_context(closing(ProgressLine(hint=key.get_hint if key else str))))
        return run(request, [*in_terminal, *observers])
