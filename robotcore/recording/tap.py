"""The layer that notes what an app is given and what it asks."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from robotcore.errors import RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.devices import Display, Motor, SampleT, Sensor
from robotcore.recording.events import ODOMETRY, Raised, Turned
from robotcore.recording.noted import NotedDisplay, NotedMotor, NotedReads, NotedStage
from robotcore.recording.notes import Notebook, Notes
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import Reader
from robotcore.safety import Intervention, Latch, Stage


class Tap(Layer):
    """Notes what passes it, tick by tick; ``has_room`` is asked before a picture is kept."""

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self._book = Notebook(has_room)

    @property
    def dropped(self) -> int:
        """How many pictures were left out."""
        return self._book.dropped

    def take(self) -> Notes:
        """Return what was noted since it was last taken."""
        return self._book.take()

    def latched(self, told: Iterable[Intervention]) -> RobotcoreError | None:
        """Return what ends the run for good, if that is among the interventions that are told."""
        latch = self._book.latch
        return latch.error if latch.error and latch.cause in {each.cause for each in told} else None

    def latch(self, latch: Latch) -> None:
        self._book.latch = latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return NotedReads(self._book, sensor.name, read)

    def display(self, display: Display) -> Display:
        return NotedDisplay(self._book, display)

    def stage(self, stage: Stage) -> Stage:
        return NotedStage(self._book, stage)

    def lone_motor(self, motor: Motor) -> Motor:
        return NotedMotor(self._book, motor)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        def noted() -> Wheels:
            try:
                with self._book.read_by(ODOMETRY):
                    angles = read()
            except RobotcoreError as error:
                self._book.notes.turned.append(Turned(None, Raised.of(error)))
                raise
            self._book.notes.turned.append(Turned(angles))
            return angles

        return noted
