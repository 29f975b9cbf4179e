"""Which of a project's files are sent: those that git knows or would, without git all but what programs leave."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.staging.secret import is_secret
from robotcore.errors import UsageError
from robotcore.text import escape

LEFT_BY_PROGRAMS = re.compile(
    r"""\.git|\.hg|\.svn|\.jj|__pycache__|\.venv|venv|\.tox|\.nox|node_modules|\.[a-z]+_cache|\.hypothesis|\.idea|\.vscode
    |\.ipynb_checkpoints|\.DS_Store|\.coverage|.*\.egg-info|.*\.py[co]|.*\.mcap|.+~|\.\#.*|.*\.sw[po]""",
    re.VERBOSE | re.DOTALL,
)
"""What editors, Python and its tools, version control and robots leave, by name; it is sent where git tracks it."""

RESULTS = ("sweeps", "recordings", "dist", "build")
"""Folders of a project's own that robotcore and builds make, at its top."""

ENVIRONMENT = "pyvenv.cfg"
"""A folder that has it is a virtual environment, whatever it is called."""

_GIT_VARIABLES = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX")
"""What git tells its hooks, of another folder perhaps."""


@dataclass(frozen=True)
class Listing:
    """The files and links of a folder that are sent, by their names relative to it; and the secrets that are not."""

    names: tuple[str, ...]
    secrets: tuple[str, ...] = ()


def listed(folder: Path) -> Listing:
    """Return what is sent of a folder, in order. What git ignores is not, and no secret is, tracked or not.

    Raises UsageError where a folder in it cannot be read.
    """
    try:
        of_git = _git(folder)
        found = sorted(set(_walked(folder, folder) if of_git is None else of_git))
    except OSError as error:
        raise UsageError(f"{escape(str(error.filename))}: {error.strerror}. Let it be read, or move it away") from error
    secrets = {name for name in found if is_secret(folder, name)}
    return Listing(tuple(name for name in found if name not in secrets), tuple(sorted(secrets)))


def _git(folder: Path) -> list[str] | None:
    """Return what git lists; None where the folder is in no work tree, or ignored as a whole."""
    tracked = _ls_files(folder, "--cached")
    others = _ls_files(folder, "--others", "--exclude-standard")
    if tracked is None or others is None:
        return None
    environments = {Path(name).parent for name in others if Path(name).name == ENVIRONMENT}
    others = [name for name in others if not _is_left(name) and environments.isdisjoint(Path(name).parents)]
    return list(_files_of(folder, [*tracked, *others])) or None


def _ls_files(folder: Path, *which: str) -> list[str] | None:
    if (git := shutil.which("git")) is None:
        return None
    answer = subprocess.run(  # noqa: S603  words of our own, and no shell
        [git, "ls-files", "-z", *which],
        cwd=folder,
        env=git_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    return None if answer.returncode else [os.fsdecode(name) for name in answer.stdout.split(b"\0") if name]


def git_environment() -> dict[str, str]:
    """Return the environment for a git that looks at the folder it works in, whichever hook this process runs in."""
    return {name: value for name, value in os.environ.items() if name not in _GIT_VARIABLES}


def _files_of(folder: Path, names: Iterable[str]) -> Iterator[str]:
    """Yield the files that are there; a folder stands for a repository in this one, and has its own list."""
    for name in names:
        path = folder / name
        if path.is_dir() and not path.is_symlink():
            inner = _git(path)
            yield from _walked(folder, path) if inner is None else (str(Path(name, each)) for each in inner)
        elif os.path.lexists(path):
            yield name


def _walked(folder: Path, below: Path) -> Iterator[str]:
    """Yield the files and links below, by their names from ``folder`` on, without what programs leave."""
    for path in below.iterdir():
        name = str(path.relative_to(folder))
        if _is_left(name):
            continue
        if path.is_symlink() or not path.is_dir():
            yield name
        elif not (path / ENVIRONMENT).exists():
            yield from _walked(folder, path)


def _is_left(name: str) -> bool:
    """Return whether a program has left it, or the folder that it is in."""
    parts = Path(name).parts
    return parts[0] in RESULTS or any(map(LEFT_BY_PROGRAMS.fullmatch, parts))
