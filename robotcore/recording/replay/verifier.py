"""The tap of a verification: it compares each decision with the recorded one, and returns the recorded answers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn, TypeVar

from robotcore.errors import DeviationError, RecordingEndedError, RobotcoreError, SafetyStop
from robotcore.geometry import Wheels
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.hal.drive import WheelPath
from robotcore.kinds.display import Display
from robotcore.recording import DriveCommand, MotorCommand, RecordedError, Recording
from robotcore.recording.codec import to_plain
from robotcore.recording.events import ActuatorCommand
from robotcore.recording.replay.app_run import ReplayTap
from robotcore.recording.replay.differences import (
    NO_COMMAND,
    CommandComparator,
    Deviation,
    format_command,
    format_reads,
    format_wheels,
    get_velocities,
)
from robotcore.runtime.layers.base import MotorOutput, Reader, Send
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.safety.command_filter import CommandFilter, TickCommands
from robotcore.safety.latch import Latch
from robotcore.safety.velocity_limits import STOPPED

CommandT = TypeVar("CommandT", DriveCommand, MotorCommand, ActuatorCommand)


class Verifier(ReplayTap):
    """Ends a replay with DeviationError at the first difference.

    The tap returns the recorded answers of the safety stage and the recorded wheel angles. The devices of the replay
    backend return the recorded samples. The app may catch the error that ends the replay. The next call raises it.
    """

    def __init__(self, recording: Recording, is_equal: CommandComparator) -> None:
        super().__init__(recording)
        self.is_equal = is_equal
        self.deviation: Deviation | None = None
        """The first difference; None if there is none so far."""
        self.trace = Trace(())
        """The trace of the equal ticks."""
        self._ended_by: RobotcoreError | None = None
        self._latch = Latch()
        self._stage: ReplayedStage | None = None

    @property
    def is_at_end(self) -> bool:
        """Whether the replay ended because the recording has no more events."""
        return isinstance(self._ended_by, RecordingEndedError)

    def raise_if_ended(self) -> None:
        """Raise the error that ended the replay, if there is one."""
        if self._ended_by:
            raise self._ended_by

    def report_difference(self, subject: str, recorded: str, replayed: str) -> NoReturn:
        """Store a difference and raise DeviationError, which ends the replay."""
        self.raise_if_ended()
        tick = self.current.tick
        reads = format_reads(tick, self.recording.samples)
        self.deviation = Deviation(tick.number, tick.time, subject, recorded, replayed, reads)
        self._ended_by = DeviationError(str(self.deviation))
        raise self._ended_by

    def end_if_cut_short(self) -> None:
        """End the replay with RecordingEndedError if the recording ends in this tick."""
        if self.current.is_cut_short:
            self.raise_if_ended()
            self._ended_by = RecordingEndedError(self.trace.ticks, self.current.tick.time)
            raise self._ended_by

    def raise_recorded(self, recorded: RecordedError) -> NoReturn:
        """Raise a recorded error. If it is a SafetyStop, trip the latch first."""
        error = recorded.rebuild()
        if isinstance(error, SafetyStop):
            self._latch.trip(error)
        raise error

    def answer(self, left: deque[CommandT], command: CommandT) -> CommandT:
        """Return the recorded answer to a command of the app, or raise its recorded error.

        Reports a difference if the next of the recorded commands that are ``left`` in this tick is another one.
        """
        self.raise_if_ended()
        if not left:
            self.end_if_cut_short()
            self.report_difference("the command", NO_COMMAND, format_command(command))
        recorded = left.popleft()
        if isinstance(recorded, ActuatorCommand) or isinstance(command, ActuatorCommand):
            is_equal = recorded.asked == command.asked
        else:
            is_equal = self.is_equal(get_velocities(recorded), get_velocities(command))
        if not is_equal or getattr(recorded, "device", "") != getattr(command, "device", ""):
            self.report_difference("the command", format_command(recorded), format_command(command))
        if recorded.error and isinstance(recorded, ActuatorCommand):
            raise recorded.error.rebuild()  # only the errors of motors trip the latch
        if recorded.error:
            self.raise_recorded(recorded.error)
        return recorded

    def require_none_left(self, left: deque[CommandT]) -> None:
        """Report a difference if the replay did not give a recorded command of this tick."""
        if left:
            self.report_difference("the command", format_command(left[0]), NO_COMMAND)

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def end_ticks(self) -> None:
        """End the replay, so that each call of the app's clean-up fails."""
        self._ended_by = self._ended_by or RecordingEndedError(self.trace.ticks, self.current.tick.time)

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a reader that reports a difference if the recorded run did not read the sensor in this tick.

        The reads of a monitored sensor are not compared, because the run decides when to read it.
        """
        if sensor.is_monitored:
            return read

        def reader() -> SampleT:
            self.raise_if_ended()
            self._trip_emergency_stop()
            if not self.current.was_read(sensor.name):
                self.end_if_cut_short()
                self.report_difference(f"the reading of {sensor.name}", "not read in this tick", "read")
            for _ in range(self.current.count_other_failures(sensor.name)):
                with suppress(RobotcoreError):
                    read()
            return read()

        return reader

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        """Return a function that compares each command, and answers as recorded. Pictures are not compared."""
        if isinstance(actuator, Display):
            return send

        def send_compared(command: Any) -> Any:
            given = self.answer(self.current.actuator_commands, ActuatorCommand(actuator.name, to_plain(command))).given
            return tuple(given) if isinstance(given, list) else given

        return send_compared

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        self._stage = ReplayedStage(self)
        return self._stage

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that answers as recorded.

        After the latch has tripped, stops are ignored, because they may come from the framework instead of the app.
        """

        def set_velocity(rad_s: float) -> float:
            given = self.answer(self.current.motor_commands, MotorCommand(motor.name, rad_s)).given
            return 0.0 if given is None else given

        def stop() -> None:
            if not self._latch.error:
                self.answer(self.current.motor_commands, MotorCommand(motor.name))

        return MotorOutput(motor.name, set_velocity, stop)

    def wheel_path(self, read: Callable[[], WheelPath]) -> Callable[[], WheelPath]:
        """Return a reader of the recorded path of the wheels."""

        def reader() -> WheelPath:
            if self._stage:
                self._stage.begin_tick()
            self._trip_emergency_stop()
            turned = self.current.next_angles()
            if turned and turned.error:
                self.raise_recorded(turned.error)
            return turned.path if turned and turned.path else read()

        return reader

    def tick(self, record: TickRecord) -> None:
        """Compare a tick with the recorded tick. An error is compared after the run."""
        tick = self.current.tick
        self.logged.add(record.logged)
        if self._stage:
            self._stage.is_in_tick = False
        self.raise_if_ended()
        self.end_if_cut_short()
        if self._stage and not self._stage.is_committed:
            if tick.error is None:
                return
            self.require_none_left(self.current.commands)
        if not tick.error:
            self.require_none_left(self.current.motor_commands)
            self.require_none_left(self.current.actuator_commands)
        if record.state != tick.state:
            self.report_difference("the state", repr(tick.state), repr(record.state))
        self.trace.add(record)
        self.advance(self.trace.ticks)
        if error := self.current.early_error:
            self._latch.set(error)

    def _trip_emergency_stop(self) -> None:
        if error := self.current.emergency_stop:
            self._latch.set(error)


