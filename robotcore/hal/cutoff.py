"""Cutoffs: a driver gives the guardian process one for each motor, or group of motors, that it must stop."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any


class Unconfirmed(str):
    """The result of a stop that cannot confirm that the motors stand: the reason, and what will stop them.

    >>> f"left_motor: {Unconfirmed('its port is gone')}"
    'left_motor: its port is gone'
    """

    __slots__ = ()


class Cutoff(ABC):
    """Stops motors from the guardian's process, for example by a GPIO line or by a stop frame on a port.

    The guardian creates it from plain data, and calls its methods in a thread of their own. If a method raises or
    hangs, the guardian reports the device's name, and other cutoffs are not delayed. An implementation must keep these
    rules:

    - It uses nothing of the app's process. That process may be dead, or may still hold a line or a port.
    - Its module imports little, because no wheel turns before the guardian is ready.
    - It releases the interpreter lock while it waits, as files, sockets and pyserial do. All cutoffs share a process.
    - Its driver sends each command, even if it equals the last one. A stop may have come in between.
    """

    @abstractmethod
    def open(self) -> None:
        """Open the resources for `stop`, before any wheel turns. Nothing that moves may change.

        An error ends the run. Resources that the app's process holds are opened in `stop`.
        """

    def arm(self) -> None:  # noqa: B027  most have nothing to do
        """Let the motors turn. The guardian calls it before the first command, and before the first after a stop.

        A cutoff with an enable line raises the line here. Most cutoffs do nothing.
        """

    def rest(self) -> None:  # noqa: B027  most have nothing to do
        """Note that the app has stopped all motors. They stay so until `arm` is called. Most cutoffs do nothing."""

    @abstractmethod
    def stop(self) -> str | None:
        """Stop the motors. The guardian may call it many times, armed or not, with the app alive or dead.

        If it raises, it is called again for half a second, because the system may need time to release a resource of
        the app. It may return a remark for the user, or `Unconfirmed`, which is reported in place of the motors' names.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the resources. The motors stand and must stay so. No method is called after it."""


@dataclass(frozen=True)
class CutoffSpec:
    """The plain data from which the guardian creates a cutoff.

    >>> CutoffSpec("left_motor", "my_board.cutoff:StopFrame", {"port": "/dev/ttyACM0", "frame": "m 0 0"}).device
    'left_motor'
    """

    device: str
    """The name for messages."""
    cutoff: str
    """The class, as ``module:Class``."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """The keyword arguments of the class, as JSON values."""
    patience_s: float = 0.0
    """An additional time after the lease, for a cutoff that does harm if the app was only slow. All cutoffs wait."""

    def make(self) -> Cutoff:
        """Import the class and return a cutoff that is not open. Raises TypeError if the class is no Cutoff."""
        module, _, name = self.cutoff.partition(":")
        made = getattr(import_module(module), name)(**self.parameters)
        if not isinstance(made, Cutoff):
            raise TypeError(f"{self.cutoff} is no robotcore.hal.cutoff.Cutoff")
        return made


def merge_cutoffs(specs: Iterable[CutoffSpec]) -> tuple[CutoffSpec, ...]:
    """Return the specs, with those that differ only by their device merged: such a cutoff stops several motors.

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
