"""A serial port with a thread that reads and writes it, and reopens the port if it is lost."""

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
    """Lets a thread wait for a file until another thread wakes it.

    A wake-up before the wait ends the next wait at once.
    """

    def __init__(self) -> None:
        self._receiver, self._sender = socketpair()
        self._receiver.setblocking(False)
        self._sender.setblocking(False)

    def wake(self) -> None:
        """End the present wait; if no thread waits, end the next wait at once."""
        with suppress(OSError):  # full: a wake-up is pending; closed: no thread waits
            self._sender.send(b"w")

    def wait(self, file: int | None, seconds: float) -> None:
        """Wait until the open file with this number has data, until `wake` is called, or for ``seconds``."""
        files = [self._receiver.fileno()] if file is None else [self._receiver.fileno(), file]
        select(files, [], [], seconds)
        with suppress(BlockingIOError):
            self._receiver.recv(4096)

    def close(self) -> None:
        """Close the socket pair. May be called again."""
        self._receiver.close()
        self._sender.close()


BITS_PER_BYTE = 10
"""The number of bits on the line for one byte (8N1): a start bit, eight data bits, a stop bit."""

PERIOD_S = 0.002
"""The period of reading and writing in simulated time, in seconds. In real time the thread waits for bytes instead."""

SUSPENDED_S, RECOVERY_S = 0.3, 1.0
"""If the pause between two exchanges is longer than the first time, the program was suspended. The board then needs up
to the second time to answer again. Both are in seconds."""

MAX_WAIT_S = 0.005
"""The longest wait for a byte, in seconds. Then the thread checks whether data must be sent."""

POLL_S = 0.005
"""The period of polling a condition, in seconds. It must be longer than a simulation step, or no simulated time would
pass."""

FIRST_RETRY_S, MAX_RETRY_S = 0.1, 2.0
"""The first and the longest wait before a lost port is opened again, in seconds. The wait doubles with each attempt."""

CLOSING_S = 0.5
"""The longest wait for the sending and the acknowledgement of the last command when the line is closed, in seconds."""


