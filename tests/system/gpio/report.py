"""The report of the guest's checks, which is printed line by line."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass

STARTING = "the start of the guest"


@dataclass
class Report:
    """The results of the checks. It prints a line for each check as it is read."""

    running: str = STARTING
    """The name of the check that began last."""

    failures: int = 0
    """The number of failed checks."""

    has_ended: bool = False
    """Whether the guest reported its end."""

    @property
    def is_passed(self) -> bool:
        """Return whether every check ran and passed."""
        return self.has_ended and not self.failures

    def read(self, lines: Iterable[str]) -> None:
        """Read and print all lines of the guest. If the guest did not report its end, the last check has failed."""
        for line in lines:
            if line.startswith("{"):
                self._take(json.loads(line))
        if not self.has_ended:
            self._fail(self.running, "it crashed the guest, or hung until the guest's time limit")

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
