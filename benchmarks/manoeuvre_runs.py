"""Runs of manoeuvres on a field without obstacles, and their errors by the true poses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar, NamedTuple

from robotcore import Behaviour, Robot, Role, Status, arc, straight, turn
from robotcore.description import Conditions, Floor, RobotDescription, Start, WorldDescription
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.truth import TruthSource
from robotcore.runtime.layers.assembly import assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import needed_devices
from robotcore.runtime.trace import TickRecord

FIELD = WorldDescription(name="field", floor=Floor(length_m=60.0, width_m=60.0), start=Start())
SAME_RAD_S = 1e-6
"""Velocities and changes that exceed a limit by less are rounding errors, in rad/s."""


class Manoeuvre(NamedTuple):
    """A manoeuvre with its values."""

    name: str
    values: tuple[float, ...]

    def build_routine(self, robot: Robot) -> Iterator[None]:
        """Return the routine that drives the manoeuvre."""
        match self.name, self.values:
            case "straight", (distance,):
                return straight(robot, distance)
            case "turn", (angle,):
                return turn(robot, angle)
        return arc(robot, *self.values)

    def locate_end(self, start: Pose) -> Pose:
        """Return the commanded pose at the end."""
        match self.name, self.values:
            case "straight", (distance,):
                return start.advance(distance, 0.0)
            case "turn", (angle,):
                return start.advance(0.0, angle)
        radius, angle = self.values
        return start.advance(radius * abs(angle), angle)


class Errors(NamedTuple):
    """The errors of a manoeuvre."""

    distance: float
    """The distance from the commanded end, in metres."""
    angle: float
    """The error of the heading, in rad."""
    overshoot: float
    """How far the robot was beyond the end, divided by the way."""
    seconds: float
    """The duration in seconds."""


class Run(NamedTuple):
    """The measurements of a run of several manoeuvres."""

    errors: list[Errors]
    closing: float
    """The distance from the start to the end of the run, in metres."""
    excesses: int
    """The number of commands that exceed the limits of the drive."""


class MeasuredManoeuvres(Behaviour):
    """Drives manoeuvres one after the other, and measures their errors."""

    needs: ClassVar = {Role.DRIVE}

    def __init__(self, manoeuvres: list[Manoeuvre], truth: TruthSource) -> None:
        self._manoeuvres, self._truth = manoeuvres, truth
        self._start = truth.pose()
        self._routine: Iterator[None] = iter(())
        self._way: list[Pose] = []
        self.errors: list[Errors] = []
        self.closing = 0.0

    def step(self, robot: Robot) -> Status:
        self._routine = self._routine if self._way else self._drive(robot)
        self._way.append(self._truth.pose())
        for _ in self._routine:
            return Status.RUNNING
        self.closing = self._start.distance_to(*self._truth.pose()[:2])
        return Status.SUCCESS

    def _drive(self, robot: Robot) -> Iterator[None]:
        for manoeuvre in self._manoeuvres:
            self._way, began = [self._truth.pose()], robot.clock.now()
            yield from manoeuvre.build_routine(robot)
            self.errors.append(compute_errors(manoeuvre, self._way, robot.clock.now() - began))


class LimitCheck:
    """Counts the commands that exceed the limits of a drive."""

    def __init__(self, robot: RobotDescription, rate_hz: float) -> None:
        assert robot.drive
        motors = [motor for motor in robot.all_of("motor") if motor.name in robot.drive.motors]
        self._velocity = min(motor.max_velocity_rad_s for motor in motors)
        self._change = (robot.drive.max_acceleration_rad_s2 or math.inf) / rate_hz
        self._is_steered, self._last = bool(robot.min_turn_radius_m), Wheels(0.0, 0.0)
        self.excesses = 0

    def __call__(self, record: TickRecord) -> None:
        sent, last = record.sent or self._last, self._last
        changes = [abs(new - old) for new, old in zip(sent, last, strict=True)]
        change = abs(sum(sent) - sum(last)) / 2 if self._is_steered else max(changes)
        fastest = max(map(abs, sent))
        self.excesses += fastest > self._velocity + SAME_RAD_S or change > self._change + SAME_RAD_S
        self._last = sent


def measure_run(
    robot: RobotDescription,
    backend: str,
    rate_hz: float,
    manoeuvres: list[Manoeuvre],
    gains: tuple[float, float] = (1.0, 1.0),
) -> Run:
    """Drive manoeuvres one after the other. ``gains`` are those of the left and the right wheel."""
    opener = load_backend(backend)
    raw = opener.open(Setup(robot, FIELD, needed_devices(robot, [Role.DRIVE]), rate_hz))
    assert raw.truth, f"{backend} does not provide the true pose"
    app, check = MeasuredManoeuvres(manoeuvres, raw.truth), LimitCheck(robot, rate_hz)
    conditions = Conditions(wheel_gain_left=gains[0], wheel_gain_right=gains[1])
    try:
        assembled = assemble(raw, robot, rate_hz, conditions=conditions, encoder_rate_hz=opener.encoder_rate_hz)
        Loop(assembled, app, rate_hz, math.inf, [check]).run()
    finally:
        raw.close()
    return Run(app.errors, app.closing, check.excesses)


def compute_errors(manoeuvre: Manoeuvre, way: list[Pose], seconds: float) -> Errors:
    """Return the errors of a manoeuvre whose true poses are ``way``."""
    end, last, commanded = manoeuvre.locate_end(way[0]), way[-1], manoeuvre.values[-1]
    moved = [0.0]
    for before, after in pairwise(way):
        if manoeuvre.name == "straight":
            moved.append(way[0].to_local(after.x, after.y)[0])
        else:
            moved.append(moved[-1] + wrap_angle(after.heading - before.heading))
    beyond = max(math.copysign(1.0, commanded) * each for each in moved) - abs(commanded)
    angle = abs(wrap_angle(last.heading - end.heading))
    return Errors(end.distance_to(last.x, last.y), angle, max(0.0, beyond / abs(commanded)), seconds)
