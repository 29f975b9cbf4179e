"""Releases on the robot: their manifests, their health check's results, and which one is current."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path

from robotcore.deploy.agent import files
from robotcore.deploy.agent.files import Layout

FORMAT = 1
"""Of the file. What reads another one refuses it by its number."""

MANIFEST = "release.json"
PROJECT, SITE, ENVIRONMENT, WHEELS = "project", "site", "environment", "wheels"
"""In a release's folder: the user's files; robotcore and the project's own package; a link to its environment; what was
brought for pip, until it is installed."""

NAME_PATTERN = re.compile(r"\d{4}-\d\d-\d\dT\d\d-\d\d-\d\dZ")
"""When it was made, in UTC: names sort by age, and mean nothing to a shell."""

NAME_FORMAT = "%Y-%m-%dT%H-%M-%SZ"
"""A name, as strftime(3) writes it."""


@dataclass(frozen=True)
class Release:
    """What was put on the robot, and how it is run.

    ``run`` and ``stop`` are the arguments of robotcore that run the app, and that make the motors stand without it;
    both work in the project's folder. ``requirements`` are what pip installs for it. ``gates`` say, each in a line,
    what was proven before it was sent, or skipped.
    """

    name: str
    project: str
    app: str
    robot: str
    backend: str
    run: tuple[str, ...]
    stop: tuple[str, ...]
    requirements: tuple[str, ...] = ()
    gates: tuple[str, ...] = ()
    robotcore: str = ""
    revision: str = ""
    sender: str = ""
    is_recorded: bool = True

    def write(self, folder: Path) -> None:
        """Write it into a release's folder."""
        folder.joinpath(MANIFEST).write_text(self.to_json() + "\n", encoding="utf-8")

    def to_json(self) -> str:
        """Return it as JSON."""
        return json.dumps({"format": FORMAT, **asdict(self)}, indent=2)

    @classmethod
    def read(cls, folder: Path) -> Release:
        """Return the release in a folder; raises OSError or ValueError where there is none that can be read."""
        return cls.from_json(folder.joinpath(MANIFEST).read_text(encoding="utf-8"))

    @classmethod
    def from_json(cls, text: str) -> Release:
        """Return the release that JSON tells of; raises ValueError."""
        told = json.loads(text)
        number = told.pop("format", None) if isinstance(told, dict) else None
        if number != FORMAT:
            raise ValueError(f"{MANIFEST} has the format {number!r}; this robotcore reads {FORMAT}")
        for key in ("run", "stop", "requirements", "gates"):
            told[key] = tuple(told[key])
        return cls(**told)


def require_name(name: str) -> str:
    """Return a release's name; raises ValueError where it is none, so that no path is made of it."""
    if not NAME_PATTERN.fullmatch(name):
        raise ValueError(f"{name!r} is no release. Its name is a time, such as 2026-11-21T22-40-03Z")
    return name


RESULT_FILE = "verdict.json"
HEALTHY, UNHEALTHY, STOPPED = "healthy", "unhealthy", "stopped"
"""It lived, or ended with success; it did not; somebody stopped it before that was known."""


@dataclass(frozen=True)
class HealthResult:
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
        files.write_file(release / RESULT_FILE, json.dumps(asdict(self), indent=2) + "\n")

    @classmethod
    def read(cls, release: Path) -> HealthResult | None:
        """Return the verdict in a release's folder; None where there is none."""
        try:
            told = json.loads(release.joinpath(RESULT_FILE).read_text(encoding="utf-8"))
            return cls(**{**told, "lines": tuple(told["lines"])})
        except (OSError, ValueError, TypeError, KeyError):
            return None


def read_current(layout: Layout) -> str | None:
    """Return the name of the current release; None where none is, or where it is no longer there."""
    try:
        name = layout.current.readlink().name
    except OSError:
        return None
    return name if NAME_PATTERN.fullmatch(name) and (layout.releases / name).is_dir() else None


def set_current(layout: Layout, name: str | None) -> None:
    """Make a release the current one, or none, from one moment to the next; raises OSError."""
    if name is None:
        layout.current.unlink(missing_ok=True)
        files.sync_folder(layout.root)
    elif read_current(layout) != name:
        files.replace_link(layout.current, f"{layout.releases.name}/{name}")


def find_running_link() -> Path:
    """Return where a link to the release that runs is, as long as its service is not down; systemd makes the folder.

    It is not always the current one: a swap comes first, then the restart.
    """
    return files.find_runtime_folder() / "robotcore" / "release"


def read_running() -> str | None:
    """Return the name of the release that runs; None where none does."""
    name = find_running_link().resolve().name
    return name if NAME_PATTERN.fullmatch(name) else None


def list_names(layout: Layout) -> list[str]:
    """Return the names of all releases, the newest first."""
    return sorted(
        (folder.name for folder in layout.releases.glob("*") if NAME_PATTERN.fullmatch(folder.name)), reverse=True
    )


def find_previous(layout: Layout) -> str | None:
    """Return the last healthy release that is older than the current one; None where there is none."""
    now = read_current(layout)
    older = [name for name in list_names(layout) if now is None or name < now]
    return next((name for name in older if is_healthy(layout, name)), None)


def is_healthy(layout: Layout, name: str) -> bool:
    """Whether a release was, on its last trial."""
    verdict = HealthResult.read(layout.releases / name)
    return verdict is not None and verdict.is_healthy
