"""A serial line: a port, its protocol, and the thread that reads and writes the port and reopens a lost one."""

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
    """Lets a thread wait for data in a file until another thread calls `wake`."""

    def __init__(self) -> None:
        self._receiver, self._sender = socketpair()
        self._receiver.setblocking(False)
        self._sender.setblocking(False)

    def wake(self) -> None:
        """End the present wait. If no thread waits now, the next wait ends at once."""
        with suppress(OSError):  # full: a wake-up is pending; closed: no thread waits
            self._sender.send(b"w")

    def wait(self, file: int | None, seconds: float) -> None:
        """Wait at most ``seconds`` for data in a file or for a call of `wake`.

        file: a file descriptor; None waits only for `wake`.
        """
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
"""If the line's thread did not run for `SUSPENDED_S` seconds, the program was suspended. The board then needs up to
`RECOVERY_S` seconds to answer again."""

OUTDATED_S = 0.5
"""After a suspension of this many seconds, the samples from before it are too old."""

MAX_WAIT_S = 0.005
"""The longest wait for a byte, in seconds. After it the thread checks whether data must be sent."""

POLL_S = 0.005
"""The period of checking a condition, in seconds. It is longer than a simulation step, because simulated time does not
advance in a shorter sleep."""

FIRST_RETRY_S, MAX_RETRY_S = 0.1, 2.0
"""The first and the longest wait before a lost port is opened again, in seconds. The wait doubles with each attempt."""

CLOSING_S = 0.5
"""The longest wait until the last command is sent and acknowledged, when a device or the line is closed, in seconds."""


