"""Environments: what pip installed, each for the releases that need just that."""

from __future__ import annotations

import errno
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib import metadata
from pathlib import Path

from robotcore.deploy.agent.environment import pip
from robotcore.deploy.agent.environment.pipfailures import refusal_of
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.incoming import erase, throw_away
from robotcore.deploy.agent.releases.release import ENVIRONMENT
from robotcore.deploy.agent.system import durable
from robotcore.deploy.agent.system.disk import free_bytes
from robotcore.deploy.agent.telling import RefusalError, Say

WHOLE = "whole.json"
"""In an environment's folder: what it was made of; written last, so that a half has none."""

LEAST_BYTES = 30_000_000
"""What an environment with nothing but pip in it takes."""


@dataclass(frozen=True)
class Recipe:
    """What an environment is made of: requirements as pip takes them, and the Python they are installed for."""

    requirements: tuple[str, ...]
    python: str

    @classmethod
    def of(cls, requirements: Iterable[str]) -> Recipe:
        """Return the recipe of an environment of this Python, on this machine."""
        told = sorted({" ".join(requirement.split()) for requirement in requirements})
        return cls(tuple(told), f"{sys.implementation.cache_tag} {platform.machine()}")

    @property
    def digest(self) -> str:
        """Name it, by all that it is."""
        return sha256(json.dumps(asdict(self)).encode()).hexdigest()[:12]


def find(layout: Layout, recipe: Recipe) -> Path | None:
    """Return the environment made by a recipe that still is what it was; nothing where there is none.

    One leans on the system's own packages, such as apt's picamera2: with another version of these it is another.
    """
    made = sorted(layout.environments.glob(f"{recipe.digest}-*"), reverse=True)
    return next((folder for folder in made if _is_as_made(folder, recipe)), None)


def make(layout: Layout, recipe: Recipe, release: str, need: pip.Need, tell: Say) -> Path:
    """Return a new environment for a release; raises RefusalError, and then there is nothing of it.

    Its name is its own: the one that it replaces may be running. Halves that somebody was killed over are thrown away.
    The caller holds the lock.
    """
    folder = layout.environments / f"{recipe.digest}-{release}"
    layout.environments.mkdir(parents=True, exist_ok=True)
    for half in [path for path in layout.environments.iterdir() if not path.joinpath(WHOLE).exists()]:
        erase(half)
    try:
        _create(folder, with_pip=bool(recipe.requirements))
        borrowed = pip.install(folder, recipe.requirements, need, tell) if recipe.requirements else ()
        os.sync()
        leans_on = {name: _version(name) for name in sorted(borrowed)}
        durable.write(folder / WHOLE, json.dumps({**asdict(recipe), "leans_on": leans_on}, indent=2) + "\n")
    except BaseException:
        erase(folder)
        raise
    return folder


def unused(layout: Layout) -> Iterator[Path]:
    """Yield environments that no release has a link to, halves among them. The caller holds the lock."""
    folders = [*layout.releases.glob("*"), *layout.incoming.glob("*")]
    used = {link.readlink().name for folder in folders if (link := folder / ENVIRONMENT).is_symlink()}
    yield from (folder for folder in layout.environments.glob("*") if folder.name not in used)


def discard_unused(layout: Layout) -> None:
    """Throw away environments that no release needs."""
    for folder in list(unused(layout)):
        throw_away(layout, folder)


def _create(folder: Path, *, with_pip: bool) -> None:
    command = [sys.executable, "-I", "-m", "venv", "--system-site-packages", *([] if with_pip else ["--without-pip"])]
    made = subprocess.run([*command, folder], capture_output=True, text=True, check=False)  # noqa: S603  our own Python
    if made.returncode == 0:
        return
    told = made.stdout + made.stderr
    if "ensurepip is not" in told:
        raise RefusalError("python3-venv is missing on the robot", "There: sudo apt install python3-venv", "venv")
    if free_bytes(folder) < LEAST_BYTES:  # venv does not tell what its pip failed of
        told = os.strerror(errno.ENOSPC)
    raise refusal_of(told.splitlines(), is_offline=False)


def _is_as_made(folder: Path, recipe: Recipe) -> bool:
    try:
        told = json.loads(folder.joinpath(WHOLE).read_text(encoding="utf-8"))
        made_by, leans_on = Recipe(tuple(told["requirements"]), told["python"]), dict(told["leans_on"])
    except (OSError, ValueError, TypeError, KeyError):
        return False
    is_unchanged = all(_version(name) == version for name, version in leans_on.items())
    return made_by == recipe and is_unchanged and folder.joinpath("bin", "python").exists()


def _version(distribution: str) -> str | None:
    """Return the version of what is installed for the system, outside of every environment."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None