class ReplayedStage:
    """Replaces the safety stage: the verifier compares each command, and returns the recorded answer.

    Between ticks it ignores stops, because the framework sends stops that are not recorded.
    """

    def __init__(self, verifier: Verifier) -> None:
        self._verifier = verifier
        self._asked: Wheels | None = None
        self.is_in_tick = False
        self.is_committed = False
        """Whether the command of the current tick was compared."""

    def begin_tick(self) -> None:
        """Begin to compare the commands of a tick. Further calls in the tick do nothing."""
        if not self.is_in_tick:
            self._asked, self.is_in_tick, self.is_committed = None, True, False

    def ask(self, wheels: Wheels) -> Wheels:
        given = self._verifier.answer(self._verifier.current.commands, DriveCommand(wheels)).given
        self._asked = wheels
        return given or wheels

    def stop(self) -> None:
        if self.is_in_tick:
            self._asked = STOPPED
            self._verifier.answer(self._verifier.current.commands, DriveCommand())

    def commit(self) -> TickCommands:
        verifier, current = self._verifier, self._verifier.current
        tick = current.tick
        verifier.raise_if_ended()
        verifier.end_if_cut_short()
        verifier.require_none_left(current.commands)
        if tick.error and not current.was_committed:
            if not (tick.commit_error or isinstance(tick.error.rebuild(), SafetyStop)):
                raised = f"raised {tick.error.kind}: {tick.error.message}"
                verifier.report_difference("the end", raised, "the app goes on")
            verifier.raise_recorded(tick.error)
        if not verifier.is_equal(tick.asked, self._asked):
            verifier.report_difference("the command of the tick", format_wheels(tick.asked), format_wheels(self._asked))
        self.is_committed = True
        if tick.error:
            with suppress(RobotcoreError):
                verifier.raise_recorded(tick.error)
        return TickCommands(self._asked, tick.sent, tick.interventions)
