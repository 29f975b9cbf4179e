"""Where two recordings agree, and where they part."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import zip_longest
from typing import Any

from robotcore.recording import Tick
from robotcore.recording.comparison.side import Side

DIFFERS = 1


@dataclass(frozen=True)
class Parting:
    """The first tick in which two runs are in different states; None where a run was over by then."""

    tick: int
    time_s: float
    first: str | None
    second: str | None


@dataclass(frozen=True)
class Comparison:
    """Two recordings; they tell the same where they reach the same milestones in the same order, and the same end."""

    first: Side
    second: Side

    @property
    def milestones(self) -> tuple[dict[str, float], dict[str, float]]:
        """When each of them reached what, in its order; times in seconds."""
        return self.first.result.milestones, self.second.result.milestones

    @property
    def first_other_milestone(self) -> tuple[str | None, str | None] | None:
        """The first two that are not the same, None in place of one that was not reached; None where all are."""
        return next((pair for pair in zip_longest(*self.milestones) if pair[0] != pair[1]), None)

    @property
    def parting(self) -> Parting | None:
        """Where their states part; None where all are the same."""
        for one, other in zip_longest(self.first.recording.ticks, self.second.recording.ticks):
            first, second = _state(one), _state(other)
            if first != second:
                tick = one or other
                return Parting(tick.number, tick.time, first, second)
        return None

    @property
    def do_rooms_differ(self) -> bool:
        """Whether the two robots drove among other things, or the same elsewhere, as far as both worlds are known."""
        rooms = self.first.room, self.second.room
        return None not in rooms and rooms[0] != rooms[1]

    @property
    def is_alike(self) -> bool:
        return self.first_other_milestone is None and self.first.outcome == self.second.outcome

    @property
    def exit_status(self) -> int:
        return 0 if self.is_alike else DIFFERS

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON tells of it."""
        first, second = self.milestones
        return {
            "alike": self.is_alike,
            "first_other_milestone": self.first_other_milestone,
            "parting": asdict(self.parting) if self.parting else None,
            "rooms_differ": self.do_rooms_differ,
            "first": {**self.first.to_dict(), "milestones": first},
            "second": {**self.second.to_dict(), "milestones": second},
            "exit_status": self.exit_status,
        }


def _state(tick: Tick | None) -> str | None:
    return tick.state if tick else None
