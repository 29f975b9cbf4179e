"""How a replay came out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robotcore.errors import Interrupted
from robotcore.recording import Recording
from robotcore.recording.replay.deviation import Deviation
from robotcore.recording.replay.ending import ended_from_outside
from robotcore.runtime.outcome import RunResult

DIFFERS = 1


@dataclass(frozen=True)
class Replayed:
    """An app held to its recording: so many of its ``ticks`` were equal, to the bit where ``is_exact``.

    ``largest_difference`` of a command, in rad/s, is what was let pass because the ``platform`` is another one.
    ``has_app_changed`` tells whether the app's own file is another one now; None where it is no file of a user's.
    """

    recording: Recording
    result: RunResult
    ticks: int
    deviation: Deviation | None
    is_exact: bool
    largest_difference: float
    trace_sha256: str
    platform: tuple[str, ...] = ()
    has_app_changed: bool | None = None

    @property
    def ended_by(self) -> str:
        """What ended the recording from outside, a signal, a cut; the replay then ends there too. Empty if nothing."""
        return ended_from_outside(self.recording)

    @property
    def states(self) -> list[str]:
        """The state of each tick that was equal."""
        return [tick.state for tick in self.recording.ticks[: self.ticks]]

    @property
    def recorded_sha256(self) -> str | None:
        """The digest in the file; None where the run ended in the middle of a tick, or unseen."""
        told = self.recording.result
        return told.trace_sha256 if told and self.ticks == told.ticks else None

    @property
    def is_equal(self) -> bool:
        """Whether nothing differs: neither a decision nor, where all are equal to the bit, the digest."""
        is_comparable = self.is_exact and self.recorded_sha256 is not None
        return self.deviation is None and not (is_comparable and self.recorded_sha256 != self.trace_sha256)

    @property
    def exit_status(self) -> int:
        """0 where all is equal; 1 where something differs."""
        if isinstance(self.result.error, Interrupted):
            return self.result.exit_status
        return 0 if self.is_equal else DIFFERS

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON tells of it."""
        return {
            "app": self.result.app,
            "equal": self.is_equal,
            "bit_equal": self.is_equal and self.is_exact,
            "ticks": self.ticks,
            "recorded_ticks": len(self.recording.ticks),
            "largest_difference_rad_s": self.largest_difference,
            "trace_sha256": self.trace_sha256,
            "recorded_sha256": self.recorded_sha256,
            "ended_by": self.ended_by or None,
            "platform": list(self.platform),
            "app_changed": self.has_app_changed,
            "deviation": self.deviation.to_dict() if self.deviation else None,
            "exit_status": self.exit_status,
        }
