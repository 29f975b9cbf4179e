"""The options, the runs and the answers that the commands of ``robotcore calibrate`` share."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.options import backend_option, host_option, merge_options, port_option
from robotcore.cli.output import write_content, write_line, write_prompt
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.calibration.corrections import Correction
    from robotcore.calibration.excitation_runs import ExcitationRunner
    from robotcore.description.editing import RobotEditor
    from robotcore.hal.backend import Backend
    from robotcore.runtime.observer import Observer
    from robotcore.runtime.request import RunRequest
    from robotcore.runtime.result import RunResult

WORLD = "open"
"""The world of a calibration in a simulator."""

_OPTIONS = (
    click.option("--robot", required=True, help="The robot's .toml file, or the name of a robot."),
    click.option("--backend", required=True, help="The robot or simulator. List: `robotcore backends`."),
    click.option("--world", default=WORLD, show_default=True, help="The world of a simulator."),
    click.option("--write", is_flag=True, help="Write the corrections to the robot's file."),
    click.option(
        "--plot", metavar="FILE", type=click.Path(path_type=Path), help="Draw the measurement and its fit as a PNG."
    ),
    backend_option,
    host_option,
    port_option,
    click.option("--json", "as_json", is_flag=True, help="Print one line of JSON at the end, and nothing else."),
)


def calibration_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of a calibration to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


class CalibrationCommand(AnsweringCommand):
    """A command whose answer of a failure has the keys ``robot`` and ``backend``."""

    def build_failure_answer(self, parameters: Any, error: Any) -> dict[str, Any]:
        names = {key: parameters.get(key) or "" for key in ("robot", "backend")}
        return {**names, "error": str(error), "exit_status": error.exit_status}


class TerminalPerson:
    """The person at the terminal. Questions are written on stderr."""

    def prepare(self, instruction: str) -> None:
        write_line(instruction, is_error=True)
        self._read("Press Enter to start, or Ctrl-C to end")

    def ask(self, question: str) -> float:
        while True:
            answer = self._read(question).strip().replace(",", ".")
            with suppress(ValueError):
                if math.isfinite(number := float(answer)):
                    return number
            write_line(f"{answer!r} is not a number. Write a number such as 1.024", is_error=True)

    def _read(self, prompt: str) -> str:
        write_prompt(f"{prompt}: ")
        if not (line := sys.stdin.readline() if sys.stdin else ""):
            write_line(is_error=True)
            text = "the calibration needs an answer, but standard input has ended. Run the command in a terminal"
            raise UsageError(text, kind="no-answer")
        return line


class CalibrationSession:
    """The robot of a calibration, its backend, and the editor of its file."""

    def __init__(
        self,
        robot: str,
        backend: str,
        world: str,
        options: Sequence[tuple[str, str]],
        host: str | None,
        port: str | None,
        plot: Path | None,
        *,
        write: bool,
    ) -> None:
        """Check everything that can be checked before a motor turns.

        Raises UsageError for a file that cannot be written, and the errors of `CalibratedRobot.load`.
        """
        from robotcore.calibration.calibrated_robot import CalibratedRobot
        from robotcore.calibration.excitation_runs import ExcitationRunner
        from robotcore.description import is_own
        from robotcore.description.editing import RobotEditor
        from robotcore.hal.backend import load_backend
        from robotcore.view.page import require_writable

        if plot:
            require_writable(plot, "--plot")
        self.editor: RobotEditor | None = RobotEditor(robot) if write or is_own(robot) else None
        if self.editor and write:
            self.editor.require_writable()
        self.backend: Backend = load_backend(backend)
        self.backend.require_installed()
        found = merge_options(options, host=host, port=port)
        self.calibrated = CalibratedRobot.load(robot, self.backend, found)
        is_built = self.backend.builds_world(self.calibrated.description)
        self.runner: ExcitationRunner = ExcitationRunner(
            self.calibrated, perform_run, TerminalPerson(), world if is_built else None
        )
        self._must_write = write

    def finish(self, corrections: Sequence[Correction], *, as_json: bool) -> dict[str, Any]:
        """Write the diff and, if the user wants it, the file. Return the fields of the answer in JSON."""
        from robotcore.calibration.corrections import apply_corrections

        is_needed, is_written, diff = any(each.is_needed for each in corrections), False, ""
        if self.editor and is_needed:
            apply_corrections(self.editor, corrections)
            self.backend.check(self.editor.parse())
            diff = self.editor.diff
            if self._must_write:
                self.editor.write(self.backend.check)
                is_written = True
        if not as_json:
            self._write_diff(diff, is_needed=is_needed, is_written=is_written)
        return {"corrections": [each.to_dict() for each in corrections], "diff": diff, "is_written": is_written}

    def _write_diff(self, diff: str, *, is_needed: bool, is_written: bool) -> None:
        robot = self.calibrated.robot
        write_line()
        if not is_needed:
            write_line(f"{robot} agrees with the measurement. There is nothing to correct.")
        elif not self.editor:
            copy = f"my_{robot.replace('-', '_')}.toml"
            write_line(f"To correct a robot, copy its file: robotcore robots {robot} > {copy}")
            write_line(f"Then repeat this command with --robot {copy} --write.")
        else:
            write_content(diff)
            write_line()
            write_line(f"{robot} has been corrected." if is_written else f"Add --write to correct {robot}.")


def perform_run(request: RunRequest, observers: Sequence[Observer]) -> RunResult:
    """Perform a run. In a terminal, the space bar is the e-stop, and a line shows the progress."""
    from robotcore.cli.estop_key import EmergencyStopKey, can_listen
    from robotcore.runtime.session import run

    with ExitStack() as stack:
        in_terminal: list[Any] = []
        key = stack.enter_context(closing(EmergencyStopKey())) if can_listen() else None
        if key:
            in_terminal.append(key)
        if sys.stderr and sys.stderr.isatty():
            from robotcore.view.progress import ProgressLine

            in_terminal.append(stack.enter_context(closing(ProgressLine(hint=key.get_hint if key else str))))
        return run(request, [*in_terminal, *observers])
