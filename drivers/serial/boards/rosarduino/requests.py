"""The queue and the schedule of requests to an Arduino, and the detection of its firmware."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass

from drivers.serial.boards.rosarduino.protocol import (
    GREETING_S,
    STOP,
    Parser,
    Reply,
    Request,
    build_duty_request,
    build_identity_request,
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


NumbersHandler = Callable[[tuple[int, ...], float], None]
"""A function that handles the numbers in a reply. Its second argument is the time of arrival in seconds."""


@dataclass
class Poll:
    """A request that is sent periodically, and the handler of the numbers in its replies."""

    request: Request
    period_s: float
    on_numbers: NumbersHandler
    due: float = -math.inf
    """The time at which the request is sent next, in seconds."""

    def take_reply(self, reply: Reply, now: float) -> None:
        """Handle a reply. A refusal is ignored."""
        if not reply.is_refusal:
            self.on_numbers(reply.numbers, now)


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
    version: int = VERSION
    """The version of robotcore_bridge's protocol."""


UNKNOWN = Firmware(is_robotcore_bridge=False, control_period_s=1 / 30, has_wheels=False, takes_duties=False)
"""The value for a board whose firmware is not known yet."""


def detect_firmware(baud: int) -> Generator[Request, Reply, Firmware]:
    """Yield requests, take the reply to each, and return the firmware. The first request stops the motors."""
    # robotcore_bridge replies with its version, ROSArduinoBridge with its baud rate. One baud rate is no proof of
    # ROSArduinoBridge, because noise may have destroyed the half of the request that asks for the version.
    for _ in range(2):
        number = (yield build_identity_request(baud)).numbers[0]
        if number != baud:
            return Firmware(is_robotcore_bridge=True, control_period_s=1 / 30, version=number)
    has_wheels = yield from _is_accepted(STOP)
    takes_duties = has_wheels and (yield from _is_accepted(build_duty_request(0, 0)))
    # The control period of the firmware has a whole number of milliseconds, 33.
    return Firmware(is_robotcore_bridge=False, control_period_s=0.033, has_wheels=has_wheels, takes_duties=takes_duties)


def _is_accepted(command: Request) -> Generator[Request, Reply, bool]:
    for _ in range(2):  # noise may cause one refusal
        if not (yield command).is_refusal:
            return True
    return False
