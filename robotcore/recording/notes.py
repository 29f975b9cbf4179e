"""What is noted of a tick while it lasts: references put together, nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from robotcore.geometry import Wheels
from robotcore.hal.devices import Frame, Sample
from robotcore.recording.events import Ask, MotorAsk, Raised, Read, SampleKey, Shown, Turned
from robotcore.safety import Latch


@dataclass(slots=True)
class Notes:
    """What a tick was given and what it asked; ``samples`` are those seen for the first time, pictures shown too."""

    reads: list[Read] = field(default_factory=list)
    asks: list[Ask] = field(default_factory=list)
    motor_asks: list[MotorAsk] = field(default_factory=list)
    turned: list[Turned] = field(default_factory=list)
    standing: list[Wheels] = field(default_factory=list)
    shown: list[Shown] = field(default_factory=list)
    samples: list[tuple[SampleKey, Sample]] = field(default_factory=list)
    commit_error: Raised | None = None


class Notebook:
    """The notes of the tick that is on; ``has_room`` is asked before a picture is kept.

    ``dropped`` counts those that were not. ``reader`` is who reads sensors, where that is not the app. ``latch`` is
    the run's.
    """

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self.notes = Notes()
        self.dropped = 0
        self.reader: str | None = None
        self.latch = Latch()
        self._has_room = has_room

    def take(self) -> Notes:
        """Return what was noted since it was last taken."""
        notes, self.notes = self.notes, Notes()
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
