"""Measures how many edges the drivers of encoders lose, at several rates."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from threading import Event
from typing import Any

from drivers.raspberrypi.encoders import EncoderDriver, Pulses, Quadrature
from drivers.raspberrypi.loopback.board import build_context
from drivers.raspberrypi.loopback.wires import LoopbackWire
from drivers.raspberrypi.pins import open_output
from robotcore.hal.loopback import RuleResult
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.encoder import Encoder, EncoderDescription

RATES = (200, 1000, 4000)
"""The rates in edges per second. A disc of 20 slots on a wheel that turns twice a second has 80 or 160."""

LOSSLESS_EDGES_PER_S = 1000
"""Up to this rate no edge may be lost."""

LOST_SHARE = 0.01
"""The greatest share of lost edges at a higher rate."""

DURATION_S = 0.5
SETTLE_S = 0.5
SPIN_S = 0.001
EDGES_PER_TURN = 1000
RULES = tuple(f"{kind}-{rate}" for kind in ("pulses", "quadrature") for rate in RATES)


def measure_encoders(wires: Sequence[LoopbackWire], pins: Any) -> Iterator[RuleResult]:
    """Generate edges on the wires, and yield how many edges the drivers of encoders count."""
    a, b = wires
    yield from _measure("pulses", Pulses(gpio=a.input, counts="edges", pull_up=False), [a], wires, pins)
    yield from _measure(
        "quadrature", Quadrature(a=a.input, b=b.input, counts="edges", pull_up=False), [a, b], wires, pins
    )


def _measure(
    kind: str, driver: EncoderDriver, driven: Sequence[LoopbackWire], wires: Sequence[LoopbackWire], pins: Any
) -> Iterator[RuleResult]:
    description = EncoderDescription(kind="encoder", name=kind, counts_per_turn=EDGES_PER_TURN)
    for rate in RATES:
        with ExitStack() as opened:
            outputs = [open_output("loopback", wire.output, pins, opened) for wire in driven]
            context = build_context(wires, pins)
            encoder: Encoder = opened.enter_context(closing(driver.open(description, context)))
            edges = int(rate * DURATION_S) // 4 * 4  # whole cycles, so that every output ends low
            start = pins.ticks()
            _generate(outputs, edges, rate, pins.ticks)
            took_s = pins.ticks() - start
            counted = _wait_for(encoder, edges)
        yield _build_result(f"{kind}-{rate}", edges, counted, rate, edges / took_s)


def _generate(outputs: Sequence[Any], edges: int, rate: float, now: Callable[[], float]) -> None:
    """Toggle the outputs in turn, so that the first one leads by a quarter of a cycle."""
    start = now()
    for number in range(edges):
        due = start + number / rate
        if (left := due - now()) > SPIN_S:
            Event().wait(left - SPIN_S / 2)
        while now() < due:
            pass
        turn, which = divmod(number, len(outputs))
        outputs[which].value = turn % 2 == 0


def _wait_for(encoder: Encoder, edges: int) -> int:
    """Return the edges that the encoder has counted, when all have come or no more come."""
    clock = MonotonicClock()
    while True:
        counted = round(encoder.read().angle / math.tau * EDGES_PER_TURN)
        if counted == edges or clock.now() > SETTLE_S:
            return counted
        Event().wait(SPIN_S)


def _build_result(rule: str, edges: int, counted: int, rate: int, achieved: float) -> RuleResult:
    most = 0 if rate <= LOSSLESS_EDGES_PER_S else math.floor(edges * LOST_SHARE)
    lost = edges - counted
    return RuleResult.from_measurement(
        rule,
        f"{lost} of {edges} edges lost, at {achieved:.0f} edges/s",
        f"at most {most} lost",
        is_met=abs(lost) <= most,
        reason="Use an encoder with fewer edges a turn, or end other programs on the Pi",
        lost=lost,
        edges=edges,
        edges_per_s=round(achieved, 1),
    )
