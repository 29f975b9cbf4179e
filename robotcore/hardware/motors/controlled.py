"""A motor whose wheel is held at its velocity by its encoder."""

from __future__ import annotations

from contextlib import suppress
from threading import RLock

from robotcore.description import MotorDescription
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import Clock, Polling
from robotcore.hal.devices import Encoder
from robotcore.hardware.motors.control import VelocityControl
from robotcore.hardware.motors.duty import DutyMotor, Output
from robotcore.hardware.motors.model import MotorModel


class ControlledMotor(DutyMotor):
    """Sends what a controller makes of each command and, between commands, of what the encoder tells.

    Commands may come from several threads, and corrections come from one more: what is asked for and what is sent for
    it belong together by a lock that is only held while a command is handed on: nothing turns the wheel after a stop.
    Where the encoder fails the motor stops, and the next command that would turn it raises why. One that was lost is
    looked at again then: where it is back, nothing is raised.
    """

    def __init__(
        self, told: MotorDescription, model: MotorModel, output: Output, control: VelocityControl, encoder: Encoder
    ) -> None:
        super().__init__(told, model, output)
        self._control, self._encoder = control, encoder
        self._asked = 0.0
        self._failure: DeviceError | None = None
        self._lock = RLock()
        self._polling: Polling | None = None

    def begin(self, clock: Clock, period: float) -> None:
        """Look at the encoder now, and every ``period`` seconds from now on."""
        self._correct()
        self._polling = clock.every(period, self._correct, f"{self.name} control")

    def _apply(self, rad_s: float) -> None:
        with self._lock:
            if rad_s:
                self._require_encoder()
            if rad_s * self._asked <= 0:
                self._control.restart()
            self._asked = rad_s
            self._send(self._control.sent(rad_s) if rad_s else 0.0)

    def _require_encoder(self) -> None:
        """Raise why the encoder has failed, once; of one that was lost, for as long as it is.

        One that is back is gone on from: what the wheel did not turn meanwhile is not made up for.
        """
        if isinstance(self._failure, DeviceLostError):
            sample = self._encoder.read()
            self._control.corrected(self._asked, sample.angle, sample.time)
            self._failure = None
        elif failure := self._failure:
            self._failure = None
            raise failure

    def _correct(self) -> None:
        try:
            sample = self._encoder.read()
            with self._lock:
                velocity = self._control.corrected(self._asked, sample.angle, sample.time)
                if self._asked:
                    self._send(velocity)
        except DeviceError as failure:
            self._fail(failure)

    def _fail(self, failure: DeviceError) -> None:
        with self._lock, suppress(DeviceError):  # the first failure says why
            self._failure = self._failure or failure
            self._apply(0.0)

    def _release(self) -> None:
        if self._polling:
            self._polling.stop()
        super()._release()
