"""The options and the course of a command that measures a robot, and corrects the robot's file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.options import Command, backend_option, host_option, merge_options, port_option
from robotcore.cli.output import as_json, redirect_prints, write_error, write_json, write_line
from robotcore.cli.person import TerminalPerson
from robotcore.cli.robot_changes import RobotChanges
from robotcore.errors import Interrupted, RobotcoreError

if TYPE_CHECKING:
    from robotcore.description import DeviceDescription, RobotDescription
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.runtime.needs import Need
    from robotcore.view.chart import Chart

BENCH, OPEN = "bench", "open"
"""The worlds of simulators without --world: things in view of the sensors, and space to drive."""

TRUTH = "truth"
"""The option of virtualpi that names the file of the simulated robot."""

PLOT = "--plot"

_ANSWER = "robotcore.measured_answer"
"""The key of a context's `meta` for the answer of a command that an error has ended."""


def robot_session_options(world: str, *, has_plot: bool = True) -> Callable[[Command], Command]:
    """Add the options of a command that measures a robot. They are the arguments of `RobotSession`.

    world: the world of simulators without --world.
    has_plot: whether the command has the option --plot.
    """
    plot = click.option(
        PLOT, metavar="FILE.png", type=click.Path(path_type=Path), help="Draw the measurements and the fits."
    )
    options = (
        click.option("--robot", required=True, help="The robot's .toml file, or the name of a robot."),
        click.option("--backend", required=True, help="The robot or simulator. List: `robotcore backends`."),
        click.option("--world", help=f"A world's name, or its .toml file. Default in simulators: {world}."),
        click.option("--seed", type=int, help="The seed of the world's random variations, and of the noise."),
        backend_option,
        host_option,
        port_option,
        click.option("--yes", "is_confirmed", is_flag=True, help="Do not wait for Enter before the robot moves."),
        click.option("--write", "is_writing", is_flag=True, help="Write the results to the robot's file."),
        *([plot] if has_plot else []),
        as_json,
    )

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


class MeasuringCommand(AnsweringCommand):
    """A command that measures a robot.

    If an error ends the command, its answer in JSON also has the names of the robot and the backend, and what was
    measured before.
    """

    def build_failure_answer(
        self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted
    ) -> dict[str, Any]:
        """Return the JSON answer of a command that failed.

        The JSON keys:

        robot: text; the name of the robot.
        backend: text; the name of the backend.
        *: robotcore.cli.robot_changes.RobotChanges.to_dict
        exit_status: whole number; the exit status.
        *: robotcore.cli.command_classes.AnsweringCommand.build_failure_answer
        """
        names = {key: parameters.get(key) or "" for key in ("robot", "backend")}
        context = click.get_current_context(silent=True)
        measured = context.meta.get(_ANSWER, {}) if context else {}
        return {**names, **measured, **super().build_failure_answer(parameters, error)}


