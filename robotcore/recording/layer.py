"""What is noted of a tick while it lasts: references put together, nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Generic

from robotcore.errors import RobotcoreError
from robotcore.geometry import Wheels, to_float
from robotcore.hal.devices import Display, Frame, Image, Motor, Sample, SampleT, Sensor
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
from robotcore.runtime.layers.base import Layer, MotorOver, Reader
from robotcore.safety import Commit, Intervention, Latch, Stage


@dataclass(slots=True)
class TickEvents:
    """What a tick was given and what it asked; ``samples`` are those seen for the first time, pictures shown too."""

    reads: list[Read] = field(default_factory=list)
    asks: list[DriveCommand] = field(default_factory=list)
    motor_asks: list[MotorCommand] = field(default_factory=list)
    turned: list[WheelAngles] = field(default_factory=list)
    standing: list[Wheels] = field(default_factory=list)
    shown: list[ShownPicture] = field(default_factory=list)
    samples: list[tuple[SampleKey, Sample]] = field(default_factory=list)
    commit_error: RecordedError | None = None


class TickBuffer:
    """The notes of the tick that is on; ``has_room`` is asked before a picture is kept.

    ``dropped`` counts those that were not. ``reader`` is who reads sensors, where that is not the app. ``latch`` is
    the run's.
    """

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self.notes = TickEvents()
        self.dropped = 0
        self.reader: str | None = None
        self.latch = Latch()
        self._has_room = has_room

    def take(self) -> TickEvents:
        """Return what was noted since it was last taken."""
        notes, self.notes = self.notes, TickEvents()
        return notes

    def drops(self, sample: Sample) -> bool:
        """Return whether a picture has to be left out; it is counted then."""
        is_dropped = isinstance(sample, Frame) and not self._has_room()
        self.dropped += is_dropped
        return is_dropped

    @contextmanager
    def read_by(self, reader: str) -> Iterator[None]:
        """Note who reads sensors meanwhile."""
        self.reader = reader
        try:
            yield
        finally:
            self.reader = None


class RecordedSensor(Generic[SampleT]):
    """Reads one sensor. A sample that it gives again is the same one."""

    def __init__(self, book: TickBuffer, device: str, read: Reader[SampleT]) -> None:
        self._book, self._device, self._read = book, device, read
        self._last: SampleT | None = None
        self._number: int | None = None
        self._kept = 0

    def __call__(self) -> SampleT:
        try:
            sample = self._read()
        except RobotcoreError as error:
            self._book.notes.reads.append(Read(self._device, error=RecordedError.of(error), by=self._book.reader))
            raise
        if sample is not self._last:
            self._keep(sample)
        read = Read(self._device, sample.sequence, sample.time, self._number, by=self._book.reader)
        self._book.notes.reads.append(read)
        return sample

    def _keep(self, sample: SampleT) -> None:
        self._last, self._number = sample, None
        if not self._book.drops(sample):
            self._number = self._kept
            self._kept += 1
            self._book.notes.samples.append((SampleKey(self._device, self._number), sample))


class RecordedDisplay(Display):
    """Notes a copy of each picture: it is the app's, which may draw on in it."""

    def __init__(self, book: TickBuffer, inner: Display) -> None:
        super().__init__(inner.name)
        self._book, self._inner = book, inner
        self._kept = 0

    def _show(self, image: Image) -> None:
        try:
            self._inner.show(image)
        except RobotcoreError as error:
            self._book.notes.shown.append(ShownPicture(self.name, error=RecordedError.of(error)))
            raise
        self._book.notes.shown.append(ShownPicture(self.name, self._keep(image)))

    def _keep(self, image: Image) -> int | None:
        """Return the number of a picture; None where it is left out."""
        number, picture = self._kept, Frame(image.copy(), 0.0, self._kept)
        if self._book.drops(picture):
            return None
        self._kept += 1
        self._book.notes.samples.append((SampleKey(self.name, number), picture))
        return number

    def _release(self) -> None:
        self._inner.close()


class RecordedStage:
    """Notes the commands that a drive is given, and their answers."""

    def __init__(self, book: TickBuffer, inner: Stage) -> None:
        self._book, self._inner = book, inner

    @property
    def asked(self) -> Wheels:
        standing = self._inner.asked
        self._book.notes.standing.append(standing)
        return standing

    def ask(self, wheels: Wheels) -> Wheels:
        try:
            with self._book.read_by(GUARD):
                given = self._inner.ask(wheels)
        except RobotcoreError as error:
            self._book.notes.asks.append(DriveCommand(wheels, error=RecordedError.of(error)))
            raise
        self._book.notes.asks.append(DriveCommand(wheels, given))
        return given

    def stop(self) -> None:
        try:
            self._inner.stop()
        except RobotcoreError as error:
            self._book.notes.asks.append(DriveCommand(None, error=RecordedError.of(error)))
            raise
        self._book.notes.asks.append(DriveCommand(None))

    def commit(self) -> Commit:
        try:
            with self._book.read_by(GUARD):
                return self._inner.commit()
        except RobotcoreError as error:
            self._book.notes.commit_error = RecordedError.of(error)
            raise


class RecordedMotor(MotorOver):
    """Notes the commands that a motor outside the drive is given, and their answers.

    Once the run is ended for good, stops are the framework's as much as the app's, and steer nothing.
    """

    def __init__(self, book: TickBuffer, inner: Motor) -> None:
        super().__init__(inner)
        self._book = book

    def set_velocity(self, rad_s: float) -> float:
        rad_s = to_float(rad_s)
        with self._noting_failure(rad_s):
            given = self._inner.set_velocity(rad_s)
        self._book.notes.motor_asks.append(MotorCommand(self.name, rad_s, given))
        return given

    def stop(self) -> None:
        if self._is_closed or self._book.latch.error:
            super().stop()
            return
        with self._noting_failure(None):
            self._inner.stop()
        self._book.notes.motor_asks.append(MotorCommand(self.name))

    @contextmanager
    def _noting_failure(self, asked: float | None) -> Iterator[None]:
        try:
            yield
        except RobotcoreError as error:
            self._book.notes.motor_asks.append(MotorCommand(self.name, asked, error=RecordedError.of(error)))
            raise

    def _apply(self, rad_s: float) -> None:
        self.set_velocity(rad_s)


class RecordingLayer(Layer):
    """Notes what passes it, tick by tick; ``has_room`` is asked before a picture is kept."""

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self._book = TickBuffer(has_room)

    @property
    def dropped(self) -> int:
        """How many pictures were left out."""
        return self._book.dropped

    def take(self) -> TickEvents:
        """Return what was noted since it was last taken."""
        return self._book.take()

    def latched(self, told: Iterable[Intervention]) -> RobotcoreError | None:
        """Return what ends the run for good, if that is among the interventions that are told."""
        latch = self._book.latch
        return latch.error if latch.error and latch.cause in {each.cause for each in told} else None

    def latch(self, latch: Latch) -> None:
        self._book.latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return RecordedSensor(self._book, sensor.name, read)

    def display(self, display: Display) -> Display:
        return RecordedDisplay(self._book, display)

    def stage(self, stage: Stage) -> Stage:
        return RecordedStage(self._book, stage)

    def lone_motor(self, motor: Motor) -> Motor:
        return RecordedMotor(self._book, motor)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        def noted() -> Wheels:
            try:
                with self._book.read_by(ODOMETRY):
                    angles = read()
            except RobotcoreError as error:
                self._book.notes.turned.append(WheelAngles(None, RecordedError.of(error)))
                raise
            self._book.notes.turned.append(WheelAngles(angles))
            return angles

        return noted
