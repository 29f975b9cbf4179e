"""How a process that is not the app's makes a board's motors stand: a stop frame, on a port of its own.

The app's lock on a port keeps out who asks for the lock, and this does not: both write, and the kernel keeps each
frame whole. Nothing heavy is imported here: no wheel turns before the guardian is ready.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.serial.ports.finding import PortMissingError, holders, path_of
from robotcore.errors import BackendError
from robotcore.guardian import Cutoff, CutoffSpec

if TYPE_CHECKING:
    from serial import Serial

    from robotcore.hardware import Host

WRITING_S = 0.2
"""A port that has not taken the frame by then takes none."""


class StopFrame(Cutoff):
    """Writes a board's stop frame, given in hexadecimal digits.

    The port is open from the beginning, so that the line that resets an Arduino does not fall where the app dies. One
    that was unplugged since is opened anew; where it is not there any more, nobody can tell the board anything, and its
    own time-out stops it.

    Where ``has_owner`` is false nobody of the robot's own is running: a program that has the port all the same may turn
    the motors again, and is told of by BackendError, after the stop.
    """

    def __init__(self, place: str, baud: int, frame: str, *, has_owner: bool) -> None:
        self._place, self._baud, self._frame, self._has_owner = place, baud, bytes.fromhex(frame), has_owner
        self._serial: Serial | None = None

    def open(self) -> None:
        from serial import Serial

        try:
            path = path_of(self._place)
        except PortMissingError as error:
            raise BackendError(f"{error}; the board's own time-out has to stop it") from error
        self._serial = Serial(path, self._baud, timeout=0, write_timeout=WRITING_S)

    def stop(self) -> str | None:
        try:
            self._write()
        except Exception:  # noqa: BLE001  pyserial's kinds have no base in common; what fails again is raised
            self.close()
            if not self._is_there():
                return f"{self._place} is gone: the board stops its motors by itself"
            self.open()
            self._write()
        if not self._has_owner and (who := holders(path_of(self._place))):
            raise BackendError(f"{self._place} is held by {who}, which may turn it again. End that program first")
        return None

    def close(self) -> None:
        serial, self._serial = self._serial, None
        if serial:
            serial.close()

    def _is_there(self) -> bool:
        try:
            path_of(self._place)
        except PortMissingError:
            return False
        return True

    def _write(self) -> None:
        assert self._serial
        self._serial.write(self._frame)
        self._serial.flush()


def stop_frame(device: str, place: str, baud: int, frame: bytes, host: Host) -> CutoffSpec:
    """Return how the guardian, or `robotcore stop`, stops a board; equal frames on one port are sent as one."""
    parameters = {"place": place, "baud": baud, "frame": frame.hex(), "has_owner": host.owner is not None}
    return CutoffSpec(device, "drivers.serial.boards.cutoff:StopFrame", parameters)
