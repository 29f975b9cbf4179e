"""Measures the jitter of a run's ticks while other programs keep every processor busy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from drivers.raspberrypi.loopback.board import MAX_RAD_S, MOTOR, write_loopback_robot
from drivers.raspberrypi.loopback.motor_program import MotorProgramRequest
from drivers.raspberrypi.loopback.percentiles import Percentiles
from drivers.raspberrypi.loopback.processes import START_S, load_processors, run_program
from drivers.raspberrypi.loopback.wires import LoopbackWire
from robotcore.description import Safety
from robotcore.hal.loopback import RuleResult
from robotcore.safety.deadman import MIN_LEASE_S

RATES_HZ = (20, 50)
LATE_SHARE = 0.01
"""The greatest share of ticks that may begin more than half a period late."""

RULES = tuple(f"ticks-{rate}hz" for rate in RATES_HZ)
RT_RULES = tuple(f"{rule}-rt" for rule in RULES)


class Jitter(NamedTuple):
    """The jitter of a series of ticks."""

    percentiles: Percentiles
    """The differences between the time from tick to tick and the period, in seconds."""
    late_ticks: int
    """The number of ticks that began more than half a period late, after the one before."""
    ticks: int

    @classmethod
    def from_times(cls, times: Sequence[float], rate_hz: float) -> Jitter:
        """Return the jitter of ticks, by their beginnings in seconds.

        >>> Jitter.from_times([0.0, 0.05, 0.101, 0.15], 20.0).late_ticks
        0
        """
        return cls.from_runs([times], rate_hz)

    @classmethod
    def from_runs(cls, runs: Iterable[Sequence[float]], rate_hz: float) -> Jitter:
        """Return the jitter of the ticks of several runs."""
        period = 1 / rate_hz
        late = [after - before - period for times in runs for before, after in pairwise(times)]
        return cls(Percentiles.from_durations(map(abs, late)), sum(each > period / 2 for each in late), len(late))


def compute_lease(rate_hz: float) -> float:
    """Return the lease of a command in seconds, with the limits of a robot's file that has none."""
    return max(Safety().lease_ticks / rate_hz, MIN_LEASE_S)


def measure_ticks(
    wires: Sequence[LoopbackWire],
    folder: Path,
    duration_s: float,
    write: Callable[[str], object],
    *,
    is_real_time: bool,
) -> Iterator[RuleResult]:
    """Run an app at each rate, and yield the jitter. The motor turns at half speed meanwhile."""
    robot = write_loopback_robot(wires, folder)
    for rate, rule in zip(RATES_HZ, RT_RULES if is_real_time else RULES, strict=True):
        write(f"{rule}: {duration_s:g} s at {rate} Hz, all processors busy")
        request = MotorProgramRequest(
            str(robot),
            MOTOR,
            MAX_RAD_S / 2,
            "tick",
            rate_hz=rate,
            duration_s=duration_s,
            has_real_time_priority=is_real_time,
        )
        with load_processors() as load, run_program(request) as program:
            ticks = program.await_event("ticks", START_S + duration_s)
            if ticks is None:
                yield RuleResult.fail(rule, f"the run failed: {program.describe_failure()}")
                continue
            result = program.await_event("result") or {}
        if is_real_time and not ticks["priority"]:
            reasons = result.get("real_time_notes") or ["the run had no real-time priority. Run the test again"]
            yield RuleResult.fail(rule, ". ".join(reasons))
            continue
        granted = {key: ticks[key] for key in ("priority", "locked_kb")} if is_real_time else {}
        yield build_jitter_result(rule, Jitter.from_times(ticks["times"], rate), rate, load_programs=load, **granted)


def build_jitter_result(rule: str, jitter: Jitter, rate_hz: float, **values: float) -> RuleResult:
    """Return the result of a rule: the deadman would not have stopped the motors, and few ticks were late."""
    period, worst_s = 1 / rate_hz, compute_lease(rate_hz) - 1 / rate_hz
    is_met = (
        jitter.percentiles.p99 <= period / 2
        and jitter.percentiles.worst < worst_s
        and jitter.late_ticks <= LATE_SHARE * jitter.ticks
    )
    return RuleResult.from_measurement(
        rule,
        f"{jitter.percentiles}, {jitter.late_ticks} of {jitter.ticks} ticks late by half a period",
        f"p99 at most {period / 2 * 1e3:g} ms, worst below {worst_s * 1e3:g} ms, at most {LATE_SHARE:.0%} late",
        is_met=is_met,
        reason="Run the app with --rt or a lower --rate, or end other programs",
        late_ticks=jitter.late_ticks,
        ticks=jitter.ticks,
        **jitter.percentiles.values,
        **values,
    )
