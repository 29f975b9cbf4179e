"""Measures where the time of a run goes: in which devices, and in which lines of the app."""

from __future__ import annotations

import inspect
import sys
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from threading import Event, Thread, get_ident
from typing import Any, NamedTuple, TypeVar

from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.hal.wall_clock import read_timer
from robotcore.runtime.layers.base import MotorOutput, Reader, Send, Tap
from robotcore.runtime.loop import Loop
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.threads import start_thread

T = TypeVar("T")

PERIOD_S = 0.002
"""The time between two samples of the app's line, in seconds."""

JOIN_S = 1.0
"""The longest wait for the end of the thread that takes the samples, in seconds."""


@dataclass
class DeviceTimes:
    """The calls of one device."""

    calls: int = 0
    total_s: float = 0.0
    worst_s: float = 0.0

    def add(self, seconds: float) -> None:
        self.calls, self.total_s, self.worst_s = self.calls + 1, self.total_s + seconds, max(self.worst_s, seconds)


class DeviceTap(Tap):
    """Times each read of a sensor, and each command to an actuator.

    The times contain the injected faults and the simulated imperfections of the device.
    """

    def __init__(self) -> None:
        self.times: defaultdict[str, DeviceTimes] = defaultdict(DeviceTimes)
        """The times of each device, by its name."""

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return lambda: self._measure(sensor.name, read)

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        return lambda command: self._measure(actuator.name, send, command)

    def motor(self, motor: MotorOutput) -> MotorOutput:
        return MotorOutput(motor.name, lambda rad_s: self._measure(motor.name, motor.set_velocity, rad_s), motor.stop)

    def _measure(self, device: str, call: Callable[..., T], *args: object) -> T:
        start = read_timer()
        try:
            return call(*args)
        finally:
            self.times[device].add(read_timer() - start)


class AppLine(NamedTuple):
    """A line of the app's code."""

    file: str
    number: int
    call: str
    """The innermost function that the line calls; the app's own function if the line calls none in Python."""


class Profiler:
    """An observer that measures a run: ``run(request, [profiler], [profiler.layer])``.

    A thread samples every 2 ms which line of the app the loop executes. A call counts for the line that makes it, and
    is named. The lines are those of the files in the folder of the app.
    """

    def __init__(self) -> None:
        self.layer = DeviceTap()
        self.line_s: defaultdict[AppLine, float] = defaultdict(float)
        """The time that each line of the app has taken, in seconds."""
        self._has_ended = Event()
        self._thread: Thread | None = None

    def begin(self, run: RunContext) -> None:
        folder, loop = _find_folder(inspect.getfile(type(run.behaviour))), get_ident()
        self._thread = start_thread(lambda: self._take_samples(folder, loop), "profiler")

    def tick(self, record: TickRecord) -> None:
        """Do nothing: a thread takes the samples."""

    def end(self, result: RunResult) -> None:
        self._has_ended.set()
        if self._thread:
            self._thread.join(JOIN_S)

    def _take_samples(self, folder: Path, loop: int) -> None:
        last = read_timer()
        while not self._has_ended.wait(PERIOD_S):
            now = read_timer()
            if line := _find_line(folder, loop):
                self.line_s[line] += now - last
            last = now


def _find_line(folder: Path, thread: int) -> AppLine | None:
    """Return the innermost line in a file of ``folder`` that the loop of a thread calls. None if it calls none."""
    frame = innermost = sys._current_frames().get(thread)  # noqa: SLF001  Python offers no public function
    line: AppLine | None = None
    while frame and innermost:
        code = frame.f_code
        if frame.f_globals.get("__name__") == Loop.__module__:
            return line
        if line is None and _find_folder(code.co_filename) == folder:
            called = innermost.f_code
            line = AppLine(code.co_filename, frame.f_lineno, getattr(called, "co_qualname", called.co_name))
        frame = frame.f_back
    return None


@cache
def _find_folder(file: str) -> Path:
    return Path(file).resolve().parent
