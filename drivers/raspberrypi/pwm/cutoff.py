"""Stop the motors on a PCA9685 from the guardian's process."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack

from drivers.raspberrypi.cutoff import Owner
from drivers.raspberrypi.i2c_device import I2CDevice, find_bus
from drivers.raspberrypi.pwm.chip import PwmChip
from robotcore.errors import BackendError
from robotcore.hal.cutoff import Cutoff


class ChannelCutoff(Cutoff):
    """Stops a motor by switching its channels off.

    Any process may write to a chip on an I2C bus, so the motors of an app that hangs stop while it runs. Its servos
    hold their angles. After the end of the app, every channel of the chip is switched off, also those of servos.

    channels: the channels of the motor, in the order in which they are switched off.
    owner: the number of the app's process. With None, `stop` raises BackendError if a run uses the chip, because that
        run turns its motors on again.

    >>> ChannelCutoff(1, 0x60, [8, 9, 10], owner=None)
    <ChannelCutoff 8, 9, 10 of 0x60 on bus 1>
    """

    def __init__(self, bus: int, address: int, channels: Sequence[int], owner: int | None) -> None:
        self._bus, self._address, self._channels, self._pid = bus, address, channels, owner
        self._opened = ExitStack()

    def __repr__(self) -> str:
        return f"<ChannelCutoff {', '.join(map(str, self._channels))} of 0x{self._address:02x} on bus {self._bus}>"

    def open(self) -> None:
        self._device = I2CDevice(find_bus(self._bus), self._address)
        self._opened.callback(self._device.close)
        self._chip = PwmChip(self._device)
        self._owner = None if self._pid is None else Owner(self._pid)
        if self._owner:
            self._opened.callback(self._owner.close)

    def stop(self) -> None:
        is_in_use = self._device.is_reserved() if self._owner is None else not self._owner.is_ending()
        if not is_in_use:
            self._chip.stop()
            return
        for channel in self._channels:
            self._chip.set_duty(channel, 0.0)
        if self._owner is None:
            where = f"0x{self._address:02x} on bus {self._bus}"
            problem = f"a run uses the chip at {where}, and turns its motors on again"
            raise BackendError(f"{problem}. End it: robotcore stop, without --backend", kind="chip-held")

    def close(self) -> None:
        self._opened.close()
