"""An open serial port: one thread reads it, answers, and reopens it if the port is lost."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from select import select
from socket import socketpair

from drivers.serial.port import Port, PortError
from drivers.serial.protocol import Protocol
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import Clock, PeriodicTask


class Waker:
    """Lets a thread wait that another one can wake; a word that comes before the wait is not lost."""

    def __init__(self) -> None:
        self._woken, self._waking = socketpair()
        self._woken.setblocking(False)
        self._waking.setblocking(False)

    def wake(self) -> None:
        """Let whoever waits, or is about to, go on."""
        with suppress(OSError):  # full: it has been woken; closed: nobody waits
            self._waking.send(b"w")

    def wait(self, file: int | None, seconds: float) -> None:
        """Wait until a file has something to read, for a word, or for so long."""
        files = [self._woken.fileno()] if file is None else [self._woken.fileno(), file]
        select(files, [], [], seconds)
        with suppress(BlockingIOError):
            self._woken.recv(4096)

    def close(self) -> None:
        """Wait no more. May be called again."""
        self._woken.close()
        self._waking.close()


BITS_A_BYTE = 10
"""8N1: a start bit, eight, a stop bit."""

PERIOD_S = 0.002
"""So often simulated time pumps a line; a thread waits for bytes instead, and begins again at once."""

SUSPENDED_S, HEARING_S = 0.3, 1.0
"""A thread that has not come round for so long was suspended; the board that it lost by that answers within the other.
"""

WAITING_S = 0.005
"""A thread waits no longer for a byte before it looks whether something is due."""

LOOKING_S = 0.005
"""Who waits for something looks so often; longer than a step of simulated time, or no time would pass."""

FIRST_S, LONGEST_S = 0.1, 2.0
"""How long it is before a lost port is opened again: twice as long each time."""

CLOSING_S = 0.5
"""How long closing waits until the last command has been sent and heard."""


class Line:
    """A port and the protocol on it.

    From `open` on, a port that fails is closed and opened again, after 0.1 s, 0.2 s, up to every 2 s. Meanwhile, and
    until the board has answered, `require` raises. What a talk raises is a bug: the line is closed for good, so that
    the board stops by itself, and `require` tells.
    """

    def __init__(self, place: str, protocol: Protocol, clock: Clock) -> None:
        self._port = Port(place, protocol.baud)
        self._protocol, self._clock = protocol, clock
        self._loss: str | None = None
        self._defect: Exception | None = None
        self._free_at = self._retry_at = self._lost_at = -math.inf
        self._looked_at, self._suspended_s = math.inf, 0.0
        self._back_off = FIRST_S
        self._has_heard = False
        self._polling: PeriodicTask | None = None
        self._waker: Waker | None = None

    @property
    def place(self) -> str:
        """What the robot's file calls the port."""
        return self._port.place

    def now(self) -> float:
        """Return the time of the clock that the line's conversation goes by."""
        return self._clock.now()

    def open(self, device: str, answer_s: float) -> None:
        """Open the port, and wait up to ``answer_s`` seconds for an answer; raises DeviceError by the device's name.

        A board that is reset by it answers when it has started, and is not waited for any longer.
        """
        try:
            self._port.open()
        except PortError as error:
            raise DeviceError(device, str(error), kind="port-not-opened", place=self.place) from error
        self._waker = Waker()
        self._protocol.begin(self._clock.now())
        period = PERIOD_S if self._clock.is_lockstep else 0.0
        self._polling = self._clock.every(period, self._exchange, f"line {self.place}")
        try:
            self._wait_until(lambda: self._protocol.is_ready, device, answer_s, self._unanswered, "board-silent")
        except BaseException:  # Ctrl-C too: a board may take seconds to answer
            self.close()
            raise

    def wake(self) -> None:
        """Have what is new sent now, where the line is free."""
        if self._waker:
            self._waker.wake()

    def require(self, device: str) -> None:
        """Raise DeviceLostError, by the device's name, where the port is lost or its board does not answer."""
        self._require_sound(device)
        if loss := self._loss:
            raise DeviceLostError(device, self._with_its_stop(loss), kind="port-lost", place=self.place)
        if not self._protocol.is_ready:
            kind = "program-suspended" if self._was_suspended else "board-silent"
            raise DeviceLostError(
                device, self._with_its_stop(self._unanswered(self.place)), kind=kind, place=self.place
            )

    def require_since_lost(self, device: str, heard_at: float) -> None:
        """Raise DeviceLostError where what was heard then is from before the line was lost; all else as `require`."""
        self.require(device)
        if heard_at < self._lost_at:
            raise DeviceLostError(
                device,
                f"the board on {self.place} is back, and has not told anything of it yet",
                kind="no-sample-yet",
                place=self.place,
            )

    def _unanswered(self, place: str) -> str:
        if self._was_suspended:
            return (
                f"this program was suspended, or had no processor, for {self._suspended_s:.1f} s; it has to wait for "
                f"the board on {place} again. Find out what stopped the program"
            )
        return self._protocol.unanswered(place, has_heard=self._has_heard)

    @property
    def _was_suspended(self) -> bool:
        return self._suspended_s > SUSPENDED_S and self._clock.now() < self._lost_at + HEARING_S

    def wait_until(
        self, is_so: Callable[[], bool], device: str, within_s: float, fault: str, kind: str = "no-sample-yet"
    ) -> None:
        """Let time pass until something is so; raises DeviceError with the fault and the kind if it takes longer."""
        self._wait_until(is_so, device, within_s, lambda _place: fault, kind)

    def _wait_until(
        self, is_so: Callable[[], bool], device: str, within_s: float, fault: Callable[[str], str], kind: str
    ) -> None:
        deadline = self._clock.now() + within_s
        while not is_so():
            self._require_sound(device)
            if self._clock.now() >= deadline:
                if self._loss:
                    raise DeviceError(device, self._loss, kind="port-lost", place=self.place)
                raise DeviceError(device, fault(self.place), kind=kind, place=self.place)
            self._clock.sleep_until(self._clock.now() + LOOKING_S)

    def settle(self, device: str) -> None:
        """Wait until the last command was heard, half a second at most; raises DeviceError by the device's name."""

        def is_heard() -> bool:
            self.require(device)
            return self._protocol.is_settled

        unheard = f"the board on {self.place} has not acknowledged the last command. Look whether its motors stand"
        self.wait_until(is_heard, device, CLOSING_S, self._with_its_stop(unheard), "not-acknowledged")

    def close(self) -> None:
        """Send what is due, such as the last stop, within half a second, and let the port go. May be called again."""
        polling, self._polling = self._polling, None
        if polling:
            polling.stop()
            if self._loss is None:
                self._exchange()
                self._drain()
        self._port.close()
        if self._waker:
            self._waker.close()

    def _exchange(self) -> None:
        """Wait for something, read what came, and send what is due; called by one thread only."""
        try:
            self._wait()
            if self._loss is None:
                self._converse()
            else:
                self._open_again()
        except PortError as error:
            self._lose(str(error))
        except Exception as defect:  # noqa: BLE001  a talk owes not to raise: told to whoever commands or reads next
            self._defect = defect
            self._lose(f"{self.place} was given up")
            self._retry_at = math.inf

    def _wait(self) -> None:
        """Wait for a byte, for a word, until something is due, or for a moment; not at all in simulated time."""
        if self._waker and not self._clock.is_lockstep:
            now = self._clock.now()
            due = max(self._free_at, self._protocol.next_due(now)) if self._loss is None else self._retry_at
            self._waker.wait(self._port.file, min(max(0.0, due - now), WAITING_S))

    def _converse(self) -> None:
        was_ready, looked_at, self._looked_at = self._protocol.is_ready, self._looked_at, self._clock.now()
        if data := self._port.read():
            self._has_heard = True
            self._protocol.receive(data, self._clock.now())
        if self._protocol.is_ready:
            self._back_off = FIRST_S
        now = self._clock.now()
        if now >= self._free_at and (sent := self._protocol.due(now)):
            self._free_at = now + len(sent) * BITS_A_BYTE / self._protocol.baud
            self._port.write(sent)
        if was_ready and not self._protocol.is_ready:
            self._lost_at, self._suspended_s, self._has_heard = now, self._looked_at - looked_at, False

    def _lose(self, loss: str) -> None:
        self._loss = loss
        self._port.close()
        self._lost_at = self._clock.now()
        self._retry_at = self._lost_at + self._back_off
        self._back_off = min(2 * self._back_off, LONGEST_S)

    def _open_again(self) -> None:
        if self._clock.now() >= self._retry_at:
            self._port.open()
            self._free_at, self._has_heard = -math.inf, False
            self._protocol.begin(self._clock.now())
            self._loss = None

    def _drain(self) -> None:
        """Wait until all bytes have left the computer, and the wire; simulated time has neither."""
        end = self._clock.now() + CLOSING_S
        while not self._clock.is_lockstep and self._clock.now() < min(end, self._left_at()):
            self._clock.sleep_until(self._clock.now() + LOOKING_S)

    def _left_at(self) -> float:
        return math.inf if self._port.unsent else self._free_at

    def _require_sound(self, device: str) -> None:
        if self._defect:
            what = f"{type(self._defect).__name__}: {self._defect}"
            fault = f"internal error in the protocol on {self.place}: {what}. The port was closed. Please report it"
            raise DeviceError(
                device, self._with_its_stop(fault), kind="protocol-defect", place=self.place
            ) from self._defect

    def _with_its_stop(self, fault: str) -> str:
        return f"{fault}. {self._protocol.stops_itself}" if self._protocol.stops_itself else fault