class RobotSession:
    """The robot that a command measures, with its backend, the person beside it, and the changes of its file.

    The arguments are the values of `robot_session_options`.

    default_world: the world of simulators without --world.

    Raises the errors of loading a robot and a backend, and UsageError for files that cannot be written.
    """

    def __init__(
        self,
        robot: str,
        backend: str,
        world: str | None,
        seed: int | None,
        options: tuple[tuple[str, str], ...],
        host: str | None,
        port: str | None,
        *,
        is_confirmed: bool,
        is_writing: bool,
        as_json: bool,
        plot: Path | None = None,
        default_world: str = BENCH,
    ) -> None:
        from robotcore.hal.backend import Capability, load_backend

        if plot:
            from robotcore.view.page import require_writable

            require_writable(plot, PLOT)
        self.robot, self.seed, self.as_json = robot, seed, as_json
        self.options = merge_options(options, host=host, port=port)
        self.backend = load_backend(backend)
        self.description = self.backend.load_robot(robot, self.options)
        self.changes = RobotChanges(robot, is_writing=is_writing)
        self.world = world or (default_world if self.backend.builds_world(self.description) else None)
        self.is_simulated = Capability.POSE in self.backend.capabilities
        """Whether the backend is a simulator that has the true pose of the robot."""
        self.person = TerminalPerson(is_confirmed=is_confirmed)
        self.charts: list[Chart] = []
        """The charts for --plot."""
        self.error: RobotcoreError | Interrupted | None = None
        """The error that has ended `measure`."""
        self.simulates_file = self.is_simulated and self.backend.builds_world(self.description)
        """Whether the simulated robot is that of a file, and not that of an existing scene."""
        self._plot, self._has_noted = plot, False

    def find_device(self, kind: str, name: str | None) -> Any:
        """Return the description of a device of a kind: the one with a name, or the first one.

        Raises UsageError if the robot has none, and UnknownNameError if it has none with this name.
        """
        from robotcore.errors import UnknownNameError, UsageError

        words = kind.replace("_", " ")
        found = {device.name: device for device in self.description.all_of(kind)}
        if not found:
            text = f'{self.description.source} has no {words}. Add one: [[devices]] with kind = "{kind}"'
            raise UsageError(text, kind=f"no-{words.replace(' ', '-')}")
        if name is not None and name not in found:
            raise UnknownNameError(words, name, list(found))
        return found[name] if name else next(iter(found.values()))

    def change_device(self, device: DeviceDescription, **values: Any) -> None:
        """Set the keys of a device's table whose values differ from those of its description."""
        if different := {key: value for key, value in values.items() if value != getattr(device, key)}:
            self.changes.set_device(device.name, **different)

    def note_simulated_file(self) -> None:
        """Write once on stderr if a simulator simulates the robot of the same file, so that the file always agrees."""
        if self._has_noted or not self.simulates_file or self.options.get(TRUTH):
            return
        self._has_noted = True
        backend = "" if self.has_truth_option else "--backend virtualpi "
        write_line(
            f"note: {self.backend.name} simulates the robot of the same file, so the measurement compares {self.robot} "
            f"with itself. To simulate a robot that differs from its file: {backend}--option {TRUTH}=FILE",
            is_error=True,
        )

    @property
    def has_truth_option(self) -> bool:
        """Whether the backend is a simulator that can simulate the robot of another file, by the option ``truth``."""
        from robotcore.hardware import HardwareBackend

        return self.is_simulated and isinstance(self.backend, HardwareBackend)

    def load_true_robot(self) -> RobotDescription:
        """Return the description of the robot that a simulator simulates. Raises the errors of loading a robot."""
        from robotcore.description import load_robot

        truth = self.options.get(TRUTH)
        return load_robot(truth) if truth and self.has_truth_option else self.description

    def prepare(self, instruction: str) -> None:
        """Ask the person to prepare a real robot, and wait until it is done. See `TerminalPerson.prepare`."""
        if not self.is_simulated:
            self.person.prepare(instruction)

    @contextmanager
    def open(
        self,
        *,
        rate_hz: float = 20.0,
        needs: AbstractSet[Need] = frozenset(),
        wants: AbstractSet[Need] = frozenset(),
        has_separate_motors: bool = False,
    ) -> Iterator[LiveRobot]:
        """Open the robot, and close it at the end of the ``with`` block.

        In a terminal, the space bar stops every motor and ends the session at any time, also at a question.

        needs: the devices to open. It is an error if the robot lacks one of them.
        wants: the devices to open if the robot has them.

        Raises the errors of `robotcore.open`.
        """
        self.note_simulated_file()
        from robotcore.cli.estop_key import NO_ESTOP_KEY_NOTE, EmergencyStopKey, can_listen, is_estop_key_missing
        from robotcore.interactive.live_app import LiveApp
        from robotcore.interactive.opening import LONGEST_S, open_request
        from robotcore.runtime.request import RunRequest

        request = RunRequest(
            LiveApp(needs, wants),
            self.backend.name,
            self.robot,
            self.world,
            self.seed,
            rate_hz,
            timeout_s=LONGEST_S,
            options=self.options,
            has_separate_motors=has_separate_motors,
        )
        with ExitStack() as stack:
            key = stack.enter_context(closing(EmergencyStopKey())) if can_listen() else None
            live = stack.enter_context(open_request(request, [key] if key else []))
            if key and (hint := key.get_hint()):
                write_line(f"{hint} every motor", is_error=True)
            if is_estop_key_missing():
                write_line(f"note: {NO_ESTOP_KEY_NOTE}", is_error=True)
            self.person.check = live.require_running
            yield live

    def measure(self, work: Callable[[], object]) -> None:
        """Call a function that measures. `finish` raises the error that ends it, after the results of before."""
        with redirect_prints(as_json=self.as_json):
            try:
                work()
            except (RobotcoreError, Interrupted) as error:
                self.error = error

    def finish(
        self,
        subject: str,
        answer: Mapping[str, Any],
        write_results: Callable[[], object],
        *,
        find_status: Callable[[], int] = lambda: 0,
        is_right: bool = True,
    ) -> int:
        """Write the changed file, the charts and the results, and return the exit status.

        subject: the words for what was measured, for the heading of the charts.
        answer: the fields of the results for JSON.
        write_results: writes the results as text.
        find_status: returns the exit status, after the file was written.
        is_right: whether the robot's file is right if there are no changes.

        Raises the error that has ended `measure`, also if a file cannot be written.
        """
        if stand_ins := self.changes.changed_devices & {*self.backend.list_stand_ins(self.description)}:
            text = f"{self.backend.name} does not run the driver of {', '.join(sorted(stand_ins))}, and has measured"
            self.changes.refuse(f"{text} a device of its own")
        self._try(partial(self.changes.finish, self.backend))
        has_plot = self._try(partial(self._save_charts, subject))
        status = find_status()
        names = {"robot": self.description.name, "backend": self.backend.name}
        whole = {**names, **answer, **self.changes.to_dict()}
        if self.error:
            click.get_current_context().meta[_ANSWER] = whole
        elif self.as_json:
            write_json({**whole, "exit_status": status})
        if not self.as_json:
            write_results()
            self.changes.show(is_right=is_right and not self.error)
            if self._plot and self.charts and has_plot:
                write_line(f"The plot: {self._plot}")
        if self.error:
            raise self.error
        return status

    def _try(self, work: Callable[[], object]) -> bool:
        """Call a function. Return False if it fails. `finish` raises the first error, and the others are written."""
        try:
            work()
        except RobotcoreError as error:
            if self.error:
                write_error(error)
            else:
                self.error = error
            return False
        return True

    def _save_charts(self, subject: str) -> None:
        if self._plot and self.charts:
            from robotcore.view.chart import save_charts

            heading = f"{subject} of {self.description.name} on {self.backend.name}"
            save_charts(self._plot, heading, self.charts, PLOT)
