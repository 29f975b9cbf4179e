"""Cutoffs at work for somebody who has no run: every motor is made to stand, once."""

from __future__ import annotations

from collections.abc import Iterable

from robotcore.errors import ResourceError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec, shared
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.hand import Hand, together
from robotcore.safety.guardian.link import Report

LIMIT_S = 10.0
"""For each deed of a cutoff, longer than the guardian gives: nobody waits for the next one, and a system that starts or
ends is slow."""


def make_stand(specs: Iterable[CutoffSpec]) -> Report:
    """Open the cutoffs, stop, and close them; return what was stopped, and what could not be, each with its fault.

    One that fails or hangs holds up no other, and nothing is raised. Without threads, which the system may refuse, one
    that hangs holds up those after it.
    """
    clock = MonotonicClock()
    hands = [_hand(spec, clock) for spec in shared(specs)]
    opened = together(hands, "open", LIMIT_S, clock)
    ready = [hand for hand in hands if hand.device in opened.done]
    stopped = together(ready, "stop", LIMIT_S, clock)
    together(hands, "close", LIMIT_S, clock)
    return Report("stop", stopped.done, (*opened.failed, *stopped.failed), stopped.told)


def _hand(spec: CutoffSpec, clock: Clock) -> Hand:
    """Return a hand with a thread of its own, or without one if the system refuses it: a stop needs none."""
    try:
        return Hand(spec, clock)
    except ResourceError:
        return Hand(spec, clock, in_place=True)
