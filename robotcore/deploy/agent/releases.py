"""Releases on the robot: their manifests, the results of their health checks, and the current release."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from robotcore.deploy.agent import files
from robotcore.deploy.agent.files import Layout

FORMAT = 1
"""The version of the manifest's format. `Release.from_json` refuses other versions."""

MANIFEST = "release.json"

PROJECT, SITE, ENVIRONMENT, WHEELS = "project", "site", "environment", "wheels"
"""The entries of a release's folder.

``project`` has the user's files. ``site`` has robotcore and the project's package. ``environment`` is a
link to the environment. ``wheels`` has the uploaded wheels until pip has installed them.
"""

NAME_PATTERN = re.compile(r"\d{4}-\d\d-\d\dT\d\d-\d\d-\d\dZ")
"""The pattern of a release's name: the time of its push in UTC. Names sort by age, and need no quotes in a shell."""

NAME_FORMAT = "%Y-%m-%dT%H-%M-%SZ"
"""The format of a release's name for strftime(3)."""

HEALTHY_WITHIN_S, SETTLE_S = 60.0, 4.0
"""The default time limit for an app's first tick, and the time that it must then keep running, in s.

A Raspberry Pi needs long to import NumPy and OpenCV, and its camera needs time to settle.
"""

DEFAULT_VIEW_PORT, MIN_VIEW_PORT, MAX_VIEW_PORT = 8080, 1024, 65535
"""The port of the robot's 127.0.0.1 for the live page, and its limits. Smaller ones need root."""

RESULT_FILE = "outcome.json"
HEALTHY, UNHEALTHY, STOPPED = "healthy", "unhealthy", "stopped"
"""The outcomes of a health check.

``HEALTHY``: the app kept running, or ended with success. ``UNHEALTHY``: the app failed. ``STOPPED``: a user stopped the
app during the check.
"""


@dataclass(frozen=True)
class Release:
    """The manifest of a release: its project, its requirements, and the commands that run and stop its app.

    >>> release = Release("2026-11-21T22-40-03Z", "mine", "search.py", "rover", "mock", ("run",), ("stop",))
    >>> Release.from_json(release.to_json()) == release
    True
    """

    name: str
    """The release's name: the time of its push in UTC, such as ``2026-11-21T22-40-03Z``."""
    project: str
    """The project's name."""
    app: str
    """The app's name, or its file relative to the project's folder."""
    robot: str
    """The robot's name, or its description file relative to the project's folder."""
    backend: str
    """The name of the backend."""
    run: tuple[str, ...]
    """The arguments of ``robotcore`` that run the app. File names in them are relative to the project's folder."""
    stop: tuple[str, ...]
    """The arguments of ``robotcore`` that stop the motors while no app runs."""
    requirements: tuple[str, ...] = ()
    """The requirements that pip installs, in pip's format."""
    checks: tuple[str, ...] = ()
    """A line for each check before the push, such as ``tests: 12 passed`` or ``tests: skipped``."""
    robotcore: str = ""
    """The version of robotcore in the release."""
    revision: str = ""
    """The project's commit in git."""
    sender: str = ""
    """The user and the computer of the push, as ``user@computer``."""
    is_recorded: bool = True
    """Whether the robot records each run of the app."""
    record_last: str = ""
    """The time before the end of a run that its recording keeps, such as ``10min``; empty for the whole run."""
    view_port: int | None = None
    """The port of the robot's 127.0.0.1 at which the app has its live page; None without a page."""

    def write(self, folder: Path) -> None:
        """Write the manifest into a release's folder."""
        folder.joinpath(MANIFEST).write_text(self.to_json() + "\n", encoding="utf-8")

    def to_fields(self) -> dict[str, Any]:
        """Return the fields of the manifest by their names in JSON."""
        return asdict(self)

    def to_json(self) -> str:
        """Return the manifest as JSON."""
        return json.dumps({"format": FORMAT, **self.to_fields()}, indent=2)

    @classmethod
    def read(cls, folder: Path) -> Release:
        """Return the release in a folder; raises OSError or ValueError if its manifest cannot be read."""
        return cls.from_json(folder.joinpath(MANIFEST).read_text(encoding="utf-8"))

    @classmethod
    def from_json(cls, text: str) -> Release:
        """Return the release of a manifest. Raises ValueError if the manifest is not valid."""
        try:
            manifest = dict(json.loads(text))
            if (number := manifest.pop("format")) == FORMAT:
                lists = {key: tuple(manifest[key]) for key in ("run", "stop", "requirements", "checks")}
                return cls(**{**manifest, **lists})
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"{MANIFEST} is damaged ({type(error).__name__}: {error}). Push again") from error
        raise ValueError(f"{MANIFEST} has the format {number!r}; this robotcore reads {FORMAT}")


def require_name(name: str) -> str:
    """Return the name of a release if it matches `NAME_PATTERN`, else raise ValueError.

    Call this function before you build a path from a name that the client sent.

    >>> require_name("2026-11-21T22-40-03Z")
    '2026-11-21T22-40-03Z'
    """
    if not NAME_PATTERN.fullmatch(name):
        raise ValueError(f"{name!r} is not the name of a release. Such a name is a time: 2026-11-21T22-40-03Z")
    return name


@dataclass(frozen=True)
class HealthResult:
    """The result of a health check."""

    outcome: str
    """`HEALTHY`, `UNHEALTHY` or `STOPPED`."""
    reason: str = ""
    """The cause of the outcome, in words."""
    lines: tuple[str, ...] = ()
    """The last lines of the app's output, if the app failed."""
    since: str = ""
    """The time in UTC at which the check began. It distinguishes several checks of a release."""

    def write(self, release: Path) -> None:
        """Write the result into a release's folder; raises OSError."""
        files.write_file(release / RESULT_FILE, json.dumps(asdict(self), indent=2) + "\n")

    @classmethod
    def read(cls, release: Path) -> HealthResult | None:
        """Return the result in a release's folder; None without a valid result."""
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
    """Make a release the current one atomically. With None, no release is current. Raises OSError."""
    if name is None:
        layout.current.unlink(missing_ok=True)
        files.sync_folder(layout.root)
    elif read_current(layout) != name:
        files.replace_link(layout.current, f"{layout.releases.name}/{name}")


def find_running_link() -> Path:
    """Return the path of the link to the folder of the running release, which a push changes after the current one.

    systemd creates the folder of the link when the service starts, and deletes it when the service ends.
    """
    return files.find_runtime_folder() / "robotcore" / "release"


def read_running() -> str | None:
    """Return the name of the running release; None if no release runs."""
    name = find_running_link().resolve().name
    return name if NAME_PATTERN.fullmatch(name) else None


def list_names(layout: Layout) -> list[str]:
    """Return the names of all releases, the newest first."""
    names = (folder.name for folder in layout.releases.glob("*"))
    return sorted(filter(NAME_PATTERN.fullmatch, names), reverse=True)


def find_previous(layout: Layout) -> str | None:
    """Return the name of the newest healthy release before the current one; None if there is no such release."""
    now = read_current(layout)
    older = [name for name in list_names(layout) if now is None or name < now]
    return next((name for name in older if read_outcome(layout, name) == HEALTHY), None)


def read_outcome(layout: Layout, name: str | None) -> str | None:
    """Return the outcome of a release's last health check; None without a release or a result."""
    result = HealthResult.read(layout.releases / name) if name else None
    return result.outcome if result else None
