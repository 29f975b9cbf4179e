"""What the workers of a cluster are given: the user's own files, and by which robotcore they are to be run."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from robotcore.appfile import is_app_file
from robotcore.errors import RobotcoreError
from robotcore.sweep.fingerprint import code_digest
from robotcore.sweep.ownfiles import is_own, own_files
from robotcore.sweep.spec import Sweep


@dataclass(frozen=True)
class Kit:
    """The own files of a sweep by their absolute paths, ``home`` being where relative names begin."""

    app: str
    backends: tuple[str, ...]
    version: str
    code: str
    home: Path
    files: Mapping[Path, bytes]

    @classmethod
    def of(cls, sweep: Sweep) -> Kit:
        """Return the kit of a sweep that was checked."""
        app, backends = sweep.request.app, sweep.backends
        return cls(app, backends, version("robotcore"), code_digest(app, backends), Path.cwd(), own_files(sweep))

    def mismatch(self) -> str | None:
        """Return why this process cannot run what the kit is for; None where it can."""
        here = version("robotcore")
        if here != self.version:
            return f"it has robotcore {here}, here is {self.version}. Install the same, and start it again"
        try:
            code = code_digest(self.app, self.backends)
        except RobotcoreError as error:
            return str(error)
        if code != self.code:
            return "its robotcore, drivers or apps are not those that are here. Install the same, and start it again"
        return None

    @property
    def digest(self) -> str:
        """A digest of the files and their places."""
        total = hashlib.sha256()
        for file, content in sorted(self.files.items()):
            total.update(b"%b %b" % (os.fsencode(file), hashlib.sha256(content).digest()))
        return total.hexdigest()

    def unpack(self, root: Path) -> None:
        """Write the files below ``root``; those of one folder stay beside each other."""
        for file, content in self.files.items():
            place = root / _place(file)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)

    def app_in(self, root: Path, name: str) -> str:
        """Return an app's name where the files are unpacked below ``root``."""
        return str(root / _place(self.home / name)) if is_app_file(name) else name

    def description_in(self, root: Path, name: str) -> str:
        """Return a robot's or a world's name where the files are unpacked below ``root``."""
        return str(root / _place(self.home / name)) if is_own(name) else name


def _place(file: Path) -> Path:
    """Return a relative place for an absolute one; no ``..`` in it leads anywhere else."""
    folder = hashlib.sha256(os.fsencode(file.parent)).hexdigest()[:16]
    return Path(folder, file.name)
