"""Virtual environments on the robot: pip fills one, and releases with the same requirements share it."""

from __future__ import annotations

import errno
import json
import os
import platform
import re
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib import metadata
from pathlib import Path

from robotcore.deploy.agent import files
from robotcore.deploy.agent.files import Layout, measure_free_space
from robotcore.deploy.agent.pip_errors import explain_failure
from robotcore.deploy.agent.releases import ENVIRONMENT
from robotcore.deploy.agent.rpc import AgentError, ReportProgress
from robotcore.deploy.agent.uploads import delete, discard

COMPLETE_FILE = "whole.json"
"""In an environment's folder: what it was made of; written last, so that a half has none."""

_EMPTY_BYTES = 30_000_000
"""What an environment with nothing but pip in it takes."""


@dataclass(frozen=True)
class EnvironmentSpec:
    """What an environment is made of: requirements as pip takes them, and the Python they are installed for."""

    requirements: tuple[str, ...]
    python: str

    @classmethod
    def of(cls, requirements: Iterable[str]) -> EnvironmentSpec:
        """Return the recipe of an environment of this Python, on this machine."""
        told = sorted({" ".join(requirement.split()) for requirement in requirements})
        return cls(tuple(told), f"{sys.implementation.cache_tag} {platform.machine()}")

    @property
    def digest(self) -> str:
        """Name it, by all that it is."""
        return sha256(json.dumps(asdict(self)).encode()).hexdigest()[:12]


def find_environment(layout: Layout, recipe: EnvironmentSpec) -> Path | None:
    """Return the environment made by a recipe that still is what it was; nothing where there is none.

    One leans on the system's own packages, such as apt's picamera2: with another version of these it is another.
    """
    made = sorted(layout.environments.glob(f"{recipe.digest}-*"), reverse=True)
    return next((folder for folder in made if _is_unchanged(folder, recipe)), None)


def make_environment(
    layout: Layout, recipe: EnvironmentSpec, release: str, need: PipInputs, tell: ReportProgress
) -> Path:
    """Return a new environment for a release; raises RefusalError, and then there is nothing of it.

    Its name is its own: the one that it replaces may be running. Halves that somebody was killed over are thrown away.
    The caller holds the lock.
    """
    folder = layout.environments / f"{recipe.digest}-{release}"
    layout.environments.mkdir(parents=True, exist_ok=True)
    for half in [path for path in layout.environments.iterdir() if not path.joinpath(COMPLETE_FILE).exists()]:
        delete(half)
    try:
        _create_venv(folder, with_pip=bool(recipe.requirements))
        borrowed = install_requirements(folder, recipe.requirements, need, tell) if recipe.requirements else ()
        os.sync()
        leans_on = {name: _read_system_version(name) for name in sorted(borrowed)}
        files.write_file(folder / COMPLETE_FILE, json.dumps({**asdict(recipe), "leans_on": leans_on}, indent=2) + "\n")
    except BaseException:
        delete(folder)
        raise
    return folder


def list_unused(layout: Layout) -> Iterator[Path]:
    """Yield environments that no release has a link to, halves among them. The caller holds the lock."""
    folders = [*layout.releases.glob("*"), *layout.incoming.glob("*")]
    used = {link.readlink().name for folder in folders if (link := folder / ENVIRONMENT).is_symlink()}
    yield from (folder for folder in layout.environments.glob("*") if folder.name not in used)


def discard_unused(layout: Layout) -> None:
    """Throw away environments that no release needs."""
    for folder in list(list_unused(layout)):
        discard(layout, folder)


def _create_venv(folder: Path, *, with_pip: bool) -> None:
    command = [sys.executable, "-I", "-m", "venv", "--system-site-packages", *([] if with_pip else ["--without-pip"])]
    made = subprocess.run([*command, folder], capture_output=True, text=True, check=False)  # noqa: S603  our own Python
    if made.returncode == 0:
        return
    told = made.stdout + made.stderr
    if "ensurepip is not" in told:
        raise AgentError("python3-venv is missing on the robot", "There: sudo apt install python3-venv", "venv")
    if measure_free_space(folder) < _EMPTY_BYTES:  # venv does not tell what its pip failed of
        told = os.strerror(errno.ENOSPC)
    raise explain_failure(told.splitlines(), is_offline=False)


def _is_unchanged(folder: Path, recipe: EnvironmentSpec) -> bool:
    try:
        told = json.loads(folder.joinpath(COMPLETE_FILE).read_text(encoding="utf-8"))
        made_by, leans_on = EnvironmentSpec(tuple(told["requirements"]), told["python"]), dict(told["leans_on"])
    except (OSError, ValueError, TypeError, KeyError):
        return False
    is_unchanged = all(_read_system_version(name) == version for name, version in leans_on.items())
    return made_by == recipe and is_unchanged and folder.joinpath("bin", "python").exists()


def _read_system_version(distribution: str) -> str | None:
    """Return the version of what is installed for the system, outside of every environment."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


_PROGRESS = re.compile(r"\s*(?:Collecting|Downloading|Using cached|Processing|Building|Installing|Successfully) ")
_SYSTEM_PACKAGE = re.compile(r"Requirement already satisfied: ([\w.-]+).*? in (/.*?)(?: \(|$)")
_SECRET = re.compile(r"(?<=://)[^/\s@]+@")
_KEPT_LINES = 400


@dataclass(frozen=True)
class PipInputs:
    """What pip works with.

    ``wheels`` are those that were brought, where the robot is not to ask the network; ``site`` is what is there
    already, beside the environment; ``handles`` stay open for as long as pip works.
    """

    wheels: Path | None = None
    site: Path | None = None
    handles: tuple[int, ...] = ()


def install_requirements(
    environment: Path, requirements: Sequence[str], need: PipInputs, tell: ReportProgress
) -> set[str]:
    """Install requirements; return the names of those that the system has already. Raises RefusalError."""
    lines: deque[str] = deque(maxlen=_KEPT_LINES)
    borrowed: set[str] = set()
    with _start_pip(environment, requirements, need) as running:
        assert running.stdout
        for told in running.stdout:
            line = _SECRET.sub("****@", told.rstrip("\n"))
            lines.append(line)
            if _PROGRESS.match(line):
                tell(line.strip())
            elif (had := _SYSTEM_PACKAGE.match(line)) and not _is_below(Path(had[2]), environment, need.site):
                borrowed.add(had[1])
    if running.returncode:
        raise explain_failure(lines, is_offline=need.wheels is not None)
    return borrowed


class _PipProcess(subprocess.Popen[str]):
    """A command that ends, with all that it started, when nobody waits for it any more."""

    def __exit__(self, *raised: object) -> None:
        if any(raised):
            with suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)
        super().__exit__(*raised)  # type: ignore[arg-type]


def _start_pip(environment: Path, requirements: Sequence[str], need: PipInputs) -> _PipProcess:
    """Start pip where no module of the user's lies in the way, in a group of its own, asking nobody anything."""
    ours = {"LC_ALL": "C.UTF-8", "PYTHONNOUSERSITE": "1", "PYTHONPATH": str(need.site or "")}
    return _PipProcess(
        [str(environment / "bin/python"), "-m", "pip", "install", *_build_options(need), "--", *requirements],
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


def _build_options(need: PipInputs) -> list[str]:
    options = ["--no-input", "--disable-pip-version-check", "--progress-bar=off", "--prefer-binary", "--retries=2"]
    return [*options, "--no-index", f"--find-links={need.wheels}"] if need.wheels else options


def _is_below(place: Path, *folders: Path | None) -> bool:
    return any(folder and place.is_relative_to(folder) for folder in folders)
