"""What the guest tells of its checks, line by line, and what comes of them all."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass

STARTING = "the start of the guest"


@dataclass
class Report:
    """Prints a line a check, as it comes."""

    running: str = STARTING
    """The check that was begun last."""
    failures: int = 0
    has_ended: bool = False
    """Whether the guest said that it has no more checks."""

    @property
    def is_passed(self) -> bool:
        """Whether every check was run, and passed."""
        return self.has_ended and not self.failures

    def hear(self, lines: Iterable[str]) -> None:
        """Take in all that the guest tells; a check that it never came back from is the last one told."""
        for line in lines:
            if line.startswith("{"):
                self._take(json.loads(line))
        if not self.has_ended:
            self._fail(self.running, "it took the guest down, or has hung until the guest's time was up")

    def _take(self, event: dict[str, str]) -> None:
        match event:
            case {"begun": check}:
                self.running = check
            case {"passed": check}:
                print(f"ok      {check}", flush=True)
            case {"skipped": check, "why": why}:
                print(f"not run {check}: {why}", flush=True)
            case {"failed": check, "why": why}:
                self._fail(check, why)
            case {"ended": _}:
                self.has_ended = True

    def _fail(self, check: str, why: str) -> None:
        self.failures += 1
        indented = "\n".join(f"          {line}" for line in why.splitlines())
        print(f"not ok  {check}\n{indented}", flush=True)
