"""Send a motor's commands in the background, so that an app does not wait for the board."""

from collections import deque
from collections.abc import Callable
from threading import Lock

from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock

from old_board.error_translation import translate_errors

PERIOD_S = 0.01
SILENT_S = 1.0
"""A board that does not take a command within this time, in seconds, counts as silent."""


class CommandSender:
    """Calls ``send(rad_s)`` with the newest velocity. A command is sent once, and replaces an older one.

    So a board with a time-out stops the motor if the app sends no more commands.
    """

    def __init__(self, device: str, clock: Clock, send: Callable[[float], None]) -> None:
        self._device, self._clock, self._send = device, clock, send
        self._newest: deque[float] = deque(maxlen=1)
        self._lock = Lock()
        self._failure: DeviceError | None = None
        self._began_at: float | None = None
        self._sending = clock.call_every(PERIOD_S, self._send_newest, device)

    def put(self, rad_s: float) -> None:
        """Store a velocity in rad/s to send.

        Raises DeviceError if the last command failed, or if the board has not taken it for `SILENT_S` seconds.
        """
        self._newest.append(rad_s)
        if self._failure:
            raise self._failure
        began_at = self._began_at
        if began_at is not None and (silent_s := self._clock.now() - began_at) > SILENT_S:
            raise DeviceError(
                self._device,
                f"the board has not taken a command for {silent_s:.1f} s. Check its cable and its power",
                kind="board-silent",
            )

    def stop(self) -> None:
        """End the background calls, and send the last command. Raises DeviceError if that fails."""
        self._sending.stop()
        self._send_newest()
        if self._failure:
            raise self._failure

    def _send_newest(self) -> None:
        with self._lock:  # the stop of `stop` must not overtake an earlier command
            if not self._newest:
                return
            self._began_at = self._clock.now()
            try:
                with translate_errors(self._device):
                    self._send(self._newest.pop())
                self._failure = None
            except DeviceError as failure:
                self._failure = failure
            finally:
                self._began_at = None
