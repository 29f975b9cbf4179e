"""Runs excitations on a robot, and measures how far it has moved, by a person or by the ground truth of a simulator."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple, Protocol

from robotcore.calibration.calibrated_robot import EXCITATION_KINDS, CalibratedRobot
from robotcore.calibration.excitation import Excitation, ExcitationStep, TruePoseObserver
from robotcore.description import Drive
from robotcore.errors import CalibrationError
from robotcore.runtime.observer import Observer
from robotcore.runtime.request import RunRequest
from robotcore.runtime.result import Outcome, RunResult

RATE_HZ = 100.0
"""The number of ticks in a second of an excitation."""

REST_S = 0.2
"""The rest before a drive, in seconds."""

MAX_DISTANCE_M = 100.0
"""The greatest distance that a person can have measured, in metres."""

SPARE_S = 5.0
"""The time limit of a run is this much longer than the plan, in seconds."""


class Displacement(NamedTuple):
    """The displacement of a robot by a drive, in its frame before the drive."""

    forward_m: float
    """The distance forward, in metres; negative backward."""
    left_m: float
    """The distance to the left, in metres; negative to the right."""


class Person(Protocol):
    """The person beside a real robot."""

    def prepare(self, instruction: str, *, has_question: bool = False) -> None:
        """Ask the person to prepare the robot, and wait until it is done. Raises UsageError if there is no person.

        has_question: whether `ask` follows after the robot has moved, so that a person must be there.
        """

    def ask(self, question: str, most: float = 360.0) -> float:
        """Return the number that the person has measured, from -``most`` to ``most``.

        most: the greatest plausible number; by default that of an angle in degrees.
        """


Perform = Callable[[RunRequest, Sequence[Observer]], RunResult]
"""A function that performs a run, such as `robotcore.run`."""


class ExcitationRunner:
    """Runs the excitations of a calibration.

    robot: the robot.
    perform: performs a run.
    person: the person who prepares a real robot and measures; a simulator needs none.
    world: the name or the file of the world of a simulator.
    seed: the seed of the runs.
    """

    rate_hz = RATE_HZ

    def __init__(
        self, robot: CalibratedRobot, perform: Perform, person: Person, world: str | None, seed: int | None = None
    ) -> None:
        self.robot, self._perform, self.person = robot, perform, person
        self._world, self._seed = world, seed

    @property
    def drive(self) -> Drive:
        """The description of the drive."""
        assert self.robot.description.drive
        return self.robot.description.drive

    def excite(
        self,
        steps: Sequence[ExcitationStep],
        observers: Sequence[Observer] = (),
        *,
        takes_duties: bool = True,
        kinds: Collection[str] = EXCITATION_KINDS,
    ) -> Excitation:
        """Drive the robot by a plan of commands, and return the excitation.

        takes_duties: whether the commands are duties if the motors have models. Otherwise they are velocities.
        kinds: the kinds of the devices to open.

        Raises the error that ended the run.
        """
        full_rad_s = self.robot.full_rad_s if takes_duties else self.robot.max_velocity_rad_s
        excitation = Excitation(steps, full_rad_s)
        with self.robot.open_file(takes_duties=takes_duties, kinds=kinds) as file:
            request = RunRequest(
                excitation,
                self.robot.backend.name,
                file,
                self._world,
                self._seed,
                self.rate_hz,
                excitation.duration_s + SPARE_S,
                options=self.robot.options,
            )
            result = self._perform(request, observers)
        if result.error:
            raise result.error
        if result.outcome is not Outcome.SUCCESS:
            text = f"the measurement did not reach its end: {result.headline}. Repeat the command"
            raise CalibrationError(text, kind="unfinished", outcome=result.outcome.value)
        return excitation

    def drive_straight(
        self, command: float, duration_s: float, settle_s: float, title: str, *, takes_duties: bool = True
    ) -> tuple[Displacement, Excitation]:
        """Drive with one command for all wheels, and return how far the robot has moved, with the excitation.

        command: the share of the full command.
        settle_s: the rest after the drive, in seconds.
        title: the words for this drive, such as ``drive 1 of 4``.
        takes_duties: as in `excite`.
        """
        direction = "forward" if command > 0 else "backward"
        instruction = (
            f"{title}, {direction}. Put the robot along a straight line on the floor, with a tape measure beside it, "
            "and mark the middle of its axle"
        )
        self.prepare(instruction, has_question=True)
        observer = TruePoseObserver()
        steps = [ExcitationStep(REST_S), ExcitationStep(duration_s, command, command), ExcitationStep(settle_s)]
        excitation = self.excite(steps, [observer], takes_duties=takes_duties)
        if moved := self.read_displacement(observer):
            return moved, excitation
        along = self.person.ask(
            f"{title}: the distance that the middle of the axle has moved along the line, in metres", MAX_DISTANCE_M
        )
        beside = self.person.ask(f"{title}: its distance from the line in metres, positive to the left", MAX_DISTANCE_M)
        return Displacement(along if command > 0 else -abs(along), beside), excitation

    def read_displacement(self, observer: TruePoseObserver) -> Displacement | None:
        """Return how far a simulated robot has moved by its ground truth; None on a real robot."""
        return Displacement(*observer.displacement) if observer.displacement else None

    def read_turn(self, observer: TruePoseObserver) -> float | None:
        """Return by how much a simulated robot has turned by its ground truth, in radians; None on a real robot."""
        return None if observer.start is None else observer.turned

    def prepare(self, instruction: str, *, has_question: bool = False) -> None:
        """Ask the person to prepare a real robot, and wait until it is done. See `Person.prepare`."""
        if not self.robot.is_simulated:
            self.person.prepare(instruction, has_question=has_question)
