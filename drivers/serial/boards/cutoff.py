"""How a process that is not the app's makes a board's motors stand: a stop frame, on a port of its own.

The app's lock on a port keeps out who asks for the lock, and this does not: both write, and the kernel keeps each
frame whole. Nothing heavy is imported here: no wheel turns before the guardian is ready.
"""

from __future__ import annotations

import re
from contextlib import suppress
from functools import partial
from select import poll, select
from threading import RLock
from typing import TYPE_CHECKING

from drivers.serial.port import FAILURES, PortMissingError, explain_failure, find_path
from robotcore.errors import BackendError, ResourceError
from robotcore.hal.cutoff import Cutoff, CutoffSpec, Unconfirmed
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_holders
from robotcore.threads import start_thread

if TYPE_CHECKING:
    from serial import Serial

    from robotcore.hardware import Host

WRITING_S = 0.2
"""A port that has not taken the frame by then takes none."""

ANSWERING_S, REPEATING_S = 4.0, 0.25
"""So long an answer is waited for, and so often the frame is sent: to open its port resets an Arduino, whose boot
loader takes up to two seconds."""

CHUNK = 4096

LOOKING_S = 0.1
"""So often it is looked whether the port is still wanted."""

APART_S = 0.01
"""How far apart the frame goes twice; a hoverboard takes a pause of a millisecond for the end of a frame."""


class StopFrame(Cutoff):
    """Writes a board's stop frame, given in hexadecimal digits, twice.

    The first one may run into what the app was sending when it died, which some boards take for nothing, or be lost in
    noise; nobody is there to see it.

    The port is open from the beginning, so that the line that resets an Arduino does not fall where the app dies. When
    it is unplugged it is let go at once: while anybody has it open, a board that comes back gets another name. It is
    opened anew for the next command; where it is not there any more, nobody can tell the board anything, and its own
    time-out stops it.

    Where ``has_owner`` is false nobody of the robot's own is running, and BackendError is raised after the stop: for a
    program that has the port all the same, and may turn the motors again; and where the board does not say what it
    says to a stop, the regular expression ``answer``, None for one that never does.
    """

    def __init__(self, place: str, baud: int, frame: str, answer: str | None, *, has_owner: bool) -> None:
        self._place, self._baud, self._frame, self._has_owner = place, baud, bytes.fromhex(frame), has_owner
        self._answer = None if answer is None else re.compile(answer.encode("latin-1"))
        self._serial: Serial | None = None
        self._lock = RLock()

    def open(self) -> None:
        from serial import Serial

        try:
            path = find_path(self._place)
        except PortMissingError as error:
            raise BackendError(
                f"{error}; the board's own time-out has to stop it", kind="port-missing", place=self._place
            ) from error
        try:
            self._serial = Serial(path, self._baud, timeout=0, write_timeout=WRITING_S)
        except FAILURES as error:
            raise BackendError(
                explain_failure(self._place, path, self._baud, error), kind="port-not-opened", place=self._place
            ) from error
        hung_up = poll()
        hung_up.register(self._serial.fileno(), 0)
        with suppress(ResourceError):  # without the thread the port is stopped all the same
            start_thread(partial(self._let_go, self._serial, hung_up), f"unplugged {path}")

    def arm(self) -> None:
        with self._lock, suppress(Exception):  # what keeps failing is raised where it is to stop
            if self._serial is None:
                self.open()

    def stop(self) -> str | None:
        with self._lock:
            try:
                self._write()
            except Exception:  # noqa: BLE001  pyserial's kinds have no base in common; what fails again is raised
                self.close()
                if not self._is_there():
                    return Unconfirmed(f"{self._place} is gone: the board stops its motors by itself")
                self._write()
            return None if self._has_owner else self._confirmed()

    def close(self) -> None:
        with self._lock:
            serial, self._serial = self._serial, None
            if serial:
                serial.close()

    def _confirmed(self) -> str | None:
        """Return None where the board has answered, raise BackendError where it should have and did not."""
        if who := describe_holders(find_path(self._place)):
            raise BackendError(
                f"the stop was sent, but {self._place} is held by {who}, which may turn it again. End that program "
                "(a run takes its guardian with it), and stop anew",
                kind="port-in-use",
                place=self._place,
                holders=who,
            )
        if self._answer is None:
            text = f"the stop was sent to {self._place}; this board cannot confirm it. Look whether they stand"
            return Unconfirmed(text)
        if not self._is_answered(self._answer):
            raise BackendError(
                f"no answer on {self._place}: whether the stop was heard is not known",
                kind="stop-not-confirmed",
                place=self._place,
            )
        return None

    def _is_answered(self, answer: re.Pattern[bytes]) -> bool:
        assert self._serial
        clock, said, sent = MonotonicClock(), b"", 1
        while clock.now() < ANSWERING_S:
            if select([self._serial], [], [], REPEATING_S)[0]:
                said += self._serial.read(CHUNK)
            if answer.search(said):
                return True
            if clock.now() >= sent * REPEATING_S:
                sent += 1
                self._write()
        return False

    def _let_go(self, serial: Serial, hung_up: poll) -> None:
        """Close a port when it hangs up."""
        while self._serial is serial:
            if hung_up.poll(LOOKING_S * 1000):
                with self._lock:
                    if self._serial is serial:
                        self.close()

    def _is_there(self) -> bool:
        try:
            find_path(self._place)
        except PortMissingError:
            return False
        return True

    def _write(self) -> None:
        if self._serial is None:
            self.open()
        assert self._serial
        for pause_s in (APART_S, 0.0):
            self._serial.write(self._frame)
            self._serial.flush()
            select([], [], [], pause_s)


def stop_frame(device: str, place: str, baud: int, frame: bytes, answer: str | None, host: Host) -> CutoffSpec:
    """Return how the guardian, or `robotcore stop`, stops a board; equal frames on one port are sent as one."""
    has_owner = host.owner is not None
    parameters = {"place": place, "baud": baud, "frame": frame.hex(), "answer": answer, "has_owner": has_owner}
    return CutoffSpec(device, "drivers.serial.boards.cutoff:StopFrame", parameters)
