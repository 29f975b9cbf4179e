"""How a release did on trial, kept in its folder."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from robotcore.deploy.agent.system import durable

FILE = "verdict.json"
HEALTHY, UNHEALTHY, STOPPED = "healthy", "unhealthy", "stopped"
"""It lived, or ended with success; it did not; somebody stopped it before that was known."""


@dataclass(frozen=True)
class Verdict:
    """What came out of a trial: the ``outcome``, why in a few words, and the last ``lines`` the app wrote.

    ``since`` is when the trial began: a release may be on trial more than once.
    """

    outcome: str
    reason: str = ""
    lines: tuple[str, ...] = ()
    since: str = ""

    @property
    def is_healthy(self) -> bool:
        return self.outcome == HEALTHY

    def write(self, release: Path) -> None:
        """Write it into a release's folder; raises OSError."""
        durable.write(release / FILE, json.dumps(asdict(self), indent=2) + "\n")

    @classmethod
    def read(cls, release: Path) -> Verdict | None:
        """Return the verdict in a release's folder; None where there is none."""
        try:
            told = json.loads(release.joinpath(FILE).read_text(encoding="utf-8"))
            return cls(**{**told, "lines": tuple(told["lines"])})
        except (OSError, ValueError, TypeError, KeyError):
            return None
