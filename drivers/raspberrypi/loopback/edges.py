"""Records the edges of an input with the kernel's time stamps."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from threading import Event
from typing import Any, NamedTuple

from drivers.raspberrypi.pins import stop_edge_detection, translate_pin_errors

WAIT_S = 0.002


class Edge(NamedTuple):
    """An edge of an input."""

    time: float
    """The time on the machine's monotonic clock, in seconds."""
    is_high: bool
    """Whether the input is high after the edge."""


class StopTrial(NamedTuple):
    """The measurement of one stop."""

    was_high: bool
    """Whether the input was high when the stop began. If not, the motor did not turn, and nothing was measured."""
    low_after_s: float | None
    """The time from the beginning of the stop until the input stayed low, in seconds; None if it did not stay low."""


class EdgeRecorder:
    """Records the edges of an input while its context lasts. The pull is down, as for a motor board's input.

    gpio: the number of the input.
    pins: gpiozero's pin factory.
    """

    def __init__(self, gpio: int, pins: Any) -> None:
        self._gpio, self._pins = gpio, pins
        self._opened = ExitStack()
        self.edges: list[Edge] = []

    def __enter__(self) -> EdgeRecorder:
        from gpiozero import InputDevice

        with ExitStack() as opened, translate_pin_errors("loopback", (self._gpio,)):
            self._input = opened.enter_context(InputDevice(self._gpio, pull_up=False, pin_factory=self._pins))
            pin = self._input.pin
            pin.edges = "both"
            opened.callback(stop_edge_detection, pin)
            pin.when_changed = self._add  # gpiozero has only a weak reference to this object
            self._opened = opened.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def _add(self, ticks: Any, level: Any) -> None:
        self.edges.append(Edge(float(ticks), bool(level)))

    @property
    def is_high(self) -> bool:
        """The present level of the input."""
        return bool(self._input.pin.state)

    def wait_for(self, *, is_high: bool, since: float, timeout_s: float) -> Edge | None:
        """Return the first edge to a level after a time; None if there is none within a time-out in seconds."""
        end = self._pins.ticks() + timeout_s
        while True:
            for edge in tuple(self.edges):
                if edge.is_high == is_high and edge.time >= since:
                    return edge
            if self._pins.ticks() > end:
                return None
            Event().wait(WAIT_S)

    def find_stop(self, since: float, until: float) -> StopTrial:
        """Return whether the input was high at a time, and how soon it was low. The call waits for ``until``."""
        Event().wait(max(0.0, until - self._pins.ticks()) + WAIT_S)
        return compute_stop(tuple(self.edges), since, until)


def compute_stop(edges: Sequence[Edge], since: float, until: float) -> StopTrial:
    """Return whether the input was high at ``since``, and when its last falling edge before ``until`` was.

    >>> compute_stop([Edge(1.0, True), Edge(2.5, False), Edge(9.0, True)], since=2.0, until=3.0)
    StopTrial(was_high=True, low_after_s=0.5)
    >>> compute_stop([Edge(1.0, True)], since=2.0, until=3.0)
    StopTrial(was_high=True, low_after_s=None)
    >>> compute_stop([Edge(1.0, True), Edge(1.5, False)], since=2.0, until=3.0)
    StopTrial(was_high=False, low_after_s=None)
    """
    first = next((edge for edge in reversed(edges) if edge.time <= since), None)
    last = next((edge for edge in reversed(edges) if edge.time < until), None)
    if first is None or last is None or not first.is_high:
        return StopTrial(was_high=False, low_after_s=None)
    return StopTrial(was_high=True, low_after_s=None if last.is_high else last.time - since)
