"""A model of a PCA9685: its registers, and the duties of its channels."""

from __future__ import annotations

from collections.abc import Callable

from drivers.raspberrypi.pwm.chip import (
    ALL_CHANNELS,
    AUTO_INCREMENT,
    CHANNELS,
    FIRST_CHANNEL,
    FULL_BIT,
    MODE1,
    MODE2,
    OSCILLATOR_HZ,
    PRE_SCALE,
    PUSH_PULL,
    SLEEP,
    STEPS,
)


class VirtualChannel:
    """The output of a channel. Its ``state`` is the duty, 0 to 1, as the state of a pin with PWM."""

    def __init__(self) -> None:
        self.state = 0.0
        self._listeners: list[Callable[[], object]] = []

    def on_change(self, listener: Callable[[], object]) -> None:
        """Call ``listener`` after each change of the duty."""
        self._listeners.append(listener)

    def show(self, duty: float) -> None:
        """Set the duty."""
        if duty != self.state:
            self.state = duty
            for listener in self._listeners:
                listener()


class VirtualPwmChip:
    """The registers of a PCA9685 after power-on. A transfer changes the outputs at its end.

    >>> chip = VirtualPwmChip()
    >>> chip.write(0x00, 0x20)
    >>> chip.write(0x06, 0, 0, 0, 8)  # half of 4096 counts
    >>> chip.channels[0].state
    0.5
    """

    def __init__(self) -> None:
        self.channels = [VirtualChannel() for _ in CHANNELS]
        self.reset()

    def reset(self) -> None:
        """Set each register as after a loss of power."""
        self._registers = {MODE1: SLEEP | 0x01, MODE2: PUSH_PULL, PRE_SCALE: 0x1E}
        for channel in CHANNELS:
            self._set_counts(channel, bytes([0, 0, 0, FULL_BIT]))
        self._show()

    @property
    def frequency_hz(self) -> float:
        return OSCILLATOR_HZ / STEPS / (self._registers[PRE_SCALE] + 1)

    def write(self, register: int, *values: int) -> None:
        """Write bytes to successive registers, or all to the first one if the chip does not increment its number."""
        step = 1 if self._registers[MODE1] & AUTO_INCREMENT else 0
        for at, value in enumerate(values):
            number = register + step * at
            if number >= ALL_CHANNELS and number != PRE_SCALE:
                for channel in CHANNELS:
                    self._registers[FIRST_CHANNEL + 4 * channel + number - ALL_CHANNELS] = value
            elif number != PRE_SCALE or self._registers[MODE1] & SLEEP:
                self._registers[number] = value
        self._show()

    def read(self, register: int) -> int:
        """Return the byte in a register. Those of all channels have 0."""
        return self._registers.get(register, 0)

    def close(self) -> None:
        """Do nothing: the chip keeps its outputs."""

    def _set_counts(self, channel: int, counts: bytes) -> None:
        self._registers.update(enumerate(counts, start=FIRST_CHANNEL + 4 * channel))

    def _show(self) -> None:
        is_asleep = self._registers[MODE1] & SLEEP
        for number, channel in enumerate(self.channels):
            channel.show(0.0 if is_asleep else self._compute_duty(number))

    def _compute_duty(self, channel: int) -> float:
        first = FIRST_CHANNEL + 4 * channel
        rise_low, rise_high, fall_low, fall_high = (self._registers[first + at] for at in range(4))
        if fall_high & FULL_BIT:
            return 0.0
        if rise_high & FULL_BIT:
            return 1.0
        counts = (fall_low | fall_high << 8) - (rise_low | rise_high << 8)
        return counts % STEPS / STEPS
