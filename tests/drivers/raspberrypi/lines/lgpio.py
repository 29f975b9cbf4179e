"""A double of lgpio, with the functions that gpiozero and the drivers use, on a folder that processes share.

A chip is a folder, and a line is a file. A claim locks the file, so the line is free when its holder has ended. The
file holds the last output, as on a Raspberry Pi; another file holds the pull. PWM is its duty in percent. As in lgpio,
claiming an output again changes nothing, and an error has only a text. After the duty 0, a line never falls, as in a
process that is suspended before the end of the PWM cycle.
"""

from __future__ import annotations

import os
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path

SET_PULL_UP, SET_PULL_DOWN, SET_PULL_NONE = 32, 64, 128
RISING_EDGE, FALLING_EDGE, BOTH_EDGES = 1, 2, 3
CANNOT_OPEN_CHIP, GPIO_BUSY = -78, -79

exceptions = True

_WORDS = {CANNOT_OPEN_CHIP: "can not open gpiochip", GPIO_BUSY: "GPIO busy"}
_INPUT, _OUTPUT = 0x10000, 0x2
_PULLS = SET_PULL_UP | SET_PULL_DOWN | SET_PULL_NONE
_chips: list[_Chip] = []


class error(Exception):  # noqa: N801, N818  the name in lgpio
    def __init__(self, value: str) -> None:
        self.value = value

    def __str__(self) -> str:
        return repr(self.value)


class _Chip:
    def __init__(self, number: int) -> None:
        self.folder = Path(os.environ["FAKE_DEV"]) / f"gpiochip{number}"
        self.files: dict[int, int] = {}
        self.modes: dict[int, int] = {}

    def claim(self, gpio: int, mode: int, level: int = 0, flags: int = 0) -> int:
        if self.modes.get(gpio) == mode:
            return 0
        self.free(gpio)
        file = os.open(self.folder / str(gpio), os.O_RDWR | os.O_CREAT)
        try:
            flock(file, LOCK_EX | LOCK_NB)
        except BlockingIOError:
            os.close(file)
            return _result(GPIO_BUSY)
        self.files[gpio], self.modes[gpio] = file, mode
        self.put(gpio, str(level))
        if pull := flags & _PULLS:
            self.folder.joinpath(f"{gpio}.pull").write_text(str(pull))
        return 0

    def free(self, gpio: int) -> None:
        if gpio in self.files:
            os.close(self.files.pop(gpio))
            del self.modes[gpio]

    def put(self, gpio: int, words: str) -> None:
        os.pwrite(self.files[gpio], words.ljust(3).encode(), 0)

    def get(self, gpio: int) -> str:
        return os.pread(self.files[gpio], 3, 0).decode().strip()


def _result(status: int) -> int:
    if status < 0 and exceptions:
        raise error(error_text(status))
    return status


def error_text(errnum: int) -> str:
    return _WORDS[errnum]


def gpiochip_open(gpiochip: int) -> int:
    chip = _Chip(gpiochip)
    if not chip.folder.is_dir():
        return _result(CANNOT_OPEN_CHIP)
    _chips.append(chip)
    return len(_chips) - 1 | gpiochip << 16


def gpiochip_close(handle: int) -> int:
    chip = _chip(handle)
    for gpio in list(chip.files):
        chip.free(gpio)
    return 0


def gpio_claim_input(handle: int, gpio: int, lFlags: int = 0) -> int:  # noqa: N803
    return _chip(handle).claim(gpio, _INPUT, flags=lFlags)


def gpio_claim_output(handle: int, gpio: int, level: int = 0, lFlags: int = 0) -> int:  # noqa: N803
    return _chip(handle).claim(gpio, _OUTPUT, level, lFlags)


def gpio_claim_alert(handle: int, gpio: int, *_: object) -> int:
    return _chip(handle).claim(gpio, _INPUT)


def gpio_set_debounce_micros(handle: int, gpio: int, debounce_micros: int) -> int:
    return 0


def gpio_free(handle: int, gpio: int) -> int:
    _chip(handle).free(gpio)
    return 0


def gpio_get_mode(handle: int, gpio: int) -> int:
    return _chip(handle).modes.get(gpio, 0)


def gpio_read(handle: int, gpio: int) -> int:
    return int(_chip(handle).get(gpio) != "0")


def gpio_write(handle: int, gpio: int, level: int) -> int:
    gpio_claim_output(handle, gpio, level)
    _chip(handle).put(gpio, str(int(level)))
    return 0


def tx_pwm(handle: int, gpio: int, pwm_frequency: float, pwm_duty_cycle: float, *_: object) -> int:
    if pwm_frequency:
        gpio_claim_output(handle, gpio)
        if pwm_duty_cycle:
            _chip(handle).put(gpio, str(int(pwm_duty_cycle)))
    return 0


class _Callback:
    def cancel(self) -> None: ...


def callback(handle: int, gpio: int, *_: object) -> _Callback:
    return _Callback()


def _chip(handle: int) -> _Chip:
    return _chips[handle & 0xFFFF]
