"""What encoders on pins have in common: settings, watched lines, and edges told as an angle."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from threading import Lock
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Protocol

from pydantic import Field

from drivers.raspberrypi.claiming import claiming
from drivers.raspberrypi.edges import hear_no_more
from robotcore.description import EncoderDescription, StrictModel
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Encoder
from robotcore.simulation.sampling import OnceAnInstant

if TYPE_CHECKING:
    from gpiozero import Factory, Pin

LEVELS = (
    "Fed with 3.3 V, its outputs fit the pins. One that needs 5 V drives its outputs to 5 V: then each needs a "
    "divider, 1 kΩ and 2 kΩ to ground."
)
"""What whoever connects an encoder must know."""


class EncoderSettings(StrictModel):
    """What a count is, and the electrics of the lines.

    ``counts`` says what the description's ``counts_per_turn`` counts, on a turn of the wheel, gear included: "cycles"
    of one channel (a data sheet's PPR, a disc's slots), of which every edge is used, or those "edges" themselves
    (often called CPR). ``pull_up`` connects the Pi's resistors, which outputs need that only pull low; ``bounce_s`` is
    how long a level has to hold, for contacts.
    """

    edges_per_cycle: ClassVar[int]

    counts: Literal["cycles", "edges"] = "cycles"
    pull_up: bool = True
    bounce_s: Annotated[float, Field(gt=0, le=0.01)] | None = None

    def edges_per_turn(self, told: EncoderDescription) -> int:
        """Return how many edges a turn of the wheel has, on all channels together."""
        return told.counts_per_turn * (self.edges_per_cycle if self.counts == "cycles" else 1)


class Counter(Protocol):
    """Counts edges, forward up and backward down, as its channels report them."""

    @property
    def edges(self) -> int:
        """The edges counted by now."""


class PinEncoder(Encoder):
    """Tells the edges counted by now as an angle: true whenever it is read.

    It cannot tell a wheel that stands from an encoder that is unplugged: both count nothing. A motor that is controlled
    by it reads it in a thread of its own.
    """

    def __init__(self, name: str, clock: Clock, counter: Counter, edges_per_turn: int, opened: ExitStack) -> None:
        super().__init__(name)
        self._counter, self._opened = counter, opened
        self._edge_rad = math.tau / edges_per_turn
        self._newest_at = OnceAnInstant(clock, self._take)
        self._lock = Lock()

    def _newest(self) -> Angle:
        with self._lock:
            return self._newest_at()

    def _take(self, time: float, sequence: int) -> Angle:
        return Angle(self._counter.edges * self._edge_rad, time, sequence)

    def _release(self) -> None:
        self._opened.close()


def open_input(device: str, number: int, settings: EncoderSettings, pins: Factory, opened: ExitStack) -> Pin:
    """Return an open input of a device; raises DeviceError."""
    from gpiozero import InputDevice

    pull = {"pull_up": True} if settings.pull_up else {"pull_up": None, "active_state": True}
    with claiming(device, (number,)):
        line = opened.enter_context(InputDevice(number, pin_factory=pins, **pull))
        line.pin.bounce = settings.bounce_s
        line.pin.edges = "both"
    return line.pin


def watch(device: str, pin: Pin, changed: Callable[[float, int], None], opened: ExitStack) -> None:
    """Have a bound method told of every edge, with the tick and the level; its object has to be kept."""
    with claiming(device, (int(pin.info.name.removeprefix("GPIO")),)):
        opened.callback(hear_no_more, pin)
        pin.when_changed = changed
