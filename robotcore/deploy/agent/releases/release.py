"""A release as its folder tells of it."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass
from pathlib import Path

FORMAT = 1
"""Of the file. What reads another one refuses it by its number."""

MANIFEST = "release.json"
PROJECT, SITE, ENVIRONMENT, WHEELS = "project", "site", "environment", "wheels"
"""In a release's folder: the user's files; robotcore and the project's own package; a link to its environment; what was
brought for pip, until it is installed."""

NAME = re.compile(r"\d{4}-\d\d-\d\dT\d\d-\d\d-\d\dZ")
"""When it was made, in UTC: names sort by age, and mean nothing to a shell."""

TIME = "%Y-%m-%dT%H-%M-%SZ"
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
    if not NAME.fullmatch(name):
        raise ValueError(f"{name!r} is no release. Its name is a time, such as 2026-11-21T22-40-03Z")
    return name
