"""The protocol of an Arduino, which sends commands, and polls in between."""

from __future__ import annotations

from drivers.serial.boards.board import BoardProtocol, WheelCommand
from drivers.serial.boards.rosarduino.devices import WheelCounter
from drivers.serial.boards.rosarduino.protocol import (
    BATTERY,
    COUNTS,
    GREETING_S,
    STOP,
    STOP_NOW,
    Reply,
    Request,
    build_deadman_request,
    build_duty_request,
    build_presence_request,
    build_speed_request,
)
from drivers.serial.boards.rosarduino.requests import UNKNOWN, NumbersHandler, Poll, RequestQueue, detect_firmware
from drivers.serial.driver import Side

SILENCE_S = 0.4
"""If a board has not replied for this many seconds plus the longest time-out of its requests, it is lost or was
reset."""

URGENT_S = 0.02
"""The longest time, in seconds, that a stop waits for the reply to an earlier request."""

IDLE_S = 0.05
"""The period of requesting encoder counts if no encoder is open, in seconds. The replies show that the board is
connected."""

MAX_REFUSALS = 2
"""After this many refusals in a row, the protocol detects the firmware again. ROSArduinoBridge refuses no valid
command. So the board probably runs robotcore_bridge, which refuses commands without checksums."""

BATTERY_S = 0.5
"""The period of requesting the battery's voltage, in seconds."""

FULL_DUTY = 255


