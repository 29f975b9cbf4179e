"""One chip on an I2C bus, by the kernel's device file of the bus.

It imports little, because the guardian's process uses it too. The calls are SMBus transfers, which
every I2C driver of the kernel has. Source: https://www.kernel.org/doc/html/latest/i2c/dev-interface.html.
"""

from __future__ import annotations

import errno
import os
import struct
from array import array
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from weakref import WeakSet

from robotcore.system import IS_LINUX

if IS_LINUX:
    from fcntl import F_OFD_GETLK, F_OFD_SETLK, F_UNLCK, F_WRLCK, fcntl, ioctl

_SET_TIMEOUT, _SET_ADDRESS, _TRANSFER = 0x0702, 0x0703, 0x0720
"""The requests I2C_TIMEOUT, I2C_SLAVE and I2C_SMBUS. Source: Linux, include/uapi/linux/i2c-dev.h."""

_WRITE, _READ = 0, 1
_BYTE, _BLOCK = 2, 8
"""The sizes I2C_SMBUS_BYTE_DATA and I2C_SMBUS_I2C_BLOCK_DATA. Source: Linux, include/uapi/linux/i2c.h."""

_DATA_BYTES = 34
"""The size of the union i2c_smbus_data in bytes. For a block, the kernel copies all of them, also of a short one.

Source: Linux, drivers/i2c/i2c-dev.c, i2cdev_ioctl_smbus."""

_NOT_ACKNOWLEDGED = (errno.ENXIO, getattr(errno, "EREMOTEIO", errno.ENXIO))  # only Linux has the second one
"""The errors of a transfer that the chip did not acknowledge, which noise on the wires can cause.

Source: https://www.kernel.org/doc/html/latest/i2c/fault-codes.html, and Linux, drivers/i2c/busses/i2c-bcm2835.c."""

_LOCK = "hhqqi"
"""The fields of the kernel's struct flock: kind, origin, first byte, number of bytes, process. Source: fcntl(2)."""

_CLOSED = -1
"""The number in place of that of a closed file."""

TIMEOUT_S = 0.1
"""The longest transfer, in seconds. The kernel's own limit is a second, in which a hung bus delays every stop.

The kernel keeps this limit for all programs that use the bus, until the next start of the system."""


def find_bus(number: int, root: Path = Path("/")) -> Path:
    """Return the device file of an I2C bus."""
    return root / f"dev/i2c-{number}"


class ReservedChipError(OSError):
    """Another program has reserved the chip."""


class I2CDevice:
    """A chip with registers of one byte. Any thread may use it, and other processes at the same time.

    Each method raises OSError if the chip does not answer. A transfer that the chip did not acknowledge is repeated
    once. In a forked process the chip is closed.
    """

    def __init__(self, bus: Path, address: int) -> None:
        """Open the device file of a bus. The chip gets no message.

        address: the 7-bit address of the chip.

        Raises OSError if there is no such file, or if a driver of the kernel uses the address.
        """
        with ExitStack() as undo:
            self._file = os.open(bus, os.O_RDWR | os.O_CLOEXEC)
            undo.callback(os.close, self._file)
            self._address = address
            ioctl(self._file, _SET_ADDRESS, address)
            ioctl(self._file, _SET_TIMEOUT, round(TIMEOUT_S * 100))  # in units of 10 ms
            self._opened = undo.pop_all()
        _devices.add(self)

    def reserve(self) -> None:
        """Reserve the chip until `close`; raises ReservedChipError if another program has reserved it.

        A reservation is a lock on the byte of the device file with the number of the address. It ends with the program.
        Programs that do not reserve a chip can still write to it.
        """
        try:
            self._lock(F_OFD_SETLK)
        except BlockingIOError as error:
            raise ReservedChipError from error

    def is_reserved(self) -> bool:
        """Return whether another program has reserved the chip."""
        kind, *_ = struct.unpack(_LOCK, self._lock(F_OFD_GETLK))
        return bool(kind != F_UNLCK)

    def write(self, register: int, *values: int) -> None:
        """Write one byte, or several to successive registers, in one transfer."""
        if len(values) == 1:
            self._transfer(_WRITE, register, _BYTE, values)
        else:
            self._transfer(_WRITE, register, _BLOCK, (len(values), *values))

    def read(self, register: int) -> int:
        """Return the byte in a register."""
        return self._transfer(_READ, register, _BYTE)[0]

    def close(self) -> None:
        """Close the device file. A second `close` does nothing. Later transfers raise OSError."""
        self._file = _CLOSED  # another file may get the number
        self._opened.close()

    def _lock(self, request: int) -> bytes:
        lock = struct.pack(_LOCK, F_WRLCK, os.SEEK_SET, self._address, 1, 0)
        return fcntl(self._file, request, lock)

    def _transfer(self, direction: int, register: int, size: int, values: Sequence[int] = ()) -> array[int]:
        data = array("B", bytes(values).ljust(_DATA_BYTES, b"\0"))
        where, _ = data.buffer_info()
        request = struct.pack("BBIP", direction, register, size, where)
        try:
            self._send(request)
        except OSError as error:
            if error.errno not in _NOT_ACKNOWLEDGED:
                raise
            self._send(request)
        return data

    def _send(self, request: bytes) -> None:
        if (file := self._file) == _CLOSED:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        ioctl(file, _TRANSFER, request)


_devices: WeakSet[I2CDevice] = WeakSet()


def _close_in_fork() -> None:
    # Otherwise a forked process keeps the chips reserved after the end of this one.
    for device in tuple(_devices):
        device.close()


if IS_LINUX:
    os.register_at_fork(after_in_child=_close_in_fork)
