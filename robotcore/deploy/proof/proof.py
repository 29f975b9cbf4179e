"""What a gate says of a project, and the process that it asks."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.project import Project

Say = Callable[[str], object]
"""Is told in words what goes on."""


@dataclass(frozen=True)
class Proof:
    """What was proven, in a line, and what its reader should know besides."""

    said: str
    notes: tuple[str, ...] = ()


def ask(
    folder: Path | None, words: Sequence[str], environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run this Python with these arguments in a folder, with nothing to read; what it prints is returned.

    ``environment`` goes before that of this process.
    """
    return subprocess.run(  # noqa: S603  words, and no shell to take them for anything else
        [sys.executable, *words],
        cwd=folder,
        env={**os.environ, **(environment or {})},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="backslashreplace",
        check=False,
    )


def command_line(project: Project, line: str) -> str:
    """Return the line that repeats something in a shell, wherever that is."""
    is_here = project.folder is None or project.folder == Path.cwd().resolve()
    return line if is_here else f"cd {shlex.quote(str(project.folder))} && {line}"


def told_error(asked: subprocess.CompletedProcess[str]) -> str:
    """Return what a process said went wrong: without robotcore's ``error:`` before it."""
    return (asked.stderr.strip() or asked.stdout.strip() or f"exit status {asked.returncode}").removeprefix("error: ")
