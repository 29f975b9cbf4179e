"""The queue and the schedule of requests to an Arduino, and the detection of its firmware."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeAlias, cast

from drivers.serial.boards.rosarduino.protocol import (
    GREETING_S,
    STOP,
    Parser,
    Reply,
    Request,
    duties,
    identity_request,
    remove_sum,
)

ReplyHandler = Callable[[Reply, float], None]
"""A function that handles a reply. Its second argument is the time of arrival in seconds."""


class RequestQueue:
    """Allows one pending request at a time, because a reply does not name its request. Any other line is dropped.

    After a time-out, the late reply may look like the reply to the next request. So the next request must have a unique
    reply. The board may also be slow after a time-out. So each request then waits at least `GREETING_S`, until a reply
    arrives in time.
    """

    def __init__(self) -> None:
        self.is_summed: bool | None = None
        """Whether every reply has a checksum; None until the firmware is known."""
        self.is_synchronized = True
        """Whether no late reply to an earlier request can arrive any more."""
        self._parser = Parser()
        self._asked: tuple[Request, ReplyHandler] | None = None
        self._asked_at = self._grace_s = 0.0

    @property
    def times_out_at(self) -> float | None:
        """The time at which the pending request times out; None if no request is pending."""
        return self._asked_at + max(self._asked[0].timeout_s, self._grace_s) if self._asked else None

    def ask(self, request: Request, on_reply: ReplyHandler, now: float) -> bytes:
        """Make ``request`` the pending request, and return its bytes. The caller sends them."""
        self._asked, self._asked_at = (request, on_reply), now
        return request.frame(is_summed=bool(self.is_summed))

    def receive(self, data: bytes, now: float) -> bool:
        """Parse received bytes; return whether they contain the reply to the pending request."""
        replies = [self._take_line(line, now) for line in self._parser.feed(data)]
        return any(replies)

    def drop_if_timed_out(self, now: float) -> None:
        """Drop the pending request if its reply did not arrive in time."""
        if self.times_out_at is not None and now >= self.times_out_at:
            self._grace_s = GREETING_S
            self.drop()

    @property
    def is_pending(self) -> bool:
        """Whether a request is pending."""
        return self._asked is not None

    def is_overdue(self, now: float, timeout_s: float) -> bool:
        """Return whether a request has been pending for longer than ``timeout_s``."""
        return self._asked is not None and now - self._asked_at > timeout_s

    def drop(self) -> None:
        """Drop the pending request. Its reply may still arrive."""
        self._asked, self.is_synchronized = None, False

    def interrupt(self) -> None:
        """Drop the pending request, because other data was sent. A request with a unique reply stays pending."""
        if self._asked and not self._asked[0].raw:
            self.drop()

    def _take_line(self, line: str, now: float) -> bool:
        text = self._remove_sum(line)
        if self._asked is None or text is None:
            return False
        request, on_reply = self._asked
        if (reply := request.parse_reply(text)) is None:
            return False
        self._asked = None
        self.is_synchronized = self.is_synchronized or bool(request.raw)
        if not request.raw and now - self._asked_at <= request.timeout_s:
            self._grace_s = 0.0
        on_reply(reply, now)
        return True

    def _remove_sum(self, line: str) -> str | None:
        if self.is_summed is None:
            return remove_sum(line) or line
        return remove_sum(line) if self.is_summed else line


@dataclass
class Poll:
    """A request that is sent periodically, and the handler of its replies."""

    request: Request
    period_s: float
    on_reply: ReplyHandler
    due: float = -math.inf
    """The time at which the request is sent next, in seconds."""


class PollSchedule:
    """Selects the poll that was due first, so that frequent polls do not block rare ones."""

    def __init__(self, *polls: Poll) -> None:
        self._polls = polls

    def add(self, poll: Poll) -> None:
        """Add a poll. Another thread may call `take` at the same time."""
        self._polls = (*self._polls, poll)

    def take(self, now: float) -> Poll | None:
        """Return the poll whose request is sent now; None if no poll is due."""
        poll = min(self._polls, key=lambda poll: poll.due)
        if now < poll.due:
            return None
        poll.due = now + poll.period_s
        return poll

    @property
    def next_due(self) -> float:
        """The time from which `take` returns a poll, in seconds."""
        return min(poll.due for poll in self._polls)

    @property
    def slowest_s(self) -> float:
        """The longest time-out among the requests of all polls, in seconds."""
        return max(poll.request.timeout_s for poll in self._polls)


VERSION = 1
"""The version of robotcore_bridge's protocol that this driver supports."""


@dataclass(frozen=True)
class Firmware:
    """The firmware of a board and its abilities."""

    is_robotcore_bridge: bool
    """Whether the firmware is robotcore_bridge."""
    control_period_s: float
    """The period of the firmware's velocity control in seconds. Speeds are encoder counts in this period."""
    has_wheels: bool = True
    takes_duties: bool = True
    problem: str = ""
    """Why this driver does not support the firmware, and the remedy; empty if the driver supports it."""


UNKNOWN = Firmware(is_robotcore_bridge=False, control_period_s=1 / 30, has_wheels=False, takes_duties=False)
"""The value for a board whose firmware is not known yet."""

_Probe: TypeAlias = Generator[Request, Reply, Firmware]
"""A generator that yields requests, receives the reply to each, and returns the firmware."""


class FirmwareProbe:
    """Detects the firmware of a board by several requests. The first request stops the motors."""

    def __init__(self, baud: int) -> None:
        self._baud = baud
        self._probe: _Probe | None = None
        self._next: Request | None = None

    def next_request(self) -> Request:
        """Return the next request. If the last request got no reply, return the first request again."""
        request, self._next = self._next, None
        if request is None:
            self._probe = _detect(self._baud)
            request = next(self._probe)
        return request

    def take(self, reply: Reply) -> Firmware | None:
        """Process the reply to the last request; return the firmware, or None if more requests are necessary."""
        assert self._probe
        try:
            self._next = self._probe.send(reply)
        except StopIteration as end:
            return cast("Firmware", end.value)
        return None


def _detect(baud: int) -> _Probe:
    # robotcore_bridge replies with its version, ROSArduinoBridge with its baud rate. One baud rate is no proof of
    # ROSArduinoBridge, because noise may have destroyed the half of the request that asks for the version.
    for _ in range(2):
        number = (yield identity_request(baud)).numbers[0]
        if number != baud:
            return _describe_robotcore_bridge(number)
    has_wheels = yield from _is_accepted(STOP)
    takes_duties = has_wheels and (yield from _is_accepted(duties(0, 0)))
    # The control period of the firmware has a whole number of milliseconds, 33.
    return Firmware(is_robotcore_bridge=False, control_period_s=0.033, has_wheels=has_wheels, takes_duties=takes_duties)


def _is_accepted(command: Request) -> Generator[Request, Reply, bool]:
    for _ in range(2):  # noise may cause one refusal
        if not (yield command).is_refusal:
            return True
    return False


def _describe_robotcore_bridge(version: int) -> Firmware:
    problem = (
        ""
        if version == VERSION
        else f"its firmware has version {version} of the protocol, and this robotcore supports {VERSION}; flash the "
        "firmware of this robotcore: robotcore firmware flash"
    )
    return Firmware(is_robotcore_bridge=True, control_period_s=1 / 30, problem=problem)
