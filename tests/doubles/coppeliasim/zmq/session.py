"""What a call can reach: the simulator, whose call it is, and what all clients of a server share."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.scene import Simulator, State, Ticket

if TYPE_CHECKING:
    from tests.doubles.coppeliasim.zmq.lua import Scripts


class Waiting(Exception):  # noqa: N818  no error: the reply is to come later
    """A call that is answered when a step has been made; without a ticket, when the simulation is stopped."""

    def __init__(self, ticket: Ticket | None) -> None:
        super().__init__(ticket)
        self.ticket = ticket

    def is_over(self, simulator: Simulator) -> bool:
        return simulator.is_done(self.ticket) if self.ticket else simulator.state is State.STOPPED


@dataclass
class Shared:
    """What clients share beside the scene: values that are kept, scripts, and further functions by their full name."""

    simulator: Simulator
    services: dict[str, Callable[..., Any]] = field(default_factory=dict)
    signals: dict[str, Any] = field(default_factory=dict)
    kept: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    clock: MonotonicClock = field(default_factory=MonotonicClock)

    @cached_property
    def scripts(self) -> Scripts:
        """The Lua of this server."""
        from tests.doubles.coppeliasim.zmq.lua import Scripts

        return Scripts(Session(self.simulator, self))


@dataclass(frozen=True)
class Session:
    """Whose call it is: a client's by its uuid, or a script's, which has none."""

    simulator: Simulator
    shared: Shared
    client: str = ""


RECORDED = Path(__file__).parents[1] / "recorded"


@cache
def table() -> dict[str, dict[str, Any]]:
    """Return it as the server sends it: ``{"func": {}}`` or ``{"const": value}`` by name."""
    content: dict[str, dict[str, Any]] = json.loads((RECORDED / "sim-info.json").read_text())
    return content


def constants() -> dict[str, Any]:
    """Return the constants by name."""
    return {name: entry["const"] for name, entry in table().items() if "const" in entry}
