"""Releases on the robot: their manifests, their health check's results, and which one is current."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path

from robotcore.deploy.agent import files
from robotcore.deploy.agent.files import Layout

FORMAT = 1
"""The format of the manifest. A reader refuses another number."""

MANIFEST = "release.json"
PROJECT, SITE, ENVIRONMENT, WHEELS = "project", "site", "environment", "wheels"
"""In a release's folder: the user's files, robotcore and the project's package, a link to its environment, and uploaded
wheels until they are installed."""

NAME_PATTERN = re.compile(r"\d{4}-\d\d-\d\dT\d\d-\d\d-\d\dZ")
"""A release's name is the time of its push in UTC. Names sort by age, and need no quotes in a shell."""

NAME_FORMAT = "%Y-%m-%dT%H-%M-%SZ"
"""A release's name as a format of strftime(3)."""

RESULT_FILE = "verdict.json"
HEALTHY, UNHEALTHY, STOPPED = "healthy", "unhealthy", "stopped"
"""Outcomes: the app kept running or ended with success; it failed; a user stopped it during the check."""


@dataclass(frozen=True)
class Release:
    """The manifest of a release: its origin, and the commands that run and stop it.

    >>> release = Release("2026-11-21T22-40-03Z", "mine", "search.py", "rover", "mock", ("run",), ("stop",))
    >>> Release.from_json(release.to_json()) == release
    True
    """

    name: str
    """The time of the push; see `NAME_PATTERN`."""
    project: str
    """The project's name."""
    app: str
    """The app's file or name, as the project states it."""
    robot: str
    """The robot's description file."""
    backend: str
    """The name of the backend."""
    run: tuple[str, ...]
    """robotcore's arguments that run the app, in the project's folder."""
    stop: tuple[str, ...]
    """robotcore's arguments that stop the motors without the app, in the project's folder."""
    requirements: tuple[str, ...] = ()
    """The requirements that pip installs."""
    gates: tuple[str, ...] = ()
    """A line for each check before the push: its result, or that it was skipped."""
    robotcore: str = ""
    """robotcore's version."""
    revision: str = ""
    """The project's revision in git."""
    sender: str = ""
    """The user and the machine that pushed it."""
    is_recorded: bool = True
    """Whether each run is recorded."""

    def write(self, folder: Path) -> None:
        """Write the manifest into a release's folder."""
        folder.joinpath(MANIFEST).write_text(self.to_json() + "\n", encoding="utf-8")

    def to_json(self) -> str:
        """Return the manifest as JSON."""
        return json.dumps({"format": FORMAT, **asdict(self)}, indent=2)

    @classmethod
    def read(cls, folder: Path) -> Release:
        """Return the release in a folder; raises OSError or ValueError if its manifest cannot be read."""
        return cls.from_json(folder.joinpath(MANIFEST).read_text(encoding="utf-8"))

    @classmethod
    def from_json(cls, text: str) -> Release:
        """Return the release of a manifest; raises ValueError."""
        manifest = json.loads(text)
        number = manifest.pop("format", None) if isinstance(manifest, dict) else None
        if number != FORMAT:
            raise ValueError(f"{MANIFEST} has the format {number!r}; this robotcore reads {FORMAT}")
        for key in ("run", "stop", "requirements", "gates"):
            manifest[key] = tuple(manifest[key])
        return cls(**manifest)


def require_name(name: str) -> str:
    """Return a release's name if it is valid, and raise ValueError otherwise. Call it before a path is built.

    >>> require_name("2026-11-21T22-40-03Z")
    '2026-11-21T22-40-03Z'
    """
    if not NAME_PATTERN.fullmatch(name):
        raise ValueError(f"{name!r} is no release. Its name is a time, such as 2026-11-21T22-40-03Z")
    return name


@dataclass(frozen=True)
class HealthResult:
    """The result of a health check."""

    outcome: str
    """`HEALTHY`, `UNHEALTHY` or `STOPPED`."""
    reason: str = ""
    """Why, in a few words."""
    lines: tuple[str, ...] = ()
    """The last lines of the app's output, if it failed."""
    since: str = ""
    """When the check began, in UTC. A release may be checked more than once."""

    @property
    def is_healthy(self) -> bool:
        return self.outcome == HEALTHY

    def write(self, release: Path) -> None:
        """Write the result into a release's folder; raises OSError."""
        files.write_file(release / RESULT_FILE, json.dumps(asdict(self), indent=2) + "\n")

    @classmethod
    def read(cls, release: Path) -> HealthResult | None:
        """Return the result in a release's folder; None if there is none."""
        try:
            result = json.loads(release.joinpath(RESULT_FILE).read_text(encoding="utf-8"))
            return cls(**{**result, "lines": tuple(result["lines"])})
        except (OSError, ValueError, TypeError, KeyError):
            return None


def read_current(layout: Layout) -> str | None:
    """Return the name of the current release; None if there is none, or if its folder is gone."""
    try:
        name = layout.current.readlink().name
    except OSError:
        return None
    return name if NAME_PATTERN.fullmatch(name) and (layout.releases / name).is_dir() else None


def set_current(layout: Layout, name: str | None) -> None:
    """Make a release the current one atomically, or none; raises OSError."""
    if name is None:
        layout.current.unlink(missing_ok=True)
        files.sync_folder(layout.root)
    elif read_current(layout) != name:
        files.replace_link(layout.current, f"{layout.releases.name}/{name}")


def find_running_link() -> Path:
    """Return the path of the link to the running release. systemd makes its folder, and deletes it with the service.

    The running release may differ from the current one: the current one changes before the restart.
    """
    return files.find_runtime_folder() / "robotcore" / "release"


def read_running() -> str | None:
    """Return the name of the running release; None if none runs."""
    name = find_running_link().resolve().name
    return name if NAME_PATTERN.fullmatch(name) else None


def list_names(layout: Layout) -> list[str]:
    """Return the names of all releases, the newest first."""
    return sorted(
        (folder.name for folder in layout.releases.glob("*") if NAME_PATTERN.fullmatch(folder.name)), reverse=True
    )


def find_previous(layout: Layout) -> str | None:
    """Return the last healthy release that is older than the current one; None if there is none."""
    now = read_current(layout)
    older = [name for name in list_names(layout) if now is None or name < now]
    return next((name for name in older if is_healthy(layout, name)), None)


def is_healthy(layout: Layout, name: str) -> bool:
    """Return whether the last health check of a release found it healthy."""
    result = HealthResult.read(layout.releases / name)
    return result is not None and result.is_healthy
