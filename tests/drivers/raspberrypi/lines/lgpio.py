"""A double of lgpio, with the functions that gpiozero and the drivers use, on a folder that processes share.

A chip is a folder, and a line is a file. A claim locks the file, so the line is free when its holder has ended. The
file holds the last output, as on a Raspberry Pi; another file holds the pull. PWM is its duty in percent. As in lgpio,
claiming an output again changes nothing, and an error has only a text. After the duty 0, a line never falls, as in a
process that is suspended before the end of the PWM cycle.

``FAKE_WIRES``, such as ``20:21,19:26``, connects lines by wires. A line at the second end of a wire has the level of
the first end, and its edges call callbacks. There, PWM has a waveform of 100 Hz.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path
from typing import Any

SET_PULL_UP, SET_PULL_DOWN, SET_PULL_NONE = 32, 64, 128
RISING_EDGE, FALLING_EDGE, BOTH_EDGES = 1, 2, 3
CANNOT_OPEN_CHIP, GPIO_BUSY = -78, -79

exceptions = True

_WORDS = {CANNOT_OPEN_CHIP: "can not open gpiochip", GPIO_BUSY: "GPIO busy"}
_INPUT, _OUTPUT = 0x10000, 0x2
_PULLS = SET_PULL_UP | SET_PULL_DOWN | SET_PULL_NONE
_chips: list[_Chip] = []
_watchers: list[_Callback] = []
_PWM_HZ = 100
_POLL_S = 0.0003


def _find_wires() -> dict[int, int]:
    """Return the first end of each wire by its second end."""
    pairs = [pair.split(":") for pair in os.environ.get("FAKE_WIRES", "").split(",") if pair]
    return {int(target): int(source) for source, target in pairs}


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
        if pull := flags & _PULLS:
            self.folder.joinpath(f"{gpio}.pull").write_text(str(pull))
        self.folder.joinpath(f"{gpio}.direction").write_text("out" if mode == _OUTPUT else "in")
        self.put(gpio, str(level))
        return 0

    def free(self, gpio: int) -> None:
        if gpio in self.files:
            os.close(self.files.pop(gpio))
            del self.modes[gpio]

    def put(self, gpio: int, words: str) -> None:
        os.pwrite(self.files[gpio], words.ljust(3).encode(), 0)
        for watcher in tuple(_watchers):
            watcher.check()

    def read_level_over_wire(self, gpio: int) -> bool:
        """Return the level of a line at the second end of a wire: the other end's output or pull, or its own pull."""
        source = _find_wires()[gpio]
        if fixed := self._read(f"{gpio}.fixed"):
            return fixed == "1"
        direction = self._read(f"{source}.direction")
        if direction == "out":
            number = int(self._read(str(source)) or 0)
            return bool(number == 1 or time.monotonic() * _PWM_HZ % 1 < number / 100)
        pulls = (self._read(f"{source}.pull"), self._read(f"{gpio}.pull"))
        wanted = [int(pull) for pull in pulls if pull in (str(SET_PULL_UP), str(SET_PULL_DOWN))]
        return bool(wanted and wanted[0] == SET_PULL_UP)  # of two pulls the source's is stronger here

    def _read(self, name: str) -> str:
        file = self.folder / name
        return file.read_text().strip() if file.exists() else ""

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
    chip = _chip(handle)
    if gpio in _find_wires():
        return int(chip.read_level_over_wire(gpio))
    return int(chip.get(gpio) != "0")


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
    """Calls a function at each edge of a line at the second end of a wire. Another process may drive the wire."""

    def __init__(self, chip: _Chip, gpio: int, function: Callable[[int, int, int, int], Any]) -> None:
        self._chip, self._gpio, self._function = chip, gpio, function
        self._level = chip.read_level_over_wire(gpio)
        self._lock, self._is_over = threading.RLock(), threading.Event()
        _watchers.append(self)
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def check(self) -> None:
        with self._lock:
            try:
                level = self._chip.read_level_over_wire(self._gpio)
            except KeyError:  # the test has ended, and its wires are gone
                return
            if level != self._level:
                self._level = level
                self._function(0, self._gpio, int(level), time.monotonic_ns())

    def cancel(self) -> None:
        self._is_over.set()
        if self in _watchers:
            _watchers.remove(self)

    def _watch(self) -> None:
        while not self._is_over.wait(_POLL_S):
            self.check()


class _NoCallback:
    def cancel(self) -> None: ...


def callback(
    handle: int, gpio: int, edge: int = RISING_EDGE, func: Callable[[int, int, int, int], Any] | None = None
) -> _Callback | _NoCallback:
    return _Callback(_chip(handle), gpio, func) if func and gpio in _find_wires() else _NoCallback()


def _chip(handle: int) -> _Chip:
    return _chips[handle & 0xFFFF]
