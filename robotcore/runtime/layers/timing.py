"""Measures the phases of each tick. The loop and the safety stage mark their beginnings and ends."""

from __future__ import annotations

from typing import Any

from robotcore.geometry import Wheels
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.hal.wall_clock import read_timer
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Send
from robotcore.runtime.tick_statistics import TickStatistics
from robotcore.safety.command_filter import ApplyRules


class TickTimer(Layer):
    """Measures the phases of the ticks of one loop.

    It is the layer next to the app: it times each read of a sensor, and each command to an actuator outside the drive.
    The loop calls the other methods.

    statistics: gets the durations of each tick.
    """

    def __init__(self, statistics: TickStatistics) -> None:
        self._add = statistics.add
        self._read_s = self._guard_s = self._send_s = 0.0
        """The times of the reads, of the rules without their reads, and of the commands since `begin_decision`."""
        self._tick_at = self._decision_at = self._record_at = self._sleep_at = 0.0
        self._decide_s: float | None = None
        """The time of the app's step in this tick. None until `begin_commit`."""

    def begin_tick(self) -> None:
        """Begin the first tick, or the first one after a time without ticks."""
        self._tick_at = read_timer()

    def begin_decision(self) -> None:
        """Begin the app's step. Until now the loop has read sensors for itself, such as the odometry's encoders."""
        self._decide_s = None
        self._read_s = self._guard_s = self._send_s = 0.0
        self._decision_at = read_timer()

    def begin_commit(self) -> None:
        """Begin the commit of the drive's command. A tick with an exception has none."""
        self._decide_s = read_timer() - self._decision_at - self._read_s - self._guard_s - self._send_s

    def begin_record(self) -> None:
        """Begin the calls of the observers."""
        self._record_at = read_timer()

    def begin_sleep(self) -> None:
        """Begin the sleep until the next tick."""
        self._sleep_at = read_timer()

    def end_tick(self) -> None:
        """Add the durations of the tick to the statistics, after the sleep. The next tick begins."""
        decision_at, record_at, read_s, guard_s = self._decision_at, self._record_at, self._read_s, self._guard_s
        act_s = record_at - decision_at - read_s - guard_s
        decide_s = act_s - self._send_s if self._decide_s is None else self._decide_s
        sleep_at, prepared_s = self._sleep_at, decision_at - self._tick_at
        self._tick_at = now = read_timer()
        self._add((prepared_s + read_s, decide_s, guard_s, act_s - decide_s, sleep_at - record_at, now - sleep_at))

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def read_timed() -> SampleT:
            start = read_timer()
            sample = read()
            self._read_s += read_timer() - start
            return sample

        return read_timed

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        def send_timed(command: Any) -> Any:
            start = read_timer()
            sent = send(command)
            self._send_s += read_timer() - start
            return sent

        return send_timed

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        """Return the output of a motor outside the drive, with timed commands."""

        def set_timed(rad_s: float) -> float:
            start = read_timer()
            sent = motor.set_velocity(rad_s)
            self._send_s += read_timer() - start
            return sent

        return MotorOutput(motor.name, set_timed, motor.stop)

    def wrap_rules(self, apply: ApplyRules) -> ApplyRules:
        """Return the function that applies the safety rules, with its time measured."""

        def apply_timed(wheels: Wheels) -> Wheels:
            start, read_s = read_timer(), self._read_s
            reduced = apply(wheels)
            self._guard_s += read_timer() - start - (self._read_s - read_s)
            return reduced

        return apply_timed
