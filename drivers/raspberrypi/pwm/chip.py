"""The registers of a PCA9685: set it up, and set the PWM of its channels.

It imports little, because the guardian's process uses it too. Source: NXP's data sheet,
https://www.nxp.com/docs/en/data-sheet/PCA9685.pdf, section 7.3.
"""

from __future__ import annotations

from contextlib import ExitStack
from threading import Event
from typing import Protocol

CHANNELS = range(16)

MODE1, MODE2, FIRST_CHANNEL, ALL_CHANNELS, PRE_SCALE = 0x00, 0x01, 0x06, 0xFA, 0xFE
"""The numbers of registers. A channel has four, from `FIRST_CHANNEL` on: the counts at which it rises and falls, the
low byte first. A write to those of `ALL_CHANNELS` sets every channel."""

SLEEP, AUTO_INCREMENT, EXTERNAL_CLOCK = 0x10, 0x20, 0x40
"""Bits of MODE1. Without the others, the chip uses its own oscillator, and answers only to its own address. Only a loss
of power or a software reset clears `EXTERNAL_CLOCK`."""

_RESTART = 0x80
"""The bit of MODE1 that the chip sets if it went to sleep while a channel had PWM."""

PUSH_PULL = 0x04
"""The value of MODE2 for outputs that are driven high and low. They change at the end of a transfer."""

FULL_BIT = 0x10
"""The bit in the high byte of a count that switches a channel fully on or off. Off overrides on."""

STEPS = 4096
"""The counts in a cycle of the PWM."""

OSCILLATOR_HZ = 25e6
MIN_HZ, MAX_HZ = 24, 1526

_MIN_PRESCALE = 3
"""The least value of PRE_SCALE, which the chip keeps for any lower one."""

_WAKING_S = 0.0005
"""The time that the oscillator needs after a sleep, in seconds."""


class Registers(Protocol):
    """The registers of a chip, such as an `I2CDevice`."""

    def write(self, register: int, *values: int) -> None:
        """Write bytes to successive registers."""

    def read(self, register: int) -> int:
        """Return the byte in a register."""

    def close(self) -> None:
        """Release the chip."""


class WrongChipError(OSError):
    """The registers do not keep their values, so they are not those of a PCA9685."""


class ExternalClockError(OSError):
    """A program has set the chip to an external clock. The frequency of the PWM is unknown."""


class ResetError(OSError):
    """The chip was reset, for example by a loss of power, and its outputs are off."""


def find_prescale(frequency_hz: float) -> int:
    """Return the value of the register PRE_SCALE for a frequency.

    >>> find_prescale(50), find_prescale(1500)
    (121, 3)
    """
    return round(OSCILLATOR_HZ / (STEPS * frequency_hz)) - 1


def require_pwm_chip(registers: Registers) -> None:
    """Raise WrongChipError if a chip's registers have values that a PCA9685 never has. No register changes.

    The chip has no number of its own. A PCA9685 reads zero in the high bits of its counts, and has a prescale from 3.
    """
    highs = [FIRST_CHANNEL + 4 * channel + at for channel in CHANNELS for at in (1, 3)]
    for register in (PRE_SCALE, *highs):
        value = registers.read(register)
        if value < _MIN_PRESCALE if register == PRE_SCALE else value >= 2 * FULL_BIT:
            raise WrongChipError(f"its register 0x{register:02x} has 0x{value:02x}")


class PwmChip:
    """A PCA9685. Any thread may use it. Each method raises OSError if the chip does not answer.

    registers: the chip's registers, which `close` releases.
    """

    def __init__(self, registers: Registers) -> None:
        self._registers = registers
        self._count_s = 0.0

    def begin(self, frequency_hz: float) -> None:
        """Switch every channel off, set the frequency of the PWM, and start it.

        Raises WrongChipError, before the first write, if the chip is no PCA9685. Raises it too if the registers do not
        keep these values. Raises ExternalClockError if the chip does not use its own oscillator.
        """
        require_pwm_chip(self._registers)
        self.stop()
        if self._registers.read(MODE1) & EXTERNAL_CLOCK:
            raise ExternalClockError
        prescale = find_prescale(frequency_hz)
        self._registers.write(MODE1, SLEEP | AUTO_INCREMENT)  # PRE_SCALE is writable only during a sleep
        self._registers.write(PRE_SCALE, prescale)
        self._registers.write(MODE2, PUSH_PULL)
        self._registers.write(MODE1, AUTO_INCREMENT)
        Event().wait(_WAKING_S)
        self._count_s = (prescale + 1) / OSCILLATOR_HZ
        wanted = {MODE1: AUTO_INCREMENT, MODE2: PUSH_PULL, PRE_SCALE: prescale}
        for register, value in wanted.items():
            if (found := self._registers.read(register) & ~_RESTART) != value:
                raise WrongChipError(f"its register 0x{register:02x} has 0x{found:02x} after 0x{value:02x} was written")

    def set_duty(self, channel: int, duty: float) -> None:
        """Set the duty of a channel, 0 to 1.

        Raises ResetError if a duty above 0 has no effect, because the chip was reset.
        """
        count = round(duty * STEPS)
        if count <= 0:
            self._set_counts(channel, 0, FULL_BIT << 8)
            return
        self._set_counts(channel, *((FULL_BIT << 8, 0) if count >= STEPS else (0, count)))
        if self._registers.read(MODE1) & SLEEP:
            raise ResetError("the chip sleeps")

    def set_pulse(self, channel: int, width_s: float) -> None:
        """Set the width of a channel's pulses, in seconds."""
        self.set_duty(channel, width_s / self._count_s / STEPS)

    def stop(self) -> None:
        """Switch every channel off, in one transfer of one byte."""
        self._registers.write(ALL_CHANNELS + 3, FULL_BIT)

    def close(self) -> None:
        """Switch every channel off, and release the chip."""
        with ExitStack() as closing:
            closing.callback(self._registers.close)
            self.stop()

    def _set_counts(self, channel: int, rise: int, fall: int) -> None:
        self._registers.write(FIRST_CHANNEL + 4 * channel, rise & 0xFF, rise >> 8, fall & 0xFF, fall >> 8)
