"""The protocol of an Arduino, which gets one request at a time: a command if there is a new one, else a poll."""

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
    presence_question,
    speeds,
)
from drivers.serial.boards.rosarduino.requests import UNKNOWN, FirmwareProbe, Poll, PollSchedule, RequestQueue
from drivers.serial.driver import Side

SILENCE_S = 0.4
"""If a board has not answered for this many seconds plus the time-out of its slowest answer, it is lost or was
reset."""

URGENT_S = 0.02
"""The longest time, in seconds, that a stop waits for the answer to an earlier request."""

IDLE_S = 0.05
"""The period of asking for encoder counts if no encoder is open, in seconds. The answers show that the board is
connected."""

MAX_REFUSALS = 2
"""After this many refusals in a row, the board is asked for its firmware again. It must be robotcore_bridge, which
refuses commands without checksums, because ROSArduinoBridge refuses no complete command."""

FULL_DUTY = 255


class ArduinoProtocol(BoardProtocol):
    """Asks a board for its firmware; then sends each new command once, and polls counts and other values in between.

    Commands are in counts a frame (about 1/30 s), or duties from -1 to 1. Only a stop of both wheels is sent again if
    it is not acknowledged. A board that falls silent may have been reset. Then the protocol drops the command and asks
    for the firmware again.
    """

    default_timeout_s = 2.0
    """The time-out of both firmwares at the start, in seconds. Only that of robotcore_bridge can be changed."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.firmware = UNKNOWN
        self.is_duty_mode: bool | None = None
        self.counts: dict[Side, Counts] = {"left": Counts(), "right": Counts()}
        self._requests = RequestQueue()
        self._firmware_probe = FirmwareProbe(baud)
        self._counting = Poll(COUNTS, IDLE_S, self._count)
        self._polls = PollSchedule(self._counting)
        self._board_timeout_s: float | None = None
        self._unacknowledged: WheelCommand | None = None
        self._refusals = 0

    @property
    def silence_s(self) -> float:
        return SILENCE_S + self._polls.slowest_s

    @property
    def timeout_s(self) -> float:
        return super().timeout_s if self.firmware.is_robotcore_bridge else self.default_timeout_s

    @property
    def is_settled(self) -> bool:
        """Whether the newest command was acknowledged."""
        return super().is_settled and self._unacknowledged is None

    def count_every(self, period_s: float) -> None:
        """Set the period of asking for the encoders' counts, in seconds. On a slow line the actual period is longer."""
        self._counting.period_s = period_s

    def poll(self, poll: Poll) -> None:
        """Add a poll: a request that is sent periodically."""
        self._polls.add(poll)

    def begin(self, now: float) -> None:
        self._requests = RequestQueue()
        super().begin(now)

    def receive(self, data: bytes, now: float) -> None:
        if self._requests.receive(data, now):
            self._heard_at = now

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if self._requests.is_waiting(now):
            return self._interrupt_for_stop(now)
        if not self.is_ready:
            return self._requests.ask(self._firmware_probe.question(), self._identify, now)
        if not self._requests.is_sure:
            return self._resynchronize(now)
        return self._next_frame(now)

    def next_due(self, now: float) -> float:
        if (until := self._requests.until) is not None:
            return until
        return min(self.command.next_due, self._polls.next_due)

    def _lose(self, now: float) -> None:
        """Drop the command and all that is known of the board, and ask for its firmware next."""
        super()._lose(now)
        self._firmware_probe = FirmwareProbe(self.baud)
        self._unacknowledged, self._refusals = None, 0
        self._requests.give_up()
        self._requests.is_summed = None
        self._board_timeout_s = None
        for counts in self.counts.values():
            counts.restart()

    def _identify(self, answer: Answer, _: float) -> None:
        if firmware := self._firmware_probe.take(answer):
            self.firmware = firmware
            self._requests.is_summed = firmware.is_robotcore_bridge
            self._unacknowledged = WheelCommand()
            self._set_ready()

    def _resynchronize(self, now: float) -> bytes:
        """Return a request whose answer no other request has.

        Set the time-out again, because the board may have been reset.
        """
        self._board_timeout_s = None
        timeout_s = max(GREETING_S, self._polls.slowest_s)
        question = presence_question(self.baud, timeout_s, is_summed=self.firmware.is_robotcore_bridge)
        return self._requests.ask(question, _ignore, now)

    def _interrupt_for_stop(self, now: float) -> bytes:
        """Return the frame of a stop that has waited too long for the answer to an earlier request; else nothing."""
        if not (self._is_stop_due(now) and self._requests.is_overdue(now, URGENT_S)):
            return b""
        self._next_command(now)
        self._requests.interrupt()
        return STOP_NOW

    def _next_frame(self, now: float) -> bytes:
        has_to_stop = self._is_stop_due(now) or (self._unacknowledged and self._unacknowledged.is_stop)
        if self._needs_timeout and not has_to_stop:
            return self._set_timeout(now)
        if wheels := self._next_command(now):
            return self._requests.ask(self._drive_question(wheels), self._acknowledge, now)
        if poll := self._polls.take(now):
            return self._requests.ask(poll.question, poll.on_answer, now)
        return b""

    def _is_stop_due(self, now: float) -> bool:
        return self.command.next_due <= now and self.command.newest.is_stop

    def _next_command(self, now: float) -> WheelCommand | None:
        """Return the command to send now: a new one, or a stop that was not acknowledged."""
        if self.command.next_due <= now:
            self._unacknowledged = self.command.newest  # before `take`, so that `is_settled` is false all the time
            self._unacknowledged = self.command.take(now, self.timeout_s)
        elif self._unacknowledged and not self._unacknowledged.is_stop:
            return None
        return self._unacknowledged

    def _drive_question(self, wheels: WheelCommand) -> Question:
        if wheels.is_stop:
            return STOP
        if self.is_duty_mode:
            return duties(round(wheels.left * FULL_DUTY), round(wheels.right * FULL_DUTY))
        return speeds(round(wheels.left), round(wheels.right))

    def _acknowledge(self, answer: Answer, now: float) -> None:
        self._refusals = self._refusals + 1 if answer.is_refusal else 0
        if not self._refusals:
            self._unacknowledged = None
        elif self._refusals >= MAX_REFUSALS and not self.firmware.is_robotcore_bridge:
            self._lose(now)

    @property
    def _needs_timeout(self) -> bool:
        """Whether the board has not acknowledged its time-out yet. Until it has, no motor turns."""
        return self.firmware.is_robotcore_bridge and self._board_timeout_s != self.timeout_s

    def _set_timeout(self, now: float) -> bytes:
        timeout_s = self.timeout_s

        def confirm(answer: Answer, _: float) -> None:
            if not answer.is_refusal:
                self._board_timeout_s = timeout_s

        return self._requests.ask(deadman(round(timeout_s * 1000)), confirm, now)

    def _count(self, answer: Answer, now: float) -> None:
        if not answer.is_refusal:
            left, right = answer.numbers
            self.counts["left"].take(left, now)
            self.counts["right"].take(right, now)


def _ignore(answer: Answer, now: float) -> None:
    """Ignore an answer. Its arrival alone shows that the board is connected."""
