"""Stop the motors of a board from the guardian's process, by a stop frame on the board's port.

The guardian opens the port without a lock, so the app's lock does not exclude the guardian. Both processes may write to
the port, and the kernel does not mix the bytes of their frames. The module imports few others, so that the guardian
starts fast.
"""

from __future__ import annotations

import re
import select
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import RLock
from typing import TYPE_CHECKING

from drivers.serial.port import CHUNK, FAILURES, PortMissingError, explain_failure, find_path
from robotcore.errors import BackendError, ResourceError
from robotcore.hal.cutoff import Cutoff, UnconfirmedStop
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_holders
from robotcore.system import HAS_POSIX
from robotcore.threads import start_thread

if TYPE_CHECKING:
    from serial import Serial

WRITE_TIMEOUT_S = 0.2
"""The longest time for writing the stop frame, in seconds."""

ANSWER_TIMEOUT_S, REPEAT_S = 4.0, 0.25
"""The longest wait for the board's answer, and the period of repeating the frame during this wait, in seconds.

Opening the port resets an Arduino, and its boot loader takes up to two seconds."""

HANG_UP_POLL_S = 0.1
"""The period in which the hang-up thread checks whether the port was closed, in seconds."""

REPEAT_PAUSE_S = 0.01
"""The pause between the two stop frames, in seconds. A hoverboard detects the end of a frame by a pause of 1 ms."""


class StopFrame(Cutoff):
    """Stops a board's motors by writing its stop frame twice.

    The first frame may be lost: noise may destroy it, or it may follow half a frame of a killed app.

    The port is opened at the start of a run, because opening it later would reset an Arduino. If the board is
    unplugged, the port is closed at once. Otherwise Linux would give the board another port name after replugging. The
    next `arm` or `stop` opens the port again. If the port does not exist then, the board's own time-out stops the
    motors.

    Windows lets one program open a port. There `stop` opens it, which works after the app's process has ended.
    """

    def __init__(self, place: str, baud: int, frame: str, answer: str | None, *, has_owner: bool) -> None:
        """Create the cutoff; `open` opens the port.

        frame: the stop frame in hexadecimal digits.
        answer: a regular expression for the board's answer to a stop; None if the board never answers.
        has_owner: whether an app has the robot open. Without an app, `stop` raises BackendError if the board does not
            answer, or if another program has the port open and may turn the motors again.
        """
        self._place, self._baud, self._frame, self._has_owner = place, baud, bytes.fromhex(frame), has_owner
        self._answer = None if answer is None else re.compile(answer.encode("latin-1"))
        self._serial: Serial | None = None
        self._lock = RLock()

    def open(self) -> None:
        path = self._find_path()
        if HAS_POSIX:
            self._open_port(path)

    def _find_path(self) -> str:
        try:
            return find_path(self._place)
        except PortMissingError as error:
            raise BackendError(
                f"{error}; only the board's own time-out stops the motors", kind="port-missing", place=self._place
            ) from error

    def _open_port(self, path: str) -> None:
        from serial import Serial

        try:
            self._serial = Serial(path, self._baud, timeout=0, write_timeout=WRITE_TIMEOUT_S)
        except FAILURES as error:
            raise BackendError(
                explain_failure(self._place, path, self._baud, error), kind="port-not-opened", place=self._place
            ) from error
        if not HAS_POSIX:
            return
        hung_up = select.poll()
        hung_up.register(self._serial.fileno(), 0)
        with suppress(ResourceError):  # `stop` works without the thread too
            start_thread(partial(self._close_on_hang_up, self._serial, hung_up.poll), f"unplugged {path}")

    def arm(self) -> None:
        with self._lock, suppress(Exception):  # `stop` raises a failure that lasts
            if self._serial is None:
                self.open()

    def stop(self) -> str | None:
        with self._lock:
            try:
                self._write()
            except Exception:  # noqa: BLE001  pyserial's errors have no common base; a second failure is raised
                self.close()
                try:
                    find_path(self._place)
                except PortMissingError:
                    return UnconfirmedStop(f"{self._place} is unplugged: the board stops its motors by itself")
                self._write()
            return None if self._has_owner else self._confirm()

    def close(self) -> None:
        with self._lock:
            serial, self._serial = self._serial, None
            if serial:
                serial.close()

    def _confirm(self) -> str | None:
        if holders := describe_holders(find_path(self._place)):
            raise BackendError(
                f"the stop was sent, but {self._place} is held by {holders}, which may start the motors again. End "
                "that program (a run ends its guardian too), and run robotcore stop again",
                kind="port-in-use",
                place=self._place,
                holders=holders,
            )
        if self._answer is None:
            text = f"the stop was sent to {self._place}; this board cannot confirm it. Check that the motors stand"
            return UnconfirmedStop(text)
        if not self._is_answered(self._answer):
            raise BackendError(
                f"no answer on {self._place}: the board may not have received the stop. Check that the motors stand",
                kind="stop-not-confirmed",
                place=self._place,
            )
        return None

    def _is_answered(self, answer: re.Pattern[bytes]) -> bool:
        assert self._serial
        clock, received, sent = MonotonicClock(), b"", 1
        while clock.now() < ANSWER_TIMEOUT_S:
            received += self._read_within(REPEAT_S)
            if answer.search(received):
                return True
            if clock.now() >= sent * REPEAT_S:
                sent += 1
                self._write()
        return False

    def _read_within(self, limit_s: float) -> bytes:
        assert self._serial
        if HAS_POSIX:
            return self._serial.read(CHUNK) if select.select([self._serial], [], [], limit_s)[0] else b""
        self._serial.timeout = limit_s
        return bytes(self._serial.read(1)) + bytes(self._serial.read(self._serial.in_waiting))

    def _close_on_hang_up(self, serial: Serial, wait_for_hang_up: Callable[[float], object]) -> None:
        while self._serial is serial:
            if wait_for_hang_up(HANG_UP_POLL_S * 1000):
                with self._lock:
                    if self._serial is serial:
                        self.close()

    def _write(self) -> None:
        if self._serial is None:
            self._open_port(self._find_path())
        assert self._serial
        clock = MonotonicClock()
        for pause_s in (REPEAT_PAUSE_S, 0.0):
            self._serial.write(self._frame)
            self._serial.flush()
            clock.sleep_until(clock.now() + pause_s)
