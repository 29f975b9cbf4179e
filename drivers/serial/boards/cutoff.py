"""How a process that is not the app's makes a board's motors stand: a stop frame, on a port of its own.

The app's lock on a port keeps out who asks for the lock, and this does not: both write, and the kernel keeps each
frame whole. Nothing heavy is imported here: no wheel turns before the guardian is ready.
"""

from __future__ import annotations

from contextlib import suppress
from select import poll, select
from threading import RLock, Thread
from typing import TYPE_CHECKING

from drivers.serial.ports.finding import PortMissingError, holders, path_of
from robotcore.errors import BackendError
from robotcore.guardian import Cutoff, CutoffSpec

if TYPE_CHECKING:
    from serial import Serial

    from robotcore.hardware import Host

WRITING_S = 0.2
"""A port that has not taken the frame by then takes none."""

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

    Where ``has_owner`` is false nobody of the robot's own is running: a program that has the port all the same may turn
    the motors again, and is told of by BackendError, after the stop.
    """

    def __init__(self, place: str, baud: int, frame: str, *, has_owner: bool) -> None:
        self._place, self._baud, self._frame, self._has_owner = place, baud, bytes.fromhex(frame), has_owner
        self._serial: Serial | None = None
        self._lock = RLock()

    def open(self) -> None:
        from serial import Serial

        try:
            path = path_of(self._place)
        except PortMissingError as error:
            raise BackendError(f"{error}; the board's own time-out has to stop it") from error
        self._serial = Serial(path, self._baud, timeout=0, write_timeout=WRITING_S)
        hung_up = poll()
        hung_up.register(self._serial.fileno(), 0)
        Thread(target=self._let_go, args=(self._serial, hung_up), name=f"unplugged {path}", daemon=True).start()

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
                    return f"{self._place} is gone: the board stops its motors by itself"
                self._write()
        if not self._has_owner and (who := holders(path_of(self._place))):
            raise BackendError(f"{self._place} is held by {who}, which may turn it again. End that program first")
        return None

    def close(self) -> None:
        with self._lock:
            serial, self._serial = self._serial, None
            if serial:
                serial.close()

    def _let_go(self, serial: Serial, hung_up: poll) -> None:
        """Close a port when it hangs up."""
        while self._serial is serial:
            if hung_up.poll(LOOKING_S * 1000):
                with self._lock:
                    if self._serial is serial:
                        self.close()

    def _is_there(self) -> bool:
        try:
            path_of(self._place)
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


def stop_frame(device: str, place: str, baud: int, frame: bytes, host: Host) -> CutoffSpec:
    """Return how the guardian, or `robotcore stop`, stops a board; equal frames on one port are sent as one."""
    parameters = {"place": place, "baud": baud, "frame": frame.hex(), "has_owner": host.owner is not None}
    return CutoffSpec(device, "drivers.serial.boards.cutoff:StopFrame", parameters)
