"""Measures outputs over the wires: levels, latency, the duty and frequency of PWM, and a motor's commands."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from itertools import pairwise
from threading import Event
from typing import Any

from drivers.raspberrypi.loopback.board import HZ, MAX_RAD_S, open_loopback_motor
from drivers.raspberrypi.loopback.edges import Edge, EdgeRecorder
from drivers.raspberrypi.loopback.percentiles import Percentiles
from drivers.raspberrypi.loopback.wires import LoopbackWire
from drivers.raspberrypi.pins import open_output
from robotcore.hal.loopback import RuleResult

TOGGLES = 50
"""The changes of a level for one measurement."""

PAUSE_S = 0.01
LATE_S = 0.5
"""An edge later than this many seconds after its command is lost."""

LATENCY_BOUND_S = 0.01
PWM_S = 1.0
DUTIES = (0.25, 0.5, 0.75)
DUTY_BOUND = 0.02
FREQUENCY_BOUND = 0.02
RULES = ("levels", "output-latency", *(f"pwm-duty-{duty:.0%}".rstrip("%") for duty in DUTIES), "motor-latency")


def measure_levels(wires: Sequence[LoopbackWire], pins: Any) -> Iterator[RuleResult]:
    """Drive each wire high and low, and yield whether its input follows, and how long after the command."""
    errors, delays = 0, list[float]()
    for wire in wires:
        with ExitStack() as opened, EdgeRecorder(wire.input, pins) as recorder:
            output = open_output("loopback", wire.output, pins, opened)
            for number in range(TOGGLES):
                is_high = number % 2 == 0
                commanded = pins.ticks()
                output.value = is_high
                edge = recorder.wait_for(is_high=is_high, since=commanded, timeout_s=LATE_S)
                errors += edge is None or recorder.is_high is not is_high
                delays += [edge.time - commanded] if edge else []
                Event().wait(PAUSE_S)
    total = TOGGLES * len(wires)
    yield RuleResult.from_measurement(
        "levels",
        f"{errors} of {total} levels wrong",
        "0 wrong",
        is_met=not errors,
        reason="Check the contacts of both wires",
        wrong=errors,
        levels=total,
    )
    yield _build_latency_result("output-latency", delays, LATENCY_BOUND_S)


def _build_latency_result(rule: str, delays: Sequence[float], bound_s: float) -> RuleResult:
    if not delays:
        return RuleResult.fail(rule, f"no edge within {LATE_S:g} s of a command. Check the contacts of both wires")
    percentiles = Percentiles.from_durations(delays)
    return RuleResult.from_measurement(
        rule,
        str(percentiles),
        f"worst at most {bound_s * 1e3:g} ms",
        is_met=percentiles.worst <= bound_s,
        reason="End other programs on the Pi",
        **percentiles.values,
    )


def measure_pwm(wires: Sequence[LoopbackWire], pins: Any) -> Iterator[RuleResult]:
    """Turn a motor at several duties, and yield the duty and frequency on the wire. The other direction stays low."""
    forward, backward = wires
    delays = []
    with (
        EdgeRecorder(forward.input, pins) as seen,
        EdgeRecorder(backward.input, pins) as other,
        closing(open_loopback_motor(wires, pins)) as motor,
    ):
        for duty in DUTIES:
            commanded = pins.ticks()
            motor.set_velocity(duty * MAX_RAD_S)
            first = seen.wait_for(is_high=True, since=commanded, timeout_s=LATE_S)
            delays += [first.time - commanded] if first else []
            Event().wait(PWM_S)
            edges = [edge for edge in seen.edges if edge.time >= commanded]
            motor.stop()
            Event().wait(2 / HZ)
            yield _build_pwm_result(f"pwm-duty-{duty:.0%}".rstrip("%"), duty, edges, len(other.edges))
            seen.edges.clear()
    # A duty takes effect with the next cycle of the PWM.
    yield _build_latency_result("motor-latency", delays, 1 / HZ + LATENCY_BOUND_S)


def _build_pwm_result(rule: str, duty: float, edges: Sequence[Edge], others: int) -> RuleResult:
    rises = [edge.time for edge in edges if edge.is_high]
    bound = f"{duty:.0%} ± {DUTY_BOUND:.0%}, {HZ:g} Hz ± {FREQUENCY_BOUND:.0%}, 0 edges backward"
    if len(rises) < 3:
        return RuleResult.from_measurement(
            rule, f"{len(edges)} edges", bound, is_met=False, reason="Check wire 1", edges=len(edges)
        )
    whole = [edge for edge in edges if rises[0] <= edge.time <= rises[-1]]
    high_s = sum(after.time - before.time for before, after in pairwise(whole) if before.is_high)
    total_s = rises[-1] - rises[0]
    share, frequency = high_s / total_s, (len(rises) - 1) / total_s
    periods = Percentiles.from_durations(abs(after - before - 1 / HZ) for before, after in pairwise(rises))
    is_met = abs(share - duty) <= DUTY_BOUND and abs(frequency / HZ - 1) <= FREQUENCY_BOUND and not others
    return RuleResult.from_measurement(
        rule,
        f"{share:.1%}, {frequency:.2f} Hz, {others} edges backward; a period is off by {periods}",
        bound,
        is_met=is_met,
        reason="End other programs on the Pi; software PWM needs a free processor",
        duty=round(share, 4),
        frequency_hz=round(frequency, 3),
        edges_backward=others,
        **{f"period_{name}": value for name, value in periods.values.items()},
    )
