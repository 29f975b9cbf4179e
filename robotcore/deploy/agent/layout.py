"""Where things are on the robot, below the home of the user who was logged in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

FOLDER = "robotcore"
"""Below the home: no character of it means anything to a shell."""


@dataclass(frozen=True)
class Layout:
    """The rooms of a robot.

    ``current`` is a link to the release that runs; ``trial`` tells of one that has yet to prove itself. An environment
    is named by the digest of what is installed in it and the release it was made for, and shared by releases.
    ``program`` is this package as one file, which systemd starts.
    """

    home: Path

    @property
    def root(self) -> Path:
        return self.home / FOLDER

    @property
    def incoming(self) -> Path:
        return self.root / "incoming"

    @property
    def releases(self) -> Path:
        return self.root / "releases"

    @property
    def environments(self) -> Path:
        return self.root / "environments"

    @property
    def recordings(self) -> Path:
        return self.root / "recordings"

    @property
    def current(self) -> Path:
        return self.root / "current"

    @property
    def trial(self) -> Path:
        return self.root / "trial.json"

    @property
    def lock(self) -> Path:
        return self.root / "lock"

    @property
    def program(self) -> Path:
        return self.root / "aboard.pyz"

    @property
    def units(self) -> Path:
        return self.home / ".config" / "systemd" / "user"