class Line:
    """A serial port and the protocol of the boards on it.

    If the port fails after `open`, the line closes it, and opens it again after 0.1 s, 0.2 s and so on, up to 2 s.
    `require` raises until the port is open and the board has answered. An exception in the protocol is a bug. The line
    is then closed for good, so that the board stops by its time-out, and `require` always raises.
    """

    def __init__(self, place: str, protocol: Protocol, clock: Clock) -> None:
        """Create the line; `open` opens the port.

        place: the port in the robot's file, a path or a USB id.
        """
        self._port = Port(place, protocol.baud)
        self._protocol, self._clock = protocol, clock
        self._loss: str | None = None
        self._defect: Exception | None = None
        self._free_at = self._retry_at = self._lost_at = -math.inf
        self._exchanged_at, self._suspended_s = math.inf, 0.0
        self._back_off = FIRST_RETRY_S
        self._has_heard = False
        self._polling: PeriodicTask | None = None
        self._waker: Waker | None = None

    def __repr__(self) -> str:
        state = f"lost: {self._loss}" if self._loss else "ready" if self._protocol.is_ready else "not ready"
        return f"Line({self.place!r}, {state})"

    @property
    def place(self) -> str:
        """The port, as it is written in the robot's file."""
        return self._port.place

    def now(self) -> float:
        """Return the time of the line's clock in seconds."""
        return self._clock.now()

    def open(self, device: str, answer_s: float) -> None:
        """Open the port, and wait for the first answer of the board.

        device: the name of the device in the DeviceError if there is no port or no answer.
        answer_s: the longest wait in seconds. A board that opening resets needs some seconds to start.
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
            self._wait_until(lambda: self._protocol.is_ready, device, answer_s, self._explain_silence, "board-silent")
        except BaseException:  # Ctrl-C too: a board may take seconds to answer
            self.close()
            raise

    def wake(self) -> None:
        """Make the thread of the line send new data at once, if the line is free."""
        if self._waker:
            self._waker.wake()

    def require(self, device: str) -> None:
        """Raise DeviceLostError with the device's name if the port is lost or the board does not answer."""
        self._require_no_defect(device)
        if loss := self._loss:
            raise DeviceLostError(device, self._with_timeout_notice(loss), kind="port-lost", place=self.place)
        if not self._protocol.is_ready:
            kind = "program-suspended" if self._was_suspended else "board-silent"
            raise DeviceLostError(
                device, self._with_timeout_notice(self._explain_silence(self.place)), kind=kind, place=self.place
            )

    def require_since_lost(self, device: str, heard_at: float) -> None:
        """Raise DeviceLostError as `require` does, and also if a sample is older than the last loss of the line.

        heard_at: the time of the sample in seconds.
        """
        self.require(device)
        if heard_at < self._lost_at:
            raise DeviceLostError(
                device,
                f"the board on {self.place} is back, but has not sent a new sample of this device yet",
                kind="no-sample-yet",
                place=self.place,
            )

    def _explain_silence(self, place: str) -> str:
        if self._was_suspended:
            return (
                f"this program was suspended, or had no processor, for {self._suspended_s:.1f} s; it has to wait for "
                f"the board on {place} again. Find out what stopped the program"
            )
        return self._protocol.explain_silence(place, has_heard=self._has_heard)

    @property
    def _was_suspended(self) -> bool:
        return self._suspended_s > SUSPENDED_S and self._clock.now() < self._lost_at + RECOVERY_S

    def wait_until(
        self, condition: Callable[[], bool], device: str, within_s: float, fault: str, kind: str = "no-sample-yet"
    ) -> None:
        """Wait until ``condition`` returns true; raise DeviceError if it does not in time.

        device: the name of the device, for the error.
        within_s: the longest wait in seconds.
        fault, kind: the text and the kind of the error.
        """
        self._wait_until(condition, device, within_s, lambda _place: fault, kind)

    def _wait_until(
        self, condition: Callable[[], bool], device: str, within_s: float, fault: Callable[[str], str], kind: str
    ) -> None:
        deadline = self._clock.now() + within_s
        while not condition():
            self._require_no_defect(device)
            if self._clock.now() >= deadline:
                if self._loss:
                    raise DeviceError(device, self._loss, kind="port-lost", place=self.place)
                raise DeviceError(device, fault(self.place), kind=kind, place=self.place)
            self._clock.sleep_until(self._clock.now() + POLL_S)

    def settle(self, device: str) -> None:
        """Wait until the last command is sent and, if possible, acknowledged; raise DeviceError after half a second."""

        def is_settled() -> bool:
            self.require(device)
            return self._protocol.is_settled

        text = f"the board on {self.place} has not acknowledged the last command. Check that its motors have stopped"
        self.wait_until(is_settled, device, CLOSING_S, self._with_timeout_notice(text), "not-acknowledged")

    def close(self) -> None:
        """Send the data that is due, such as the last stop, and close the port. This takes half a second at most.

        May be called again.
        """
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
        """Wait, read, and send the data that is due. Only one thread calls this method."""
        try:
            self._wait()
            if self._loss is None:
                self._read_and_write()
            else:
                self._reopen()
        except PortError as error:
            self._lose(str(error))
        except Exception as defect:  # noqa: BLE001  a bug in the protocol: the next command or read raises it
            self._defect = defect
            self._lose(f"{self.place} was closed after a defect")
            self._retry_at = math.inf

    def _wait(self) -> None:
        """Wait for a byte, for `wake`, or until data is due. In simulated time, return at once."""
        if self._waker and not self._clock.is_lockstep:
            now = self._clock.now()
            due = max(self._free_at, self._protocol.next_due(now)) if self._loss is None else self._retry_at
            self._waker.wait(self._port.file, min(max(0.0, due - now), MAX_WAIT_S))

    def _read_and_write(self) -> None:
        was_ready, exchanged_at, self._exchanged_at = self._protocol.is_ready, self._exchanged_at, self._clock.now()
        if data := self._port.read():
            self._has_heard = True
            self._protocol.receive(data, self._clock.now())
        if self._protocol.is_ready:
            self._back_off = FIRST_RETRY_S
        now = self._clock.now()
        if now >= self._free_at and (sent := self._protocol.data_to_send(now)):
            self._free_at = now + len(sent) * BITS_PER_BYTE / self._protocol.baud
            self._port.write(sent)
        if was_ready and not self._protocol.is_ready:
            self._lost_at, self._suspended_s, self._has_heard = now, self._exchanged_at - exchanged_at, False

    def _lose(self, loss: str) -> None:
        self._loss = loss
        self._port.close()
        self._lost_at = self._clock.now()
        self._retry_at = self._lost_at + self._back_off
        self._back_off = min(2 * self._back_off, MAX_RETRY_S)

    def _reopen(self) -> None:
        if self._clock.now() >= self._retry_at:
            self._port.open()
            self._free_at, self._has_heard = -math.inf, False
            self._protocol.begin(self._clock.now())
            self._loss = None

    def _drain(self) -> None:
        """Wait until all bytes have left the computer and were transmitted. In simulated time, return at once."""
        end = self._clock.now() + CLOSING_S
        while not self._clock.is_lockstep and self._clock.now() < min(end, self._drained_at()):
            self._clock.sleep_until(self._clock.now() + POLL_S)

    def _drained_at(self) -> float:
        return math.inf if self._port.unsent else self._free_at

    def _require_no_defect(self, device: str) -> None:
        if self._defect:
            what = f"{type(self._defect).__name__}: {self._defect}"
            fault = f"internal error in the protocol on {self.place}: {what}. The port is closed. Please report it"
            raise DeviceError(
                device, self._with_timeout_notice(fault), kind="protocol-defect", place=self.place
            ) from self._defect

    def _with_timeout_notice(self, fault: str) -> str:
        return f"{fault}. {self._protocol.timeout_notice}" if self._protocol.timeout_notice else fault
