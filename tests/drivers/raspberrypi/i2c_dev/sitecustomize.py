"""A double of the kernel's I2C device files, on the folder `FAKE_I2C` that processes share.

Python imports this module at its start. A bus is the empty file ``i2c-N``, and a chip the file ``i2c-N.0xAA`` with its
256 registers. A transfer locks the file. So the registers outlive a killed process, as those of a real chip.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import struct
import time
from pathlib import Path
from typing import Any

SET_TIMEOUT, SET_ADDRESS, TRANSFER = 0x0702, 0x0703, 0x0720
WRITE, READ, BYTE, BLOCK = 0, 1, 2, 8
_SET = {0x00: 0x11, 0x01: 0x04, 0xFE: 0x1E, **{6 + 4 * channel + 3: 0x10 for channel in range(16)}}
POWER_ON = bytes(_SET.get(register, 0) for register in range(256))
MODE1, SLEEP, AUTO_INCREMENT, FIRST, ALL, PRE_SCALE = 0x00, 0x10, 0x20, 0x06, 0xFA, 0xFE

_open, _ioctl, _close = os.open, fcntl.ioctl, os.close
_buses: dict[int, str] = {}
_addresses: dict[int, int] = {}


def reset(chip: Path) -> None:
    """Write the registers that a PCA9685 has after power-on."""
    chip.write_bytes(POWER_ON)
    chip.with_suffix(".log").touch()


def open_file(path: Any, flags: int, mode: int = 0o777, *, dir_fd: int | None = None) -> int:
    folder = os.environ["FAKE_I2C"]
    if not str(path).startswith(("/dev/i2c-", f"{folder}/i2c-1")) or "0x" in str(path):
        return _open(path, flags, mode, dir_fd=dir_fd)
    file = _open(f"{folder}/{Path(path).name}", flags)
    _buses[file] = Path(path).name
    return file


def close_file(file: int) -> None:
    _buses.pop(file, None)
    _close(file)


def control(file: int, request: int, argument: Any = 0, mutate_flag: bool = True) -> Any:  # noqa: FBT002
    if file not in _buses:
        return _ioctl(file, request, argument, mutate_flag)
    if request == SET_ADDRESS:
        _addresses[file] = argument
    elif request == TRANSFER:
        folder = Path(os.environ["FAKE_I2C"])
        if (hang := folder / "hang").exists():
            time.sleep(float(hang.read_text()))
            raise OSError(errno.ETIMEDOUT, "Connection timed out")
        if (noise := folder / "noise").exists():
            noise.unlink()
            raise OSError(errno.EREMOTEIO, "Remote I/O error")
        transfer(folder / f"{_buses[file]}.0x{_addresses[file]:02x}", *struct.unpack("BBIP", argument))
    elif request == SET_TIMEOUT:
        Path(os.environ["FAKE_I2C"], "timeout").write_text(str(argument))
    else:
        raise OSError(errno.ENOTTY, "Inappropriate ioctl for device")
    return 0


def transfer(chip: Path, direction: int, register: int, size: int, where: int) -> None:
    try:
        file = _open(chip, os.O_RDWR)
    except FileNotFoundError:
        raise OSError(errno.EREMOTEIO, "Remote I/O error") from None
    try:
        fcntl.flock(file, fcntl.LOCK_EX)
        if direction == READ:
            assert size == BYTE
            ctypes.memmove(where, os.pread(file, 1, register), 1)
            return
        data = ctypes.string_at(where, 1)
        if size == BLOCK:
            data = ctypes.string_at(where, 34)[1 : 1 + data[0]]  # the kernel copies 34 bytes
        registers = bytearray(os.pread(file, 256, 0))
        write(registers, register, data)
        os.pwrite(file, registers, 0)
        with chip.with_suffix(".log").open("a") as log:
            log.write(f"{time.monotonic():.6f} {os.getpid()} {register} {data.hex()}\n")
    finally:
        _close(file)


def write(registers: bytearray, register: int, data: bytes) -> None:
    """Write to the registers of a chip, from a register on."""
    step = 1 if registers[MODE1] & AUTO_INCREMENT else 0
    for at, value in enumerate(data):
        number = register + step * at
        if number in range(ALL, PRE_SCALE):
            for channel in range(16):
                registers[FIRST + 4 * channel + number - ALL] = value
        elif number != PRE_SCALE or registers[MODE1] & SLEEP:
            registers[number] = value


def install() -> None:
    """Replace the calls of this process."""
    os.open, os.close, fcntl.ioctl = open_file, close_file, control  # type: ignore[assignment]


if "FAKE_I2C" in os.environ:
    install()