class ArduinoProtocol(BoardProtocol):
    """Detects the firmware of a board, then sends each new command once, and polls encoder counts and other values.

    Commands are in counts per control period (about 1/30 s), or duties from -1 to 1. If the board does not acknowledge
    a stop of both wheels, the protocol sends it again. It repeats no other command. A board that falls silent may have
    been reset. Then the protocol drops the command and detects the firmware again.
    """

    default_timeout_s = 2.0
    """The time-out of both firmwares after power-on, in seconds. Only robotcore_bridge has a command to change it."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.firmware = UNKNOWN
        self.is_duty_mode: bool | None = None
        self.counters: dict[Side, WheelCounter] = {"left": WheelCounter(), "right": WheelCounter()}
        self.has_battery = True
        """Whether the newest reply to the request for the battery's voltage was a voltage."""
        self._requests = RequestQueue()
        self._probe = detect_firmware(baud)
        self._next_probe: Request | None = None
        self._polls: tuple[Poll, ...] = (Poll(COUNTS, IDLE_S, self._count),)
        self._board_timeout_s: float | None = None
        self._unacknowledged: WheelCommand | None = None
        self._refusals = 0

    @property
    def silence_s(self) -> float:
        return SILENCE_S + self._slowest_poll_s

    @property
    def timeout_s(self) -> float:
        return super().timeout_s if self.firmware.is_robotcore_bridge else self.default_timeout_s

    @property
    def is_settled(self) -> bool:
        """Whether the newest command was acknowledged."""
        return super().is_settled and self._unacknowledged is None

    def count_every(self, period_s: float) -> None:
        """Set the period of requesting encoder counts, in seconds. On a slow line the actual period is longer."""
        self._polls[0].period_s = period_s

    def poll(self, request: Request, period_s: float, on_numbers: NumbersHandler) -> None:
        """Add a request that is sent every ``period_s`` seconds. Another thread may send requests meanwhile."""
        self._polls = (*self._polls, Poll(request, period_s, on_numbers))

    def measure_voltage(self) -> None:
        """Request the battery's voltage periodically. Only robotcore_bridge has a request for it."""
        self.poll(BATTERY, BATTERY_S, self._take_voltage)

    def begin(self, now: float) -> None:
        self._requests = RequestQueue()
        super().begin(now)

    def receive(self, data: bytes, now: float) -> None:
        if self._requests.receive(data, now):
            self._received_at = now

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        self._requests.drop_if_timed_out(now)
        if self._requests.times_out_at is not None:
            return self._interrupt_for_stop(now)
        if not self.is_ready:
            return self._ask_for_firmware(now)
        if not self._requests.is_synchronized:
            return self._resynchronize(now)
        return self._next_frame(now)

    def next_due(self, now: float) -> float:
        if (times_out_at := self._requests.times_out_at) is not None:
            return times_out_at
        return min(self.command.next_due, *(poll.due for poll in self._polls))

    def _lose(self, now: float) -> None:
        super()._lose(now)
        self._next_probe = None
        self._unacknowledged, self._refusals = None, 0
        self._requests.drop()
        self._requests.is_summed = None
        self._board_timeout_s = None
        for counter in self.counters.values():
            counter.restart()

    @property
    def _slowest_poll_s(self) -> float:
        return max(poll.request.timeout_s for poll in self._polls)

    def _ask_for_firmware(self, now: float) -> bytes:
        if self._next_probe is None:  # the first request, or the last request got no reply
            self._probe = detect_firmware(self.baud)
            self._next_probe = next(self._probe)
        request, self._next_probe = self._next_probe, None
        return self._requests.ask(request, self._identify, now)

    def _identify(self, reply: Reply, _: float) -> None:
        try:
            self._next_probe = self._probe.send(reply)
        except StopIteration as end:
            self.firmware = end.value
            self._requests.is_summed = self.firmware.is_robotcore_bridge
            self._unacknowledged = WheelCommand()
            self._set_ready()

    def _resynchronize(self, now: float) -> bytes:
        self._board_timeout_s = None  # the board may have been reset
        timeout_s = max(GREETING_S, self._slowest_poll_s)
        request = build_presence_request(self.baud, timeout_s, is_summed=self.firmware.is_robotcore_bridge)
        return self._requests.ask(request, lambda _reply, _now: None, now)

    def _interrupt_for_stop(self, now: float) -> bytes:
        if not (self._is_stop_due(now) and self._requests.is_overdue(now, URGENT_S)):
            return b""
        self._next_command(now)
        self._requests.interrupt()
        return STOP_NOW

    def _next_frame(self, now: float) -> bytes:
        has_to_stop = self._is_stop_due(now) or (self._unacknowledged and self._unacknowledged.is_stop)
        if self.firmware.is_robotcore_bridge and self._board_timeout_s != self.timeout_s and not has_to_stop:
            return self._set_timeout(now)
        if wheels := self._next_command(now):
            return self._requests.ask(self._drive_request(wheels), self._acknowledge, now)
        poll = min(self._polls, key=lambda poll: poll.due)  # so frequent polls do not block rare ones
        if now < poll.due:
            return b""
        poll.due = now + poll.period_s
        return self._requests.ask(poll.request, poll.take_reply, now)

    def _is_stop_due(self, now: float) -> bool:
        return self.command.next_due <= now and self.command.newest.is_stop

    def _next_command(self, now: float) -> WheelCommand | None:
        if self.command.next_due <= now:
            self._unacknowledged = self.command.newest  # before `take`, so that `is_settled` is false all the time
            self._unacknowledged = self.command.take(now, self.timeout_s)
        elif self._unacknowledged and not self._unacknowledged.is_stop:
            return None
        return self._unacknowledged

    def _drive_request(self, wheels: WheelCommand) -> Request:
        if wheels.is_stop:
            return STOP
        if self.is_duty_mode:
            return build_duty_request(round(wheels.left * FULL_DUTY), round(wheels.right * FULL_DUTY))
        return build_speed_request(round(wheels.left), round(wheels.right))

    def _acknowledge(self, reply: Reply, now: float) -> None:
        self._refusals = self._refusals + 1 if reply.is_refusal else 0
        if not self._refusals:
            self._unacknowledged = None
        elif self._refusals >= MAX_REFUSALS and not self.firmware.is_robotcore_bridge:
            self._lose(now)

    def _set_timeout(self, now: float) -> bytes:
        timeout_s = self.timeout_s

        def confirm(reply: Reply, _: float) -> None:
            if not reply.is_refusal:
                self._board_timeout_s = timeout_s

        return self._requests.ask(build_deadman_request(round(timeout_s * 1000)), confirm, now)

    def _count(self, numbers: tuple[int, ...], now: float) -> None:
        for counter, count in zip(self.counters.values(), numbers, strict=True):  # left, right
            counter.take(count, now)

    def _take_voltage(self, numbers: tuple[int, ...], now: float) -> None:
        self.has_battery = numbers[0] >= 0
        if self.has_battery:
            self._set_voltage(numbers[0] / 1000, now)
