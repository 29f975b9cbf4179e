"""The program that the loopback test starts and ends: an app that turns a motor, with its run and its guardian.

    python -m drivers.raspberrypi.loopback.motor_program '{"robot": "robot.toml", "motor": "motor", "action": …}'

It writes its events as lines of JSON on standard output, with times of the machine's monotonic clock.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
from dataclasses import dataclass, field
from threading import Event
from typing import Literal

from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import read_timer
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.request import RunRequest
from robotcore.runtime.result import RealTimeNote
from robotcore.runtime.session import run
from robotcore.safety.real_time import read_priority_and_locked_memory

Action = Literal["tick", "drive", "stop", "hang", "block"]

DRIVING_TICKS = 6
"""The ticks for which the motor turns before each stop."""

RESTING_TICKS = 4
BLOCK_S = 3


@dataclass
class MotorProgramRequest:
    """The order for the motor program."""

    robot: str
    """The name or file of the robot."""
    motor: str
    rad_s: float
    """The velocity of the motor in rad/s."""
    action: Action
    """The app's action after `DRIVING_TICKS`. "tick" and "drive": the motor keeps turning. "stop": the app stops it.
    "hang": its step does not return for ``hang_s``. "block": a call in C holds the interpreter's lock for `BLOCK_S`."""
    trials: int = 1
    """The number of times that the app stops or hangs."""
    duration_s: float = 30.0
    """The time after which the app ends in any case."""
    hang_s: float = 0.4
    rate_hz: float = 20.0
    has_real_time_priority: bool = False
    rest_after_s: float = 0.0
    """The time for which the motor stands after each trial, in seconds, in addition to `RESTING_TICKS`."""


def report(event: str, **values: object) -> None:
    """Write an event and the time, in one call of the system."""
    os.write(1, json.dumps({"event": event, "at": read_timer(), **values}).encode() + b"\n")


@dataclass
class LoopbackApp(Behaviour):
    """Turns one motor, and stops, hangs or goes on."""

    request: MotorProgramRequest = field(kw_only=True)

    def __post_init__(self) -> None:
        self.needs = frozenset({self.request.motor})  # type: ignore[misc]  # the motor's name is known only now
        self._times: list[float] = []
        self._trials = self._ticks = 0
        self._parent = os.getppid()

    def step(self, robot: Robot) -> Status:
        request, motor = self.request, robot.motors[self.request.motor]
        self._times.append(read_timer())
        is_over = self._times[-1] - self._times[0] > request.duration_s
        rest = RESTING_TICKS + round(request.rest_after_s * request.rate_hz)
        is_done = self._trials >= request.trials and self._ticks == DRIVING_TICKS + rest
        if is_over or is_done or os.getppid() != self._parent:
            motor.stop()
            report("ticks", times=self._times, **read_priority_and_locked_memory())
            return Status.SUCCESS
        self._ticks = (self._ticks + 1) % (DRIVING_TICKS + rest + 1)
        if request.action in ("tick", "drive") or self._ticks <= DRIVING_TICKS:
            motor.set_velocity(request.rad_s)
            if len(self._times) == 2:
                report("driving")
        if self._ticks == DRIVING_TICKS:
            self._end_trial(motor)
        return Status.RUNNING

    def _end_trial(self, motor: object) -> None:
        match self.request.action:
            case "stop":
                report("stop")
                motor.stop()  # type: ignore[attr-defined]
            case "hang":
                report("hang")
                Event().wait(self.request.hang_s)
            case "block":
                report("block")
                ctypes.PyDLL(None).sleep(BLOCK_S)
            case _:
                return
        self._trials += 1


def main() -> None:
    """Run the app, and report its result."""
    request = MotorProgramRequest(**json.loads(sys.argv[1]))
    result = run(
        RunRequest(
            LoopbackApp(request=request),
            backend="raspberrypi",
            robot=request.robot,
            rate_hz=request.rate_hz,
            timeout_s=request.duration_s + 10,
            has_real_time_priority=request.has_real_time_priority,
            has_separate_motors=True,
        )
    )
    report(
        "result",
        outcome=result.outcome.value,
        reason=result.reason,
        ticks=result.ticks,
        overruns=result.overruns,
        real_time_notes=[note for note in result.notes if isinstance(note, RealTimeNote)],
        exit_status=result.exit_status,
    )
    sys.exit(result.exit_status)


if __name__ == "__main__":
    main()
