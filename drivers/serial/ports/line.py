"""An open serial port: one thread reads it, answers, and opens it again when it was lost."""

from __future__ import annotations

import math
from collections.abc import Callable

from drivers.serial.ports.port import Port, PortError
from drivers.serial.ports.talk import Talk
from robotcore.clock import Clock
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.polling import Polling

BITS_A_BYTE = 10
"""8N1: a start bit, eight, a stop bit."""

PERIOD_S = 0.002
"""So often simulated time pumps a line; a thread begins again at once, for it waits in the port."""

WAITING_S = 0.005
"""A thread waits no longer for a byte before it looks whether something is due."""

FIRST_S, LONGEST_S = 0.1, 2.0
"""How long it is before a lost port is opened again: twice as long each time."""

CLOSING_S = 0.5
"""How long closing waits until the last command has been sent."""


class Line:
    """A port and the conversation on it.

    From `open` on, a port that fails is closed and opened again, after 0.1 s, 0.2 s, up to every 2 s. Meanwhile, and
    until the board has answered, `require` raises.
    """

    def __init__(self, place: str, talk: Talk, clock: Clock) -> None:
        self._port = Port(place, talk.baud, 0.0 if clock.is_lockstep else WAITING_S)
        self._talk, self._clock = talk, clock
        self._failure: str | None = None
        self._free_at = self._retry_at = -math.inf
        self._back_off = FIRST_S
        self._polling: Polling | None = None

    @property
    def place(self) -> str:
        """What the robot's file calls the port."""
        return self._port.place

    def open(self, device: str, answer_s: float) -> None:
        """Open the port, and wait up to ``answer_s`` seconds for an answer; raises DeviceError by the device's name."""
        try:
            self._port.open()
        except PortError as error:
            raise DeviceError(device, str(error)) from error
        self._talk.begin(self._clock.now())
        self._polling = self._clock.every(PERIOD_S, self._exchange, f"line {self.place}")
        unanswered = f"nothing on {self.place} answers at {self._talk.baud} baud"
        try:
            self.wait_until(lambda: self._talk.is_ready, device, answer_s, unanswered)
        except DeviceError:
            self.close()
            raise

    def now(self) -> float:
        """Return the time of the clock that the line's conversation goes by."""
        return self._clock.now()

    def wait_until(self, is_so: Callable[[], bool], device: str, within_s: float, fault: str) -> None:
        """Let time pass until something is so; raises DeviceError with the fault where it takes longer."""
        deadline = self._clock.now() + within_s
        while not is_so():
            if self._clock.now() >= deadline:
                raise DeviceError(device, fault)
            self._clock.sleep_until(self._clock.now() + PERIOD_S)

    def settle(self, device: str) -> None:
        """Wait until the last command was heard, half a second at most; raises DeviceError by the device's name."""

        def is_heard() -> bool:
            self.require(device)
            return self._talk.is_settled

        unheard = f"nobody on {self.place} has acknowledged the last command. {self._talk.stops_itself}".strip()
        self.wait_until(is_heard, device, CLOSING_S, unheard)

    def wake(self) -> None:
        """Have what is new sent now, where the line is free."""
        self._port.wake()

    def require(self, device: str) -> None:
        """Raise DeviceLostError, by the device's name, where the port is lost or its board has not answered yet."""
        if self._failure:
            raise DeviceLostError(device, self._failure)
        if not self._talk.is_ready:
            raise DeviceLostError(device, f"the board on {self.place} has not answered since it came back")

    def close(self) -> None:
        """Send what is due, such as the last stop, within half a second, and let the port go. May be called again."""
        polling, self._polling = self._polling, None
        if polling:
            polling.stop()
            self._exchange()
        self._port.close()

    def _exchange(self) -> None:
        """Read what came, and send what is due; called by one thread only."""
        try:
            if self._failure:
                self._open_again()
                return
            now = self._clock.now()
            if data := self._port.read():
                self._talk.receive(data, self._clock.now())
            if now >= self._free_at and (sent := self._talk.due(now)):
                self._free_at = now + len(sent) * BITS_A_BYTE / self._talk.baud
                self._port.write(sent)
        except PortError as error:
            self._lose(error)

    def _lose(self, error: PortError) -> None:
        self._failure = str(error)
        self._port.close()
        self._retry_at = self._clock.now() + self._back_off
        self._back_off = min(2 * self._back_off, LONGEST_S)

    def _open_again(self) -> None:
        if self._clock.now() < self._retry_at:
            return
        self._port.open()
        self._back_off = FIRST_S
        self._failure = None
        self._talk.begin(self._clock.now())
