"""Whether two commands are the same."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

from robotcore.errors import RobotcoreError, SafetyStop
from robotcore.geometry import Wheels
from robotcore.hal.devices import Battery, Motor, SampleT, Sensor, Voltage
from robotcore.recording import DriveCommand, MotorCommand, RecordedError, Recording
from robotcore.recording.replay.cursor import ReplayCursor, format_motor_command, format_wheels
from robotcore.runtime.layers.base import Layer, MotorOver, Reader
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.safety import Commit, Latch, Stage
from robotcore.safety.rules import REST

Command = tuple[float, ...]
"""Of one motor or of both wheels, rad/s."""

PLATFORM_TOLERANCE = 1e-9
"""So far commands may differ, in rad/s, where another processor or library has reckoned them."""


class CommandComparator:
    """Compares commands to the bit, or within a ``tolerance``; ``largest`` is the largest difference it has let pass.

    ``is_exact`` says whether all were equal to the bit so far, NaN counting as equal to NaN.
    """

    def __init__(self, tolerance: float = 0.0) -> None:
        self._tolerance = tolerance
        self.largest = 0.0
        self.is_exact = True

    def __call__(self, one: Command | None, other: Command | None) -> bool:
        """Return whether they are alike; None, which is a stop or no command at all, is like None alone."""
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
    """Return how far two numbers are apart; what is not finite is near nothing but itself."""
    if _is_same(one, other) or one == other:
        return 0.0
    return abs(one - other) if math.isfinite(one - other) else math.inf


_NO_COMMAND = "no command"


class ReplayedStage:
    """Stands where the safety stage stood; what that answered, lessened, cut or refused comes from the recording.

    Between ticks, where the loop and those who close a robot stop the wheels, it lets everything pass.
    """

    def __init__(self, script: ReplayCursor, likeness: CommandComparator, latch: Latch) -> None:
        self._script, self._is_alike, self._latch = script, likeness, latch
        self._asked: Wheels | None = None
        self._is_in_tick = False
        self.is_committed = False

    def begin_tick(self) -> None:
        """Expect the commands of the next tick. May be called again in it."""
        if not self._is_in_tick:
            self._asked, self._is_in_tick, self.is_committed = None, True, False

    def end_tick(self) -> None:
        """Expect none any more."""
        self._is_in_tick = False

    @property
    def asked(self) -> Wheels:
        return self._script.cues.next_standing()

    def ask(self, wheels: Wheels) -> Wheels:
        answered = self._answered(wheels)
        if answered.error:
            raise_recorded(answered.error, self._latch)
        self._asked = wheels
        return answered.given or wheels

    def stop(self) -> None:
        if not self._is_in_tick:
            return
        self._asked = REST
        if error := self._answered(None).error:
            raise_recorded(error, self._latch)

    def commit(self) -> Commit:
        script, tick = self._script, self._script.cues.tick
        script.check()
        if script.cues.is_cut_short:
            script.end()
        self.require_all()
        if tick.error and not script.cues.was_committed:
            self._fail(tick.error)
        if not self._is_alike(tick.asked, self._asked):
            script.deviate("the command of the tick", format_wheels(tick.asked), format_wheels(self._asked))
        self.is_committed = True
        if tick.error:
            with suppress(RobotcoreError):
                raise_recorded(tick.error, self._latch)
        return Commit(self._asked, tick.sent, tick.interventions)

    def require_all(self) -> None:
        """Deviate where the recorded run gave a command more in this tick."""
        if left := self._script.cues.asks:
            self._script.deviate("the command", format_wheels(left[0].asked), _NO_COMMAND)

    def _answered(self, wheels: Wheels | None) -> DriveCommand:
        """Return the recorded command that this one is like; None is a stop."""
        self._script.check()
        recorded = self._script.cues.next_ask()
        if recorded is None:
            self._script.lack("the command", _NO_COMMAND, format_wheels(wheels))
        if not self._is_alike(recorded.asked, wheels):
            self._script.deviate("the command", format_wheels(recorded.asked), format_wheels(wheels))
        return recorded

    def _fail(self, recorded: RecordedError) -> NoReturn:
        """Raise what ended the recorded run at the end of this tick; a deviation where it had ended before."""
        if not (self._script.cues.tick.commit_error or isinstance(recorded.again(), SafetyStop)):
            self._script.deviate("the end", f"raised {recorded.kind}: {recorded.message}", "the app goes on")
        raise_recorded(recorded, self._latch)


def raise_recorded(recorded: RecordedError, latch: Latch) -> NoReturn:
    """Raise what was raised in the recording; a safety stop latches."""
    error = recorded.again()
    if isinstance(error, SafetyStop):
        latch.trip(error)
    raise error


class ReplayedMotor(MotorOver):
    """Turns nothing. Once the run is ended for good a stop is no command: robots are closed so."""

    def __init__(self, inner: Motor, script: ReplayCursor, likeness: CommandComparator, latch: Latch) -> None:
        super().__init__(inner)
        self._script, self._is_alike, self._latch = script, likeness, latch

    def set_velocity(self, rad_s: float) -> float:
        self._require_open()
        given = self._answered(MotorCommand(self.name, rad_s)).given
        return 0.0 if given is None else given

    def stop(self) -> None:
        if not (self._is_closed or self._latch.error):
            self._answered(MotorCommand(self.name))

    def _answered(self, ask: MotorCommand) -> MotorCommand:
        """Return the recorded command that this one is like; raise what that raised."""
        self._script.check()
        asks = self._script.cues.motor_asks
        if not asks:
            self._script.lack("the command", _NO_COMMAND, format_motor_command(ask))
        recorded = asks.popleft()
        if recorded.device != ask.device or not self._is_alike(_get_velocity(recorded), _get_velocity(ask)):
            self._script.deviate("the command", format_motor_command(recorded), format_motor_command(ask))
        if recorded.error:
            raise_recorded(recorded.error, self._latch)
        return recorded

    def _apply(self, rad_s: float) -> None:
        self.set_velocity(rad_s)


def require_all_motor_commands(script: ReplayCursor) -> None:
    """Deviate where the recorded run gave a motor a command more in this tick, unless it ended in it."""
    if (left := script.cues.motor_asks) and not script.cues.tick.error:
        script.deviate("the command", format_motor_command(left[0]), _NO_COMMAND)


def _get_velocity(ask: MotorCommand) -> tuple[float] | None:
    return None if ask.asked is None else (ask.asked,)


class ReplayLayer(Layer):
    """A tap and an observer in one. It ends the replay at the first tick that differs, with DeviationError.

    Samples come from the devices below; what the safety stage answered, and the angles of the wheels, come from here.
    """

    def __init__(self, recording: Recording, likeness: CommandComparator) -> None:
        self.script = ReplayCursor(recording)
        self._likeness = likeness
        self._latch = Latch()
        self._stage: ReplayedStage | None = None

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return what reads the sensor where the recorded run has read it too, as its app did."""

        def reader() -> SampleT:
            self.script.check()
            self._press()
            if not self.script.cues.was_read(sensor.name):
                self.script.lack(f"what is read of {sensor.name}", "not read in this tick", "read")
            for _ in range(self.script.cues.failed_others(sensor.name)):
                with suppress(RobotcoreError):
                    read()
            return read()

        return reader

    def battery(self, battery: Battery, read: Reader[Voltage]) -> Reader[Voltage]:
        """Return what reads the battery, held to nothing: it is read beside the app, at whatever pace."""
        return read

    def stage(self, stage: Stage) -> Stage:
        self._stage = ReplayedStage(self.script, self._likeness, self._latch)
        return self._stage

    def lone_motor(self, motor: Motor) -> Motor:
        return ReplayedMotor(motor, self.script, self._likeness, self._latch)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        """Return what reads the recorded angles."""

        def reader() -> Wheels:
            if self._stage:
                self._stage.begin_tick()
            self._press()
            turned = self.script.cues.next_turned()
            if turned and turned.error:
                raise_recorded(turned.error, self._latch)
            return turned.angles if turned and turned.angles else read()

        return reader

    def begin(self, run: Run) -> None:
        """Nothing is compared before the first tick."""

    def tick(self, record: TickRecord) -> None:
        """Hold a tick to the recorded one. Where the app has just raised something new, `ending` tells."""
        script, tick = self.script, self.script.cues.tick
        if self._stage:
            self._stage.end_tick()
        script.check()
        if script.cues.is_cut_short:
            script.end()
        if self._stage and not self._stage.is_committed:
            if tick.error is None:
                return
            self._stage.require_all()
        require_all_motor_commands(script)
        if record.state != tick.state:
            script.deviate("the state", repr(tick.state), repr(record.state))
        script.go_on(record)
        if error := script.cues.ended_before:
            self._latch.set(error)

    def _press(self) -> None:
        """Press the e-stop where it was pressed."""
        if error := self.script.cues.pressed:
            self._latch.set(error)

    def end(self, result: RunResult) -> None:
        """Leave the end to `ending`."""
