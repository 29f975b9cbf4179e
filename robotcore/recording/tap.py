"""The tap that records the reads and the commands of an app in each tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

from robotcore.errors import DeviationError, RecordingEndedError, RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.device import Actuator, Sample, SampleT, Sensor
from robotcore.hal.drive import WheelPath
from robotcore.hal.sample_types import require_types
from robotcore.kinds.camera import Frame
from robotcore.kinds.display import Display
from robotcore.optics import Image
from robotcore.recording.codec import to_plain
from robotcore.recording.events import (
    GUARD,
    ODOMETRY,
    ActuatorCommand,
    DriveCommand,
    MotorCommand,
    Read,
    RecordedError,
    SampleKey,
    ShownPicture,
    WheelAngles,
)
from robotcore.runtime.layers.base import MotorOutput, Reader, Send, Tap
from robotcore.safety.command_filter import CommandFilter, TickCommands
from robotcore.safety.latch import Latch
from robotcore.safety.velocity_limits import Intervention

T = TypeVar("T")

REPLAY_ENDS = (DeviationError, RecordingEndedError)
"""The errors that end a replay. They are no events of the app, so a call that raises one is not recorded."""


@dataclass(slots=True)
class TickEvents:
    """The events of one tick, with the fields of `Tick`."""

    reads: list[Read] = field(default_factory=list)
    asks: list[DriveCommand] = field(default_factory=list)
    motor_asks: list[MotorCommand] = field(default_factory=list)
    turned: list[WheelAngles] = field(default_factory=list)
    shown: list[ShownPicture] = field(default_factory=list)
    commands: list[ActuatorCommand] = field(default_factory=list)
    samples: list[tuple[SampleKey, Sample]] = field(default_factory=list)
    """The new samples, and copies of the displayed pictures."""
    commit_error: RecordedError | None = None


class RecordingTap(Tap):
    """Records the reads and commands of each tick. A picture is dropped if ``has_room`` returns False."""

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self.events = TickEvents()
        """The events of the current tick."""
        self.dropped = 0
        """The number of dropped pictures."""
        self._has_room = has_room
        self._latch = Latch()
        self._kept = Counter[str]()
        self._reader: str | None = None
        self._has_ended = False

    def take(self) -> TickEvents:
        """Return the events of the tick, and begin a new one."""
        events, self.events = self.events, TickEvents()
        return events

    def find_latched(self, interventions: Iterable[Intervention]) -> RobotcoreError | None:
        """Return the error of the latch if the latch caused one of the interventions, else None."""
        latch = self._latch
        return latch.error if latch.error and latch.cause in {each.cause for each in interventions} else None

    def record(self, kind: str, build: Callable[..., object], call: Callable[[], T]) -> T:
        """Make a call, and record it as the event that ``build`` returns.

        kind: the field of `TickEvents` for the event.
        build: a function of the result and of the error of the call. One of them is None.
        """
        try:
            result = call()
        except REPLAY_ENDS:
            raise
        except RobotcoreError as error:
            if not self._has_ended:
                getattr(self.events, kind).append(build(None, RecordedError.from_error(error)))
            raise
        except BaseException:  # a signal
            self.end_ticks()
            raise
        if not self._has_ended:
            getattr(self.events, kind).append(build(result, None))
        return result

    def end_ticks(self) -> None:
        """End the recording of calls. A replay does not repeat the calls of the app's clean-up."""
        self._has_ended = True

    def resume_ticks(self) -> None:
        self._has_ended = False

    @contextmanager
    def set_reader(self, reader: str) -> Iterator[None]:
        """Record the reads within the ``with`` block as those of the range guard or the odometry."""
        self._reader = reader
        try:
            yield
        finally:
            self._reader = None

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a reader that records each read. A sample that is read several times is stored once.

        The first sample must fit the types of its fields, because a sample that does not cannot be read from a file.
        """
        last: SampleT | None = None
        number: int | None = None

        def read_checked() -> SampleT:
            sample = read()
            if last is None:
                require_types(sensor.name, sample)
            return sample

        def build(sample: SampleT | None, error: RecordedError | None) -> Read:
            nonlocal last, number
            if sample is None:
                return Read(sensor.name, error=error, by=self._reader)
            if sample is not last:
                last, number = sample, self._keep(sensor.name, sample)
            return Read(sensor.name, sample.sequence, sample.time, number, by=self._reader)

        return partial(self.record, "reads", build, read_checked)

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        """Return a function that records each command, of a picture a copy, because the app may change it later."""

        def record_picture(image: Image) -> Any:
            def build(_: Any, error: RecordedError | None) -> ShownPicture:
                if error:
                    return ShownPicture(actuator.name, error=error)
                picture = Frame(image.copy(), 0.0, self._kept[actuator.name])
                return ShownPicture(actuator.name, self._keep(actuator.name, picture))

            return self.record("shown", build, partial(send, image))

        def record(command: Any) -> Any:
            build = partial(ActuatorCommand, actuator.name, to_plain(command))
            return self.record("commands", lambda sent, error: build(to_plain(sent), error), partial(send, command))

        return record_picture if isinstance(actuator, Display) else record

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        return RecordedStage(self, inner)

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that records each command, and the velocity that the motor accepts or its error.

        Stops after the latch has tripped are not recorded, because they may come from the framework instead of the app.
        """

        def record(asked: float | None, command: Callable[[], T]) -> T:
            return self.record("motor_asks", partial(MotorCommand, motor.name, asked), command)

        def stop() -> None:
            if self._latch.error:
                motor.stop()
            else:
                record(None, motor.stop)

        return MotorOutput(motor.name, lambda rad_s: record(rad_s, partial(motor.set_velocity, rad_s)), stop)

    def wheel_path(self, read: Callable[[], WheelPath]) -> Callable[[], WheelPath]:
        def read_path() -> WheelPath:
            with self.set_reader(ODOMETRY):
                return self.record("turned", WheelAngles.from_path, read)

        return read_path

    def _keep(self, device: str, sample: Sample) -> int | None:
        """Store a sample, and return its number; None if it is a picture that is dropped."""
        if isinstance(sample, Frame) and not self._has_room():
            self.dropped += 1
            return None
        number = self._kept[device]
        self._kept[device] += 1
        self.events.samples.append((SampleKey(device, number), sample))
        return number


class RecordedStage:
    """Records the commands of the app to the drive, and the velocities that the safety stage allows."""

    def __init__(self, tap: RecordingTap, inner: CommandFilter) -> None:
        self._tap, self._inner = tap, inner

    def ask(self, wheels: Wheels) -> Wheels:
        with self._tap.set_reader(GUARD):
            return self._tap.record("asks", partial(DriveCommand, wheels), partial(self._inner.ask, wheels))

    def stop(self) -> None:
        self._tap.record("asks", partial(DriveCommand, None), self._inner.stop)

    def commit(self) -> TickCommands:
        try:
            with self._tap.set_reader(GUARD):
                return self._inner.commit()
        except REPLAY_ENDS:
            raise
        except RobotcoreError as error:
            self._tap.events.commit_error = RecordedError.from_error(error)
            raise
