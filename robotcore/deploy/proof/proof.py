"""What a gate says of a project, and the process that it asks."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.project import Project
from robotcore.hal.wall_clock import MonotonicClock

Say = Callable[[str], object]
"""Is told in words what goes on."""

LOOK_S = 0.5
"""So often somebody looks how far a process is."""


@dataclass(frozen=True)
class Proof:
    """What was proven, in a line, and what its reader should know besides."""

    said: str
    notes: tuple[str, ...] = ()


def ask(
    folder: Path | None,
    words: Sequence[str],
    environment: Mapping[str, str] | None = None,
    *,
    limit_s: float,
    look: Callable[[], object] = lambda: None,
) -> subprocess.CompletedProcess[str]:
    """Run this Python with these arguments in a folder, with nothing to read; what it prints is returned.

    ``environment`` goes before that of this process; ``look`` is called again and again meanwhile. Raises TimeoutError
    where it takes longer than ``limit_s``; then, or whatever else is raised, it is ended.
    """
    clock = MonotonicClock()
    with subprocess.Popen(  # noqa: S603  words, and no shell to take them for anything else
        [sys.executable, *words],
        cwd=folder,
        env={**os.environ, **(environment or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="backslashreplace",
    ) as process:
        try:
            while clock.now() < limit_s:
                with suppress(subprocess.TimeoutExpired):
                    out, err = process.communicate(timeout=min(LOOK_S, limit_s))
                    return subprocess.CompletedProcess(process.args, process.returncode, out, err)
                look()
        except BaseException:
            process.kill()
            raise
        process.kill()
    raise TimeoutError(f"no end within {limit_s:g} s")


def command_line(project: Project, line: str) -> str:
    """Return the line that repeats something in a shell, wherever that is."""
    is_here = project.folder is None or project.folder == Path.cwd().resolve()
    return line if is_here else f"cd {shlex.quote(str(project.folder))} && {line}"


def told_error(asked: subprocess.CompletedProcess[str]) -> str:
    """Return what a process said went wrong: without robotcore's ``error:`` before it."""
    return (asked.stderr.strip() or asked.stdout.strip() or f"exit status {asked.returncode}").removeprefix("error: ")
