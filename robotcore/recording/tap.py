"""The tap that records the reads and the commands of an app in each tick."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Generic

from robotcore.errors import RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.devices import Display, Frame, Image, Sample, SampleT, Sensor
from robotcore.recording.events import (
    GUARD,
    ODOMETRY,
    DriveCommand,
    MotorCommand,
    Read,
    RecordedError,
    SampleKey,
    ShownPicture,
    WheelAngles,
)
from robotcore.runtime.layers.base import MotorOutput, Reader, Show, Tap
from robotcore.safety import CommandFilter, Commit, Intervention, Latch


@dataclass(slots=True)
class TickEvents:
    """The events of one tick, with the fields of `Tick`."""

    reads: list[Read] = field(default_factory=list)
    asks: list[DriveCommand] = field(default_factory=list)
    motor_asks: list[MotorCommand] = field(default_factory=list)
    turned: list[WheelAngles] = field(default_factory=list)
    shown: list[ShownPicture] = field(default_factory=list)
    samples: list[tuple[SampleKey, Sample]] = field(default_factory=list)
    """The new samples, and copies of the displayed pictures."""
    commit_error: RecordedError | None = None


class RecordedSensor(Generic[SampleT]):
    """Records the reads of one sensor. A sample that is read several times is stored once."""

    def __init__(self, tap: RecordingTap, device: str, read: Reader[SampleT]) -> None:
        self._tap, self._device, self._read = tap, device, read
        self._last: SampleT | None = None
        self._number: int | None = None
        self._count = 0

    def __call__(self) -> SampleT:
        try:
            sample = self._read()
        except RobotcoreError as error:
            self._tap.events.reads.append(Read(self._device, error=RecordedError.of(error), by=self._tap.reader))
            raise
        if sample is not self._last:
            self._keep(sample)
        read = Read(self._device, sample.sequence, sample.time, self._number, by=self._tap.reader)
        self._tap.events.reads.append(read)
        return sample

    def _keep(self, sample: SampleT) -> None:
        self._last, self._number = sample, None
        if not self._tap.must_drop(sample):
            self._number = self._count
            self._count += 1
            self._tap.events.samples.append((SampleKey(self._device, self._number), sample))


class RecordedDisplay:
    """Records a copy of each displayed picture, because the app may change the picture later."""

    def __init__(self, tap: RecordingTap, device: str, show: Show) -> None:
        self._tap, self._device, self._show = tap, device, show
        self._count = 0

    def __call__(self, image: Image) -> None:
        try:
            self._show(image)
        except RobotcoreError as error:
            self._tap.events.shown.append(ShownPicture(self._device, error=RecordedError.of(error)))
            raise
        self._tap.events.shown.append(ShownPicture(self._device, self._keep(image)))

    def _keep(self, image: Image) -> int | None:
        number, picture = self._count, Frame(image.copy(), 0.0, self._count)
        if self._tap.must_drop(picture):
            return None
        self._count += 1
        self._tap.events.samples.append((SampleKey(self._device, number), picture))
        return number


class RecordedStage:
    """Records the commands of the app to the drive, and the velocities that the safety stage allows."""

    def __init__(self, tap: RecordingTap, inner: CommandFilter) -> None:
        self._tap, self._inner = tap, inner

    def ask(self, wheels: Wheels) -> Wheels:
        try:
            with self._tap.set_reader(GUARD):
                given = self._inner.ask(wheels)
        except RobotcoreError as error:
            self._tap.events.asks.append(DriveCommand(wheels, error=RecordedError.of(error)))
            raise
        self._tap.events.asks.append(DriveCommand(wheels, given))
        return given

    def stop(self) -> None:
        try:
            self._inner.stop()
        except RobotcoreError as error:
            self._tap.events.asks.append(DriveCommand(None, error=RecordedError.of(error)))
            raise
        self._tap.events.asks.append(DriveCommand(None))

    def commit(self) -> Commit:
        try:
            with self._tap.set_reader(GUARD):
                return self._inner.commit()
        except RobotcoreError as error:
            self._tap.events.commit_error = RecordedError.of(error)
            raise


class RecordingTap(Tap):
    """Records the reads and commands of each tick. A picture is dropped if ``has_room`` returns False."""

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self.events = TickEvents()
        """The events of the current tick."""
        self.dropped = 0
        """The number of dropped pictures."""
        self.reader: str | None = None
        """The part that reads sensors now, `GUARD` or `ODOMETRY`; None for the app."""
        self._latch = Latch()
        self._has_room = has_room

    def take(self) -> TickEvents:
        """Return the events of the tick, and begin a new one."""
        events, self.events = self.events, TickEvents()
        return events

    def must_drop(self, sample: Sample) -> bool:
        """Return whether ``sample`` is a picture without room in the queue. Such a picture counts as dropped."""
        is_dropped = isinstance(sample, Frame) and not self._has_room()
        self.dropped += is_dropped
        return is_dropped

    @contextmanager
    def set_reader(self, reader: str) -> Iterator[None]:
        """Set ``reader`` within the ``with`` block."""
        self.reader = reader
        try:
            yield
        finally:
            self.reader = None

    def find_latched(self, interventions: Iterable[Intervention]) -> RobotcoreError | None:
        """Return the error of the latch if the latch caused one of the interventions, else None."""
        latch = self._latch
        return latch.error if latch.error and latch.cause in {each.cause for each in interventions} else None

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return RecordedSensor(self, sensor.name, read)

    def display(self, display: Display, show: Show) -> Show:
        return RecordedDisplay(self, display.name, show)

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        return RecordedStage(self, inner)

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that records each command, and the velocity that the motor accepts or its error.

        Stops after the latch has tripped are not recorded, because they may come from the framework instead of the app.
        """

        def record(asked: float | None, command: Callable[[], float | None]) -> float | None:
            try:
                given = command()
            except RobotcoreError as error:
                recorded = RecordedError.of(error)
                self.events.motor_asks.append(MotorCommand(motor.name, asked, error=recorded))
                raise
            self.events.motor_asks.append(MotorCommand(motor.name, asked, given))
            return given

        def set_velocity(rad_s: float) -> float:
            given = record(rad_s, lambda: motor.set_velocity(rad_s))
            return 0.0 if given is None else given

        def stop() -> None:
            if self._latch.error:
                motor.stop()
            else:
                record(None, motor.stop)

        return MotorOutput(motor.name, set_velocity, stop)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        def read_angles() -> Wheels:
            try:
                with self.set_reader(ODOMETRY):
                    angles = read()
            except RobotcoreError as error:
                self.events.turned.append(WheelAngles(None, RecordedError.of(error)))
                raise
            self.events.turned.append(WheelAngles(angles))
            return angles

        return read_angles
