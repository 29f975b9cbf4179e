"""The conversation with a board that answers, one question at a time: commands first, then what is read."""

from __future__ import annotations

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.command import WheelCommand
from drivers.serial.boards.rosarduino.devices import Counts
from drivers.serial.boards.rosarduino.protocol import (
    COUNTS,
    GREETING_S,
    STOP,
    STOP_NOW,
    Answer,
    Question,
    deadman,
    duties,
    speeds,
    still_there,
)
from drivers.serial.boards.rosarduino.requests import UNKNOWN, FirmwareProbe, Poll, PollSchedule, RequestQueue
from drivers.serial.driver import Side

SILENCE_S = 0.4
"""A board that has answered nothing for longer, beyond what its slowest answer may take, is lost or was reset."""

URGENT_S = 0.02
"""A stop waits no longer for an answer that is under way."""

IDLE_S = 0.05
"""A board whose encoders nobody reads is asked for them so often, to know that it is there,
and was not reset."""

MISTAKEN = 2
"""The true one refuses no command that is whole: one that refuses so many in a row is ours, and wants their sums."""

FULL_DUTY = 255


class ArduinoProtocol(BoardProtocol):
    """Asks a board who it is, tells it each new command once, and asks for counts and all else in between.

    ``command`` is in counts a frame, or, where the motors go by duty, from -1 to 1. What is not acknowledged is told
    again only where both wheels are to stand. A board that answers nothing any more is asked who it is until it tells:
    it may have been reset, so that nothing turns until it is told anew.
    """

    usual_timeout_s = 2.0
    """Of both firmwares; ours can be told otherwise."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.firmware = UNKNOWN
        self.goes_by_duty: bool | None = None
        self.counts: dict[Side, Counts] = {"left": Counts(), "right": Counts()}
        self._requests = RequestQueue()
        self._firmware_probe = FirmwareProbe(baud)
        self._counting = Poll(COUNTS, IDLE_S, self._count)
        self._polls = PollSchedule(self._counting)
        self._kept_timeout_s: float | None = None
        self._unacknowledged: WheelCommand | None = None
        self._refusals = 0

    @property
    def silence_s(self) -> float:
        return SILENCE_S + self._polls.slowest_s

    @property
    def timeout_s(self) -> float:
        return super().timeout_s if self.firmware.is_ours else self.usual_timeout_s

    @property
    def is_settled(self) -> bool:
        """Whether the newest command was acknowledged."""
        return super().is_settled and self._unacknowledged is None

    def count_every(self, period_s: float) -> None:
        """Ask for the encoders' counts so often, or as often as the line allows."""
        self._counting.period_s = period_s

    def poll(self, poll: Poll) -> None:
        """Ask something again and again from now on."""
        self._polls.add(poll)

    def begin(self, now: float) -> None:
        self._requests = RequestQueue()
        super().begin(now)

    def receive(self, data: bytes, now: float) -> None:
        if self._requests.receive(data, now):
            self._heard_at = now

    def due(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if self._requests.is_waiting(now):
            return self._urgent(now)
        if not self.is_ready:
            return self._requests.ask(self._firmware_probe.question(), self._identify, now)
        if not self._requests.is_sure:
            return self._resynchronize(now)
        return self._next(now)

    def next_due(self, now: float) -> float:
        if (until := self._requests.until) is not None:
            return until
        return min(self.command.next_due, self._polls.next_due)

    def _lose(self, now: float) -> None:
        """Know nothing of the board any more; who it is, it is asked next."""
        super()._lose(now)
        self._firmware_probe = FirmwareProbe(self.baud)
        self._unacknowledged, self._refusals = None, 0
        self._requests.give_up()
        self._requests.is_summed = None
        self._kept_timeout_s = None
        for counts in self.counts.values():
            counts.restart()

    def _identify(self, answer: Answer, _: float) -> None:
        if firmware := self._firmware_probe.answered(answer):
            self.firmware = firmware
            self._requests.is_summed = firmware.is_ours
            self._unacknowledged = WheelCommand()
            self._meet()

    def _resynchronize(self, now: float) -> bytes:
        """Find back into step; a board that was reset meanwhile has forgotten its time-out."""
        self._kept_timeout_s = None
        patience_s = max(GREETING_S, self._polls.slowest_s)
        question = still_there(self.baud, patience_s, is_summed=self.firmware.is_ours)
        return self._requests.ask(question, _ignore, now)

    def _urgent(self, now: float) -> bytes:
        """Return a stop that waits no longer for an answer."""
        if not (self._stop_is_due(now) and self._requests.is_overdue(now, URGENT_S)):
            return b""
        self._newest(now)
        self._requests.interrupt()
        return STOP_NOW

    def _next(self, now: float) -> bytes:
        has_to_stop = self._stop_is_due(now) or (self._unacknowledged and self._unacknowledged.stops)
        if self._has_to_limit and not has_to_stop:
            return self._limited(now)
        if wheels := self._newest(now):
            return self._requests.ask(self._driving(wheels), self._acknowledge, now)
        if poll := self._polls.take(now):
            return self._requests.ask(poll.question, poll.heard, now)
        return b""

    def _stop_is_due(self, now: float) -> bool:
        return self.command.next_due <= now and self.command.newest.stops

    def _newest(self, now: float) -> WheelCommand | None:
        """Return what the motors are to be told now: something new, or again that both are to stand."""
        if self.command.next_due <= now:
            self._unacknowledged = self.command.newest  # before it is taken, that nobody thinks it were heard
            self._unacknowledged = self.command.take(now, self.timeout_s)
        elif self._unacknowledged and not self._unacknowledged.stops:
            return None
        return self._unacknowledged

    def _driving(self, wheels: WheelCommand) -> Question:
        if wheels.stops:
            return STOP
        if self.goes_by_duty:
            return duties(round(wheels.left * FULL_DUTY), round(wheels.right * FULL_DUTY))
        return speeds(round(wheels.left), round(wheels.right))

    def _acknowledge(self, answer: Answer, now: float) -> None:
        self._refusals = self._refusals + 1 if answer.is_refusal else 0
        if not self._refusals:
            self._unacknowledged = None
        elif self._refusals >= MISTAKEN and not self.firmware.is_ours:
            self._lose(now)

    @property
    def _has_to_limit(self) -> bool:
        """Whether the board has not acknowledged the time-out that it is to have; until then nothing turns."""
        return self.firmware.is_ours and self._kept_timeout_s != self.timeout_s

    def _limited(self, now: float) -> bytes:
        timeout_s = self.timeout_s

        def keep(answer: Answer, _: float) -> None:
            if not answer.is_refusal:
                self._kept_timeout_s = timeout_s

        return self._requests.ask(deadman(round(timeout_s * 1000)), keep, now)

    def _count(self, answer: Answer, now: float) -> None:
        if not answer.is_refusal:
            left, right = answer.numbers
            self.counts["left"].take(left, now)
            self.counts["right"].take(right, now)


def _ignore(answer: Answer, now: float) -> None:
    """Take an answer that only has to come."""
