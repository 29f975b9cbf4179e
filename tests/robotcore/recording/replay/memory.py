"""Record runs in memory, without a file, and disturb them."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import count
from typing import Any

from robotcore.errors import DeviceError, Interrupted, RobotcoreError
from robotcore.hal.device import Actuator, Device, Sample, SampleT, Sensor
from robotcore.recording import GroundTruthSample, RecordedError, Recording, SampleKey, Tick
from robotcore.recording.recording import build_metadata
from robotcore.recording.tap import RecordingTap
from robotcore.recording.writer import TickBuilder
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.layers.base import Reader, Send, Tap
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext, RunRequest, run
from robotcore.runtime.trace import TickRecord


class Memory:
    """An observer that collects the events of its recording layer."""

    def __init__(self) -> None:
        self.layer = RecordingTap(lambda: True)
        self.ticks: list[Tick] = []
        self.samples: dict[SampleKey, Sample] = {}
        self.truth: list[GroundTruthSample] = []
        self.result: RunResult | None = None

    def begin(self, run: RunContext) -> None:
        self.run, self.metadata = run, build_metadata(run)
        self._builder = TickBuilder(run.description)

    def tick(self, record: TickRecord) -> None:
        events, error = self.layer.take(), self.layer.find_latched(record.interventions) or sys.exc_info()[1]
        self.samples |= dict(events.samples)
        raised = RecordedError.from_error(error) if isinstance(error, (RobotcoreError, Interrupted)) else None
        self.ticks.append(self._builder.build(record, events, raised))
        if truth := self.run.truth:
            self.truth.append(GroundTruthSample(record.tick, record.time, truth.pose, truth.contacts))

    def end(self, result: RunResult) -> None:
        self.result = result

    @property
    def recording(self) -> Recording:
        return Recording(self.metadata, self.ticks, self.samples, self.result, self.truth)


class FailingDevices(Tap):
    """A tap that makes every n-th call of the sensors or displays of a class fail."""

    def __init__(self, kind: type[Device], every: int, first: int = 1) -> None:
        self._kind, self._every, self._calls = kind, every, count(first)

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return partial(self._call, sensor, read)

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        return partial(self._call, actuator, send)

    def _call(self, device: Device, call: Callable[..., Any], *arguments: Any) -> Any:
        if isinstance(device, self._kind) and next(self._calls) % self._every == 0:
            raise DeviceError(device.name, "no answer")
        return call(*arguments)


class Disturbance(Tap):
    """A tap and observer that calls a function before tick ``at``, or at the first read of a sensor in this tick."""

    def __init__(self, at: int, disturb: Callable[[RunContext], object], *, is_in_tick: bool = False) -> None:
        self._at, self._disturb, self._is_in_tick = at, disturb, is_in_tick
        self._now = 0

    def begin(self, run: RunContext) -> None:
        self._run = run

    def tick(self, record: TickRecord) -> None:
        self._now = record.tick + 1
        if self._now == self._at and not self._is_in_tick:
            self._disturb(self._run)

    def end(self, result: RunResult) -> None:
        """Do nothing, because the disturbance came before, or the run ended earlier."""

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def reader() -> SampleT:
            if self._now == self._at and self._is_in_tick:
                self._is_in_tick = False
                self._disturb(self._run)
            return read()

        return reader


def press_emergency_stop(run: RunContext) -> None:
    run.emergency.press("the button was pressed")


def send_signal(number: signal.Signals) -> Callable[[RunContext], None]:
    return lambda _: signal.raise_signal(number)


def record_run(
    app: str | type[Behaviour] | Behaviour = "green-search",
    *,
    disturbance: Disturbance | None = None,
    below: Sequence[Tap] = (),
    **asked: Any,
) -> Recording:
    """Run an app, and return its recording.

    below: taps below the recording layer, which disturb the run. The ``disturbance`` is one of them.
    """
    memory, others = Memory(), [disturbance] if disturbance else []
    run(RunRequest(app, **asked), [memory, *others], [*others, *below, memory.layer])
    return memory.recording


def change_tick(recording: Recording, number: int, **changes: Any) -> Recording:
    """Return the recording with one changed tick."""
    ticks = [replace(tick, **changes) if tick.number == number else tick for tick in recording.ticks]
    return replace(recording, ticks=ticks)