class Line:
    """A serial port and the protocol of the boards on it.

    If the port fails after `open`, the line closes it, and opens it again after 0.1 s, 0.2 s and so on, up to 2 s.
    `require` raises until the port is open and the board has answered.

    An exception in the protocol is a bug. Then the line closes the port and does not open it again, so that the board
    stops its motors by its time-out. From then on `require` always raises.
    """

    def __init__(self, place: str, protocol: Protocol, clock: Clock) -> None:
        """Create the line; `open` opens the port.

        place: the port in the robot's file, a path or a USB id.
        """
        self._port = Port(place, protocol.baud, protocol.dtr)
        self._protocol, self._clock = protocol, clock
        self._loss: str | None = None
        self._defect: Exception | None = None
        self._free_at = self._retry_at = self._lost_at = self._resumed_at = -math.inf
        self._exchanged_at, self._suspended_s = math.inf, 0.0
        self._back_off = FIRST_RETRY_S
        self._has_received = False
        self._polling: PeriodicTask | None = None
        self._waker: Waker | None = None

    @property
    def place(self) -> str:
        """The port in the robot's file: a path or a USB id."""
        return self._port.place

    def now(self) -> float:
        """Return the time of the line's clock in seconds."""
        return self._clock.now()

    def open(self, device: str, answer_s: float) -> None:
        """Open the port, and wait for the board's first data; raises DeviceError if there is no port or no data.

        device: the name of the device, for errors.
        answer_s: the longest wait in seconds. Opening resets some boards, which need seconds to start.
        """
        try:
            self._port.open()
        except PortError as error:
            raise DeviceError(device, str(error), kind="port-not-opened", place=self.place) from error
        self._waker = Waker()
        self._protocol.begin(self._clock.now())
        period = PERIOD_S if self._clock.is_lockstep else 0.0
        self._polling = self._clock.call_every(period, self._exchange, f"line {self.place}")
        try:
            self.wait_until(lambda: self._protocol.is_ready, device, answer_s, self._explain_silence, "board-silent")
        except BaseException:  # Ctrl-C too: a board may take seconds to answer
            self.close()
            raise

    def wake(self) -> None:
        """Let the line's thread send new data at once, or as soon as earlier data is transmitted."""
        if self._waker:
            self._waker.wake()

    def require(self, device: str) -> None:
        """Raise DeviceLostError if the port is lost or the board does not answer.

        device: the name of the device, for the error.
        """
        self._require_no_defect(device)
        if self._loss or not self._protocol.is_ready:
            kind = "port-lost" if self._loss else "program-suspended" if self._was_suspended else "board-silent"
            problem = self._with_timeout_notice(self._loss or self._explain_silence())
            raise DeviceLostError(device, problem, kind=kind, place=self.place)

    def require_since_lost(self, device: str, sample_time: float) -> None:
        """Raise DeviceLostError like `require`, and also if a sample is older than the last loss of the line.

        A suspension of the program for more than `OUTDATED_S` counts as a loss.

        sample_time: the time of the sample in seconds.
        """
        self.require(device)
        if sample_time < self._lost_at or self._pause_s > OUTDATED_S:
            if self._was_suspended:
                problem = self._with_timeout_notice(self._explain_suspension())
                raise DeviceLostError(device, problem, kind="program-suspended", place=self.place)
            problem = f"the board on {self.place} is back, but has not sent a new sample of this device yet"
            raise DeviceLostError(device, problem, kind="no-sample-yet", place=self.place)

    def _explain_silence(self) -> str:
        if self._was_suspended:
            return self._explain_suspension()
        return self._protocol.explain_silence(self.place, has_received=self._has_received)

    def _explain_suspension(self) -> str:
        suspended_s = max(self._pause_s, self._suspended_s)
        return (
            f"this program was suspended, or had no processor, for {suspended_s:.1f} s, and waits for the "
            f"board on {self.place} again. Find out what stopped the program"
        )

    @property
    def _was_suspended(self) -> bool:
        return self._pause_s > SUSPENDED_S or self._clock.now() < self._resumed_at + RECOVERY_S

    @property
    def _pause_s(self) -> float:
        # After a suspension, another thread may run before the line's thread.
        return self._clock.now() - self._exchanged_at

    def wait_until(
        self,
        condition: Callable[[], bool],
        device: str,
        within_s: float,
        explain: Callable[[], str],
        kind: str = "no-sample-yet",
    ) -> None:
        """Wait until ``condition`` returns true; raise DeviceError after ``within_s`` seconds.

        device: the name of the device, for the error.
        explain: returns the text of the error.
        kind: the kind of the error, as in `RobotcoreError.kind`.
        """
        deadline = self._clock.now() + within_s
        while not condition():
            self._require_no_defect(device)
            if self._clock.now() >= deadline:
                kind = "port-lost" if self._loss else kind
                raise DeviceError(device, self._loss or explain(), kind=kind, place=self.place)
            self._clock.sleep_until(self._clock.now() + POLL_S)

    def settle(self, device: str) -> None:
        """Wait until the last command is sent, and is acknowledged if the board acknowledges commands.

        Raises DeviceError after `CLOSING_S`.
        """

        def is_settled() -> bool:
            self.require(device)
            return self._protocol.is_settled

        text = f"the board on {self.place} has not acknowledged the last command. Check that its motors have stopped"
        self.wait_until(is_settled, device, CLOSING_S, lambda: self._with_timeout_notice(text), "not-acknowledged")

    def close(self) -> None:
        """Send the last data, such as a stop, and close the port. It takes `CLOSING_S` at most.

        May be called again.
        """
        polling, self._polling = self._polling, None
        if polling:
            polling.stop()
            if self._loss is None:
                self._exchange()
                self._wait_until_transmitted()
        self._port.close()
        if self._waker:
            self._waker.close()

    def _exchange(self) -> None:
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
            self._lose(f"{self.place} was closed after an internal error")
            self._retry_at = math.inf

    def _wait(self) -> None:
        if self._waker and not self._clock.is_lockstep:
            now = self._clock.now()
            due = max(self._free_at, self._protocol.next_due(now)) if self._loss is None else self._retry_at
            self._waker.wait(self._port.file, min(max(0.0, due - now), MAX_WAIT_S))

    def _read_and_write(self) -> None:
        was_ready, pause_s, begun_at = self._protocol.is_ready, self._pause_s, self._clock.now()
        if data := self._port.read():
            self._has_received = True
            self._protocol.receive(data, self._clock.now())
        if self._protocol.is_ready:
            self._back_off = FIRST_RETRY_S
        now = self._clock.now()
        if now >= self._free_at and (sent := self._protocol.data_to_send(now)):
            self._free_at = now + len(sent) * BITS_PER_BYTE / self._protocol.baud
            self._port.write(sent)
        if pause_s > SUSPENDED_S:
            self._suspended_s, self._resumed_at = pause_s, now
        if pause_s > OUTDATED_S or (was_ready and not self._protocol.is_ready):
            self._lost_at, self._has_received = now, False
        self._exchanged_at = begun_at

    def _lose(self, loss: str) -> None:
        self._loss = loss
        self._port.close()
        self._lost_at = self._clock.now()
        self._retry_at = self._lost_at + self._back_off
        self._back_off = min(2 * self._back_off, MAX_RETRY_S)

    def _reopen(self) -> None:
        if self._clock.now() >= self._retry_at:
            self._port.open()
            self._free_at, self._exchanged_at, self._has_received = -math.inf, math.inf, False
            self._protocol.begin(self._clock.now())
            self._loss = None

    def _wait_until_transmitted(self) -> None:
        end = self._clock.now() + CLOSING_S
        while not self._clock.is_lockstep and (now := self._clock.now()) < end:
            if now >= self._free_at and not self._port.unsent:
                break
            self._clock.sleep_until(now + POLL_S)

    def _require_no_defect(self, device: str) -> None:
        if self._defect:
            what = f"{type(self._defect).__name__}: {self._defect}"
            problem = self._with_timeout_notice(
                f"internal error in the protocol on {self.place}: {what}. The port is closed. Please report it"
            )
            raise DeviceError(device, problem, kind="protocol-defect", place=self.place) from self._defect

    def _with_timeout_notice(self, problem: str) -> str:
        notice = self._protocol.timeout_notice
        return f"{problem}. {notice}" if notice else problem
