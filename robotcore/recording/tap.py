"""The layer that notes what an app is given and what it asks; within a tick it only puts references together."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Generic

from robotcore.devices import Display, Frame, Image, Sample, SampleT, Sensor
from robotcore.drive import Wheels
from robotcore.errors import RobotcoreError
from robotcore.layers.layer import Layer
from robotcore.layers.readers import Reader
from robotcore.recording.events import Ask, Raised, Read, SampleKey, Turned
from robotcore.safety import Commit, Intervention, Latch, Stage


@dataclass(slots=True)
class Notes:
    """What a tick was given and what it asked; ``samples`` are those seen for the first time, pictures shown too."""

    reads: list[Read] = field(default_factory=list)
    asks: list[Ask] = field(default_factory=list)
    turned: list[Turned] = field(default_factory=list)
    standing: list[Wheels] = field(default_factory=list)
    shown: list[SampleKey] = field(default_factory=list)
    samples: list[tuple[SampleKey, Sample]] = field(default_factory=list)


class Tap(Layer):
    """Notes what passes it, tick by tick; ``has_room`` is asked before a picture is kept."""

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self.notes = Notes()
        self.dropped = 0
        self._has_room = has_room
        self._latch: Latch | None = None

    def latched(self, told: Iterable[Intervention]) -> RobotcoreError | None:
        """Return what ends the run for good, if that is among the interventions that are told."""
        latch = self._latch
        return latch.error if latch and latch.error and latch.cause in {each.cause for each in told} else None

    def latch(self, latch: Latch) -> None:
        self._latch = latch

    def take(self) -> Notes:
        """Return what was noted since it was last taken."""
        notes, self.notes = self.notes, Notes()
        return notes

    def drops(self, sample: Sample) -> bool:
        """Return whether a picture has to be left out; it is counted then."""
        is_dropped = isinstance(sample, Frame) and not self._has_room()
        self.dropped += is_dropped
        return is_dropped

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return _NotedReads(self, sensor.name, read)

    def display(self, display: Display) -> Display:
        return _NotedDisplay(self, display)

    def stage(self, stage: Stage) -> Stage:
        return _NotedStage(self, stage)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        def noted() -> Wheels:
            try:
                angles = read()
            except RobotcoreError as error:
                self.notes.turned.append(Turned(None, Raised.of(error)))
                raise
            self.notes.turned.append(Turned(angles))
            return angles

        return noted


class _NotedReads(Generic[SampleT]):
    """Reads one sensor. A sample that it gives again is the same one."""

    def __init__(self, tap: Tap, device: str, read: Reader[SampleT]) -> None:
        self._tap, self._device, self._read = tap, device, read
        self._last: SampleT | None = None
        self._number: int | None = None
        self._kept = 0

    def __call__(self) -> SampleT:
        try:
            sample = self._read()
        except RobotcoreError as error:
            self._tap.notes.reads.append(Read(self._device, error=Raised.of(error)))
            raise
        if sample is not self._last:
            self._keep(sample)
        self._tap.notes.reads.append(Read(self._device, sample.sequence, sample.time, self._number))
        return sample

    def _keep(self, sample: SampleT) -> None:
        self._last, self._number = sample, None
        if not self._tap.drops(sample):
            self._number = self._kept
            self._kept += 1
            self._tap.notes.samples.append((SampleKey(self._device, self._number), sample))


class _NotedDisplay(Display):
    """Notes a copy of each picture: it is the app's, which may draw on in it."""

    def __init__(self, tap: Tap, inner: Display) -> None:
        super().__init__(inner.name)
        self._tap, self._inner = tap, inner
        self._kept = 0

    def _show(self, image: Image) -> None:
        shown = Frame(image.copy(), 0.0, self._kept)
        if not self._tap.drops(shown):
            key = SampleKey(self.name, self._kept)
            self._kept += 1
            self._tap.notes.samples.append((key, shown))
            self._tap.notes.shown.append(key)
        self._inner.show(image)

    def _release(self) -> None:
        self._inner.close()


class _NotedStage:
    """Notes the commands that a drive is given, and their answers."""

    def __init__(self, tap: Tap, inner: Stage) -> None:
        self._tap, self._inner = tap, inner

    @property
    def asked(self) -> Wheels:
        standing = self._inner.asked
        self._tap.notes.standing.append(standing)
        return standing

    def ask(self, wheels: Wheels) -> Wheels:
        try:
            given = self._inner.ask(wheels)
        except RobotcoreError as error:
            self._tap.notes.asks.append(Ask(wheels, error=Raised.of(error)))
            raise
        self._tap.notes.asks.append(Ask(wheels, given))
        return given

    def stop(self) -> None:
        try:
            self._inner.stop()
        except RobotcoreError as error:
            self._tap.notes.asks.append(Ask(None, error=Raised.of(error)))
            raise
        self._tap.notes.asks.append(Ask(None))

    def commit(self) -> Commit:
        return self._inner.commit()
