"""pip, in an environment of the robot's: its progress line by line, its failure with what to do."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent.environment.pipfailures import refusal_of
from robotcore.deploy.agent.telling import Say

_PROGRESS = re.compile(r"\s*(?:Collecting|Downloading|Using cached|Processing|Building|Installing|Successfully) ")
_BORROWED = re.compile(r"Requirement already satisfied: ([\w.-]+).*? in (/.*?)(?: \(|$)")
_SECRET = re.compile(r"(?<=://)[^/\s@]+@")
_LINES_KEPT = 400


@dataclass(frozen=True)
class Need:
    """What pip works with.

    ``wheels`` are those that were brought, where the robot is not to ask the network; ``site`` is what is there
    already, beside the environment; ``handles`` stay open for as long as pip works.
    """

    wheels: Path | None = None
    site: Path | None = None
    handles: tuple[int, ...] = ()


def install(environment: Path, requirements: Sequence[str], need: Need, tell: Say) -> set[str]:
    """Install requirements; return the names of those that the system has already. Raises RefusalError."""
    lines: deque[str] = deque(maxlen=_LINES_KEPT)
    borrowed: set[str] = set()
    with _started(environment, requirements, need) as running:
        assert running.stdout
        for told in running.stdout:
            line = _SECRET.sub("****@", told.rstrip("\n"))
            lines.append(line)
            if _PROGRESS.match(line):
                tell(line.strip())
            elif (had := _BORROWED.match(line)) and not _is_ours(Path(had[2]), environment, need.site):
                borrowed.add(had[1])
    if running.returncode:
        raise refusal_of(lines, is_offline=need.wheels is not None)
    return borrowed


class _Running(subprocess.Popen[str]):
    """A command that ends, with all that it started, when nobody waits for it any more."""

    def __exit__(self, *raised: object) -> None:
        if any(raised):
            with suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)
        super().__exit__(*raised)  # type: ignore[arg-type]


def _started(environment: Path, requirements: Sequence[str], need: Need) -> _Running:
    """Start pip where no module of the user's lies in the way, in a group of its own, asking nobody anything."""
    ours = {"LC_ALL": "C.UTF-8", "PYTHONNOUSERSITE": "1", "PYTHONPATH": str(need.site or "")}
    return _Running(
        [str(environment / "bin/python"), "-m", "pip", "install", *_options(need), "--", *requirements],
        cwd=environment,
        env={**os.environ, **ours},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        pass_fds=need.handles,
        start_new_session=True,
    )


def _options(need: Need) -> list[str]:
    options = ["--no-input", "--disable-pip-version-check", "--progress-bar=off", "--prefer-binary", "--retries=2"]
    return [*options, "--no-index", f"--find-links={need.wheels}"] if need.wheels else options


def _is_ours(place: Path, *folders: Path | None) -> bool:
    return any(folder and place.is_relative_to(folder) for folder in folders)
