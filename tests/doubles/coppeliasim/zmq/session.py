"""The context of a call: the simulator, the client, and the state that clients share."""

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


class PendingReply(Exception):  # noqa: N818  not an error
    """The reply to a call must wait for the end of a step.

    Without a ticket, it must wait until the simulation has stopped.
    """

    def __init__(self, ticket: Ticket | None) -> None:
        super().__init__(ticket)
        self.ticket = ticket

    def is_over(self, simulator: Simulator) -> bool:
        return simulator.is_done(self.ticket) if self.ticket else simulator.state is State.STOPPED


@dataclass
class SharedState:
    """The state that clients share besides the scene: signals, stored values, scripts, and further functions."""

    simulator: Simulator
    services: dict[str, Callable[..., Any]] = field(default_factory=dict)
    signals: dict[str, Any] = field(default_factory=dict)
    stored_values: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    clock: MonotonicClock = field(default_factory=MonotonicClock)

    @cached_property
    def scripts(self) -> Scripts:
        """The Lua scripts of the server."""
        from tests.doubles.coppeliasim.zmq.lua import Scripts

        return Scripts(Session(self.simulator, self))


@dataclass(frozen=True)
class Session:
    """The context of a call: the simulator, the shared state, and the uuid of the client. A script has no uuid."""

    simulator: Simulator
    shared: SharedState
    client: str = ""


RECORDED = Path(__file__).parents[1] / "recorded"


@cache
def table() -> dict[str, dict[str, Any]]:
    """Return the table of functions and constants by name: ``{"func": {}}`` or ``{"const": value}``."""
    content: dict[str, dict[str, Any]] = json.loads((RECORDED / "sim-info.json").read_text())
    return content


def constants() -> dict[str, Any]:
    """Return the constants by name."""
    return {name: entry["const"] for name, entry in table().items() if "const" in entry}
