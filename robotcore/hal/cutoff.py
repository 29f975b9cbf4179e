"""What a driver gives the guardian for each thing that it is to stop."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any


class Unconfirmed(str):
    """What a stop returns where nobody can tell that the motors stand: why, and what will make them, in words.

    >>> f"left_motor: {Unconfirmed('its port is gone')}"
    'left_motor: its port is gone'
    """

    __slots__ = ()


class Cutoff(ABC):
    """Makes motors stand, from a process that is not the app's: lines to pull low, a stop frame to write to a port.

    The guardian makes it from plain data, and calls each method in a thread that is the cutoff's own. A method that
    raises or hangs is told by the device's name and holds up no other cutoff. What an implementer owes:

    - It leans on nothing of the app's process, which may be gone, or hold whatever it has open: a line that the app has
      claimed is refused to others while the app lives.
    - Its module imports little: no wheel turns before the guardian is ready.
    - It releases the interpreter lock while it waits, as files, sockets and pyserial do: all cutoffs share a process.
    - Its driver sends every command, also one that is equal to the last: the motors may have been stopped meanwhile.
    """

    @abstractmethod
    def open(self) -> None:
        """Take what `stop` needs, before any wheel turns, and change nothing that moves. What is raised ends the run.

        What can only be had once the app is gone is taken in `stop`.
        """

    def arm(self) -> None:  # noqa: B027  most have nothing to do
        """Let the motors turn: a command is on its way, the first one or the first after a stop.

        For an enable line that is to be high while somebody watches; most need nothing.
        """

    def rest(self) -> None:  # noqa: B027  most have nothing to do
        """Know that the app has told every motor to stand, until it is armed again; most need nothing."""

    @abstractmethod
    def stop(self) -> str | None:
        """Make the motors stand. Called once or many times, armed or not, the app alive or gone.

        One that raises is called again for half a second: a system may need a moment to release what the app had. It
        may return what it had to do besides, in words, or `Unconfirmed`, which is told in place of the motors' names.
        """

    @abstractmethod
    def close(self) -> None:
        """Give back what opening took; the motors, which stand, stay so. Nothing is called any more."""


@dataclass(frozen=True)
class CutoffSpec:
    """How the guardian makes a cutoff by itself.

    ``device`` is what messages call it, ``cutoff`` names its class as "module:Class". The class takes ``parameters`` by
    name: plain data, which JSON can tell. A cutoff that does harm where the app only was slow asks for ``patience_s``
    beyond the lease; all of a robot's wait with it.

    >>> CutoffSpec("left_motor", "my_board.cutoff:StopFrame", {"port": "/dev/ttyACM0", "frame": "m 0 0"}).device
    'left_motor'
    """

    device: str
    cutoff: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    patience_s: float = 0.0

    def make(self) -> Cutoff:
        """Import the class and make a cutoff, not yet open."""
        module, _, name = self.cutoff.partition(":")
        made = getattr(import_module(module), name)(**self.parameters)
        if not isinstance(made, Cutoff):
            raise TypeError(f"{self.cutoff} is no robotcore.hal.cutoff.Cutoff")
        return made


def shared(specs: Iterable[CutoffSpec]) -> tuple[CutoffSpec, ...]:
    """Return the specs with those that are alike but for their device made one: what stops two motors at once.

    >>> parameters = {"line": 22}
    >>> [one] = shared(CutoffSpec(motor, "my_board:Enable", parameters) for motor in ("left_motor", "right_motor"))
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
