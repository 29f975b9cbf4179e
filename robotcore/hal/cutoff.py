"""Cutoffs: with a cutoff of a driver, the guardian process stops a motor or a group of motors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any


class Unconfirmed(str):
    """The result of `Cutoff.stop` if the cutoff cannot confirm that the motors stand.

    The text contains the reason, and what will stop the motors.

    >>> f"left_motor: {Unconfirmed('its port is gone')}"
    'left_motor: its port is gone'
    """

    __slots__ = ()


class Cutoff(ABC):
    """Stops motors from the guardian's process, for example by a GPIO line or by a stop frame on a port.

    The guardian creates a cutoff from plain data, and calls its methods in a separate thread. If a method raises or
    hangs, the guardian reports the device's name, and other cutoffs are not delayed. An implementation must keep these
    rules:

    - The cutoff uses nothing of the app's process. That process may be dead, or may still hold a line or a port.
    - The cutoff's module imports little, because no wheel turns before the guardian is ready.
    - The cutoff releases the interpreter lock while it waits, as files, sockets and pyserial do. All cutoffs share a
      process.
    - The driver sends each command, even if it equals the last one. The guardian may have stopped the motor in between.
    """

    @abstractmethod
    def open(self) -> None:
        """Open the resources for `stop`. The guardian calls this before any wheel turns. Motors must not change.

        An exception ends the run. A resource that the app's process also holds must be opened in `stop`, not here.
        """

    def arm(self) -> None:  # noqa: B027  most have nothing to do
        """Let the motors turn. The guardian calls this before the first command, and again after a stop.

        A cutoff with an enable line raises the line here. Most cutoffs do nothing.
        """

    def rest(self) -> None:  # noqa: B027  most have nothing to do
        """Act after the app has stopped all motors. They stay stopped until `arm` is called. Most do nothing."""

    @abstractmethod
    def stop(self) -> str | None:
        """Stop the motors. The guardian may call this several times, even if `arm` was not called before.

        The app's process may be alive or dead. If `stop` raises, the guardian repeats it for half a second, because the
        system may need time to release a resource of the app. `stop` may return a remark for the user. If it returns
        `Unconfirmed`, the guardian does not report the motors as stopped.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the resources. The motors must stay stopped. No other method is called later."""


@dataclass(frozen=True)
class CutoffSpec:
    """The plain data from which the guardian creates a cutoff.

    >>> CutoffSpec("left_motor", "my_board.cutoff:StopFrame", {"port": "/dev/ttyACM0", "frame": "m 0 0"}).device
    'left_motor'
    """

    device: str
    """The device's name, for messages."""
    cutoff: str
    """The class, as ``module:Class``."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """The keyword arguments of the class, as JSON values."""
    patience_s: float = 0.0
    """The time in seconds by which the guardian extends its lease.

    A cutoff sets it if a stop does harm when the app was only slow. The longest patience applies to all cutoffs.
    """

    def make(self) -> Cutoff:
        """Import the class and return a closed cutoff. Raises TypeError if the class does not inherit Cutoff."""
        module, _, name = self.cutoff.partition(":")
        made = getattr(import_module(module), name)(**self.parameters)
        if not isinstance(made, Cutoff):
            raise TypeError(f"{self.cutoff} is no robotcore.hal.cutoff.Cutoff")
        return made


def merge_cutoffs(specs: Iterable[CutoffSpec]) -> tuple[CutoffSpec, ...]:
    """Merge the specifications that differ only in the device's name, and return the resulting specifications.

    A merged cutoff stops several motors.

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
