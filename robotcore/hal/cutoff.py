"""Cutoffs: the code of a driver with which the guardian process stops motors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any


class UnconfirmedStop(str):
    """The result of `Cutoff.stop` if the cutoff cannot confirm that the motors have stopped.

    The text names the reason, and what will stop the motors instead.

    >>> f"left_motor: {UnconfirmedStop('its port is gone')}"
    'left_motor: its port is gone'
    """

    __slots__ = ()


class Cutoff(ABC):
    """Stops motors from the guardian's process, for example by a GPIO line or by a stop command on a serial port.

    The guardian creates a cutoff from a `CutoffSpec`, and calls its methods in a separate thread. If a method raises or
    hangs, the guardian reports the device's name, and the other cutoffs are not delayed. An implementation must keep
    these rules:

    - The cutoff uses no object of the app's process. That process may be dead, or may still hold a line or a port.
    - The cutoff's module imports little, because no wheel turns before the guardian is ready.
    - The cutoff releases the interpreter lock while it waits, because all cutoffs share a process. Files, sockets and
      pyserial do so.
    - The driver sends every command, even if it equals the last one, because the guardian may have stopped the motor.

    >>> class StopLine(Cutoff):
    ...     def __init__(self, line):
    ...         self.line = line
    ...
    ...     def open(self):
    ...         print(f"open line {self.line}")
    ...
    ...     def stop(self):
    ...         print("low")
    ...
    ...     def close(self):
    ...         print("close")
    >>> cutoff = StopLine(line=22)
    >>> for step in (cutoff.open, cutoff.arm, cutoff.stop, cutoff.close):
    ...     step()
    open line 22
    low
    close
    """

    @abstractmethod
    def open(self) -> None:
        """Open the resources for `stop`. The guardian calls this before any wheel turns.

        This method must not change the state of a motor. An exception ends the run. A resource that the app's process
        also holds must be opened in `stop`, not here.
        """

    def arm(self) -> None:  # noqa: B027  most have nothing to do
        """Enable the motors. The guardian calls this before the first command, and again after a stop.

        A cutoff with an enable line raises the line here. Most other cutoffs do nothing.
        """

    def disarm(self) -> None:  # noqa: B027  most have nothing to do
        """Handle a stop by the app. The guardian calls this after the app has stopped all motors.

        The motors stay stopped until the next `arm`. A cutoff with an enable line lowers the line here. Most other
        cutoffs do nothing.
        """

    @abstractmethod
    def stop(self) -> str | None:
        """Stop the motors, and optionally return a remark for the user.

        If the remark is an `UnconfirmedStop`, the guardian does not report the motors as stopped.

        The guardian may call this several times, even without an `arm` before. The app's process may be alive or dead.
        If `stop` raises, the guardian calls it again for half a second, because the operating system may need time to
        release a resource of the app.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the resources. The motors must stay stopped. No method is called afterwards."""


@dataclass(frozen=True)
class CutoffSpec:
    """The plain data from which the guardian creates a cutoff.

    >>> CutoffSpec("left_motor", "my_board.cutoff:StopFrame", {"port": "/dev/ttyACM0", "frame": "m 0 0"}).device
    'left_motor'
    """

    device: str
    """The device's name, for messages."""
    cutoff: str
    """The class of the cutoff, as ``module:Class``."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """The keyword arguments for the class, as JSON values."""
    extra_lease_s: float = 0.0
    """The additional time, in seconds, that the guardian waits for a late app before it stops the motors.

    Set it if an unnecessary stop does harm. The longest patience of all cutoffs applies to all of them.
    """

    def make(self) -> Cutoff:
        """Import the class, and return a cutoff that is not open yet. Raises TypeError if the class is not a Cutoff."""
        module, _, name = self.cutoff.partition(":")
        made = getattr(import_module(module), name)(**self.parameters)
        if not isinstance(made, Cutoff):
            raise TypeError(f"{self.cutoff} does not inherit robotcore.hal.cutoff.Cutoff")
        return made


def merge_cutoffs(specs: Iterable[CutoffSpec]) -> tuple[CutoffSpec, ...]:
    """Return the specifications with those merged that differ only in the name of the device.

    specs: the specifications of all motors.

    >>> from robotcore.hal.cutoff import CutoffSpec
    >>> parameters = {"line": 22}
    >>> motors = ("left_motor", "right_motor")
    >>> [one] = merge_cutoffs(CutoffSpec(motor, "my_board:Enable", parameters) for motor in motors)
    >>> one.device
    'left_motor and right_motor'
    """
    different: list[CutoffSpec] = []
    for spec in specs:
        for at, other in enumerate(different):
            if (spec.cutoff, spec.parameters) == (other.cutoff, other.parameters):
                different[at] = replace(other, device=f"{other.device} and {spec.device}")
                break
        else:
            different.append(spec)
    return tuple(different)
