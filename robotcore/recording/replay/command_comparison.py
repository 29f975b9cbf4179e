"""The tap of a replay: it compares each command with the recorded one, and returns the recorded answer."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

from robotcore.errors import RobotcoreError, SafetyStop
from robotcore.geometry import Wheels
from robotcore.hal.devices import Battery, SampleT, Sensor
from robotcore.recording import DriveCommand, MotorCommand, RecordedError, Recording
from robotcore.recording.replay.cursor import ReplayCursor, format_motor_command, format_wheels
from robotcore.runtime.layers.base import MotorOutput, Reader, Tap
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.safety import CommandFilter, Commit, Latch
from robotcore.safety.velocity_limits import STOPPED

Command = tuple[float, ...]
"""The velocity of one motor, or of both wheels, in rad/s."""

PLATFORM_TOLERANCE = 1e-9
"""The tolerance in rad/s if the platform differs from the recorded one."""


class CommandComparator:
    """Compares commands, with a ``tolerance`` in rad/s. With the tolerance 0, their bits must be equal.

    Two NaN are equal.
    """

    def __init__(self, tolerance: float = 0.0) -> None:
        self._tolerance = tolerance
        self.largest = 0.0
        """The largest difference within the tolerance so far, in rad/s."""
        self.is_exact = True
        """Whether all equal commands so far had equal bits."""

    def __call__(self, one: Command | None, other: Command | None) -> bool:
        """Return whether two commands are equal. None is a stop or no command."""
        if one is None or other is None:
            return one is other
        if all(map(_is_same, one, other)):
            return True
        difference = max(map(_difference, one, other))
        is_alike = 0 < self._tolerance >= difference
        if is_alike:
            self.is_exact, self.largest = False, max(self.largest, difference)
        return is_alike


def _is_same(one: float, other: float) -> bool:
    return struct.pack("<d", one) == struct.pack("<d", other) or (math.isnan(one) and math.isnan(other))


def _difference(one: float, other: float) -> float:
    """Return the absolute difference of two numbers; infinity if only one is NaN, or if an infinite one differs."""
    if _is_same(one, other) or one == other:
        return 0.0
    return abs(one - other) if math.isfinite(one - other) else math.inf


_NO_COMMAND = "no command"


class ReplayedStage:
    """Replaces the safety stage: it compares each command with the recorded one, and returns the recorded answer.

    Between ticks it ignores stops, because the framework sends stops that are not recorded.
    """

    def __init__(self, cursor: ReplayCursor, comparator: CommandComparator, latch: Latch) -> None:
        self._cursor, self._is_equal, self._latch = cursor, comparator, latch
        self._asked: Wheels | None = None
        self._is_in_tick = False
        self.is_committed = False
        """Whether the command of the current tick was compared."""

    def begin_tick(self) -> None:
        """Begin to compare the commands of a tick. Further calls in the tick do nothing."""
        if not self._is_in_tick:
            self._asked, self._is_in_tick, self.is_committed = None, True, False

    def end_tick(self) -> None:
        """Ignore stops until the next tick begins."""
        self._is_in_tick = False

    @property
    def asked(self) -> Wheels:
        return self._cursor.current.next_held_command()

    def ask(self, wheels: Wheels) -> Wheels:
        answered = self._find_answer(wheels)
        if answered.error:
            raise_recorded(answered.error, self._latch)
        self._asked = wheels
        return answered.given or wheels

    def stop(self) -> None:
        if not self._is_in_tick:
            return
        self._asked = STOPPED
        if error := self._find_answer(None).error:
            raise_recorded(error, self._latch)

    def commit(self) -> Commit:
        cursor, tick = self._cursor, self._cursor.current.tick
        cursor.raise_if_ended()
        if cursor.current.is_cut_short:
            cursor.end()
        self.require_all()
        if tick.error and not cursor.current.was_committed:
            self._fail(tick.error)
        if not self._is_equal(tick.asked, self._asked):
            cursor.report_difference("the command of the tick", format_wheels(tick.asked), format_wheels(self._asked))
        self.is_committed = True
        if tick.error:
            with suppress(RobotcoreError):
                raise_recorded(tick.error, self._latch)
        return Commit(self._asked, tick.sent, tick.interventions)

    def require_all(self) -> None:
        """Report a difference if a recorded command of this tick is missing in the replay."""
        if left := self._cursor.current.commands:
            self._cursor.report_difference("the command", format_wheels(left[0].asked), _NO_COMMAND)

    def _find_answer(self, wheels: Wheels | None) -> DriveCommand:
        self._cursor.raise_if_ended()
        recorded = self._cursor.current.next_command()
        if recorded is None:
            self._cursor.report_missing("the command", _NO_COMMAND, format_wheels(wheels))
        if not self._is_equal(recorded.asked, wheels):
            self._cursor.report_difference("the command", format_wheels(recorded.asked), format_wheels(wheels))
        return recorded

    def _fail(self, recorded: RecordedError) -> NoReturn:
        """Raise the recorded error of this tick; report a difference if it was raised before the command."""
        if not (self._cursor.current.tick.commit_error or isinstance(recorded.rebuild(), SafetyStop)):
            self._cursor.report_difference("the end", f"raised {recorded.kind}: {recorded.message}", "the app goes on")
        raise_recorded(recorded, self._latch)


def raise_recorded(recorded: RecordedError, latch: Latch) -> NoReturn:
    """Raise a recorded error. If it is a SafetyStop, trip the latch first."""
    error = recorded.rebuild()
    if isinstance(error, SafetyStop):
        latch.trip(error)
    raise error


class ReplayedMotor:
    """Compares the commands to a motor outside the drive with the recorded ones, and returns the recorded answers.

    After the latch has tripped, stops are ignored, because they may come from the framework instead of the app.
    """

    def __init__(self, name: str, cursor: ReplayCursor, comparator: CommandComparator, latch: Latch) -> None:
        self._name, self._cursor, self._is_equal, self._latch = name, cursor, comparator, latch

    @property
    def output(self) -> MotorOutput:
        """A motor output that compares each command and returns the recorded answer."""
        return MotorOutput(self._name, self.set_velocity, self.stop)

    def set_velocity(self, rad_s: float) -> float:
        """Compare a velocity in rad/s with the recorded one, and return the recorded accepted velocity."""
        given = self._find_answer(MotorCommand(self._name, rad_s)).given
        return 0.0 if given is None else given

    def stop(self) -> None:
        """Compare a stop with the recorded one."""
        if not self._latch.error:
            self._find_answer(MotorCommand(self._name))

    def _find_answer(self, ask: MotorCommand) -> MotorCommand:
        self._cursor.raise_if_ended()
        asks = self._cursor.current.motor_commands
        if not asks:
            self._cursor.report_missing("the command", _NO_COMMAND, format_motor_command(ask))
        recorded = asks.popleft()
        if recorded.device != ask.device or not self._is_equal(_get_velocity(recorded), _get_velocity(ask)):
            self._cursor.report_difference("the command", format_motor_command(recorded), format_motor_command(ask))
        if recorded.error:
            raise_recorded(recorded.error, self._latch)
        return recorded


def require_all_motor_commands(cursor: ReplayCursor) -> None:
    """Report a difference if a recorded motor command of this tick is missing in the replay.

    A tick that an error aborted is not checked.
    """
    if (left := cursor.current.motor_commands) and not cursor.current.tick.error:
        cursor.report_difference("the command", format_motor_command(left[0]), _NO_COMMAND)


def _get_velocity(ask: MotorCommand) -> tuple[float] | None:
    return None if ask.asked is None else (ask.asked,)


class ReplayTap(Tap):
    """A tap and an observer that end a replay with DeviationError at the first difference.

    The tap returns the recorded answers of the safety stage and the recorded wheel angles. The devices of the replay
    backend return the recorded samples.
    """

    def __init__(self, recording: Recording, comparator: CommandComparator) -> None:
        self.cursor = ReplayCursor(recording)
        self._comparator = comparator
        self._latch = Latch()
        self._stage: ReplayedStage | None = None

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a reader that reports a difference if the recorded run did not read the sensor in this tick.

        The reads of a battery are not compared, because the framework decides when to read it.
        """
        if isinstance(sensor, Battery):
            return read

        def reader() -> SampleT:
            self.cursor.raise_if_ended()
            self._raise_emergency_stop()
            if not self.cursor.current.was_read(sensor.name):
                self.cursor.report_missing(f"the reading of {sensor.name}", "not read in this tick", "read")
            for _ in range(self.cursor.current.count_other_failures(sensor.name)):
                with suppress(RobotcoreError):
                    read()
            return read()

        return reader

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        self._stage = ReplayedStage(self.cursor, self._comparator, self._latch)
        return self._stage

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        return ReplayedMotor(motor.name, self.cursor, self._comparator, self._latch).output

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        """Return a reader of the recorded wheel angles."""

        def reader() -> Wheels:
            if self._stage:
                self._stage.begin_tick()
            self._raise_emergency_stop()
            turned = self.cursor.current.next_angles()
            if turned and turned.error:
                raise_recorded(turned.error, self._latch)
            return turned.angles if turned and turned.angles else read()

        return reader

    def begin(self, run: Run) -> None:
        """Do nothing. The comparison begins with the first tick."""

    def tick(self, record: TickRecord) -> None:
        """Compare a tick with the recorded tick. An error is compared by `check_end`."""
        cursor, tick = self.cursor, self.cursor.current.tick
        if self._stage:
            self._stage.end_tick()
        cursor.raise_if_ended()
        if cursor.current.is_cut_short:
            cursor.end()
        if self._stage and not self._stage.is_committed:
            if tick.error is None:
                return
            self._stage.require_all()
        require_all_motor_commands(cursor)
        if record.state != tick.state:
            cursor.report_difference("the state", repr(tick.state), repr(record.state))
        cursor.advance(record)
        if error := cursor.current.early_error:
            self._latch.set(error)

    def _raise_emergency_stop(self) -> None:
        if error := self.cursor.current.emergency_stop:
            self._latch.set(error)

    def end(self, result: RunResult) -> None:
        """Do nothing. `check_end` compares the end of the run."""
