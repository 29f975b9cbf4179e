"""Measure how soon the wheels stop after the input of the person who drives has ended.

    python -m benchmarks.silent_operator

In each trial, another process sends velocities 20 times a second, and a thread of the run gives them to the operator's
input. At a random moment, the process is killed or suspended, so that the input is silent. The run is in real time. The
delay ends with the tick that stops the wheels. The exit status is 1 if a robot did not stop, or if the 99th percentile
of the delays is above the bound.
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from collections.abc import Iterator
from random import Random
from threading import Event, Thread
from typing import NamedTuple

from benchmarks.report import parse_options, print_table
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.observer import RunContext
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import run
from robotcore.runtime.trace import TickRecord
from robotcore.safety.velocity_limits import STOPPED
from robotcore.threads import start_thread

BOUND_S = 0.3
LIMIT_S = 10.0
"""The longest wait for the wheels, in seconds."""
MOMENTS_S = (0.05, 0.4)
"""The shortest and the longest time between the first motion and the end of the input, in seconds."""
SENDER = """
import sys, time
while True:
    sys.stdout.write("0.0 1.5\\n")
    sys.stdout.flush()
    time.sleep(0.05)
"""
"""The program that sends velocities. It turns on the spot, so that no obstacle stops the robot."""
WAYS = {"killed (SIGKILL)": signal.SIGKILL, "suspended (SIGSTOP)": signal.SIGSTOP}


class Trial(NamedTuple):
    """A trial, and the delay in seconds until the wheels stopped; infinite if they did not."""

    backend: str
    way: str
    delay_s: float


class Wheels:
    """An observer that executes the trials in a thread, while the run's thread notes when the wheels turn and stop."""

    def __init__(self, backend: str, trials: int, draw: Random) -> None:
        self.trials: list[Trial] = []
        self._backend, self.count, self._draw = backend, trials, draw
        self._clock = MonotonicClock()
        self._turning, self._standing = Event(), Event()
        self._stopped_at = math.inf
        self._thread: Thread | None = None

    def begin(self, context: RunContext) -> None:
        self._context = context
        self._thread = start_thread(self._execute, "trials")

    def tick(self, record: TickRecord) -> None:
        if record.sent == STOPPED and self._turning.is_set():
            self._stopped_at = self._clock.now()
            self._turning.clear()
            self._standing.set()
        elif record.sent and record.sent != STOPPED:
            self._standing.clear()
            self._turning.set()
        if self._thread and not self._thread.is_alive():
            self._context.emergency.press("all trials have ended")

    def end(self, result: RunResult) -> None:
        if self._thread:
            self._thread.join()

    def _execute(self) -> None:
        for index in range(self.count):
            self.trials.append(self._measure(list(WAYS)[index % len(WAYS)]))

    def _measure(self, way: str) -> Trial:
        command = [sys.executable, "-S", "-c", SENDER]
        sender = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603  a fixed command
        receiver = start_thread(lambda: self._receive(sender), "receiver")
        has_turned = self._turning.wait(LIMIT_S)
        self._clock.sleep_until(self._clock.now() + self._draw.uniform(*MOMENTS_S))
        ended = self._clock.now()
        sender.send_signal(WAYS[way])
        has_stopped = self._standing.wait(LIMIT_S)
        sender.kill()
        sender.wait()
        receiver.join()
        return Trial(self._backend, way, self._stopped_at - ended if has_turned and has_stopped else math.inf)

    def _receive(self, sender: subprocess.Popen[str]) -> None:
        assert sender.stdout
        assert self._context.operator
        with sender.stdout:
            for line in sender.stdout:
                linear, angular = map(float, line.split())
                self._context.operator.drive(linear, angular)


def main() -> int:
    """Execute the trials, and print the delays."""
    options = parse_options(__doc__, trials=100, seed=1, backends="kinematic,virtualpi,mujoco")
    backends, draw, trials = options.backends.split(","), Random(options.seed), []
    for index, backend in enumerate(backends):
        wheels = Wheels(backend, len(range(index, options.trials, len(backends))), draw)
        if wheels.count:
            request = RunRequest("teleop", backend, world="open", timeout_s=3600.0, realtime=True, has_operator=True)
            run(request, [wheels])
        trials += wheels.trials
    print_table(("backend", "the sender is", "trials", "median, ms", "p99, ms", "worst, ms"), _build_rows(trials))
    p99 = compute_p99([each.delay_s for each in trials])
    stopped = sum(math.isfinite(each.delay_s) for each in trials)
    print(f"\n{stopped} of {options.trials} stopped; p99 {1000 * p99:.0f} ms, at most {1000 * BOUND_S:.0f}")
    return int(stopped < options.trials or p99 > BOUND_S)


def compute_p99(delays: list[float]) -> float:
    """Return the 99th percentile by the nearest rank."""
    return sorted(delays)[math.ceil(0.99 * len(delays)) - 1]


def _build_rows(trials: list[Trial]) -> Iterator[tuple[str, ...]]:
    for backend, way in dict.fromkeys((each.backend, each.way) for each in trials):
        delays = sorted(each.delay_s for each in trials if (each.backend, each.way) == (backend, way))
        values = (delays[len(delays) // 2], compute_p99(delays), delays[-1])
        yield backend, way, str(len(delays)), *(f"{1000 * value:.0f}" for value in values)


if __name__ == "__main__":
    sys.exit(main())
