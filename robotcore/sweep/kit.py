"""What the workers of a cluster are given: the user's own files, and by what they are to be run."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.description import is_own
from robotcore.errors import RobotcoreError
from robotcore.runtime.apps import is_app_file
from robotcore.runtime.versions import PYTHON, libraries
from robotcore.sweep.fingerprint import code_digest
from robotcore.sweep.ownfiles import own_files
from robotcore.sweep.spec import Sweep


@dataclass(frozen=True)
class Kit:
    """The own files of a sweep by their absolute paths, ``home`` being where relative names begin."""

    apps: tuple[str, ...]
    backends: tuple[str, ...]
    faults: tuple[str, ...]
    versions: Mapping[str, str]
    code: str
    home: Path
    files: Mapping[Path, bytes]

    @classmethod
    def of(cls, sweep: Sweep) -> Kit:
        """Return the kit of a sweep that was checked."""
        named = sweep.apps, sweep.backends, sweep.request.faults
        return cls(*named, _versions(sweep.backends), code_digest(*named), Path.cwd(), own_files(sweep))

    def mismatch(self) -> str | None:
        """Return why this process cannot run what the kit is for; None where it can."""
        try:
            found, code = _versions(self.backends), code_digest(self.apps, self.backends, self.faults)
        except RobotcoreError as error:
            return str(error)
        for name, wanted in self.versions.items():
            if (has := found.get(name, "none")) != wanted:
                return f"{name}: it has {has}, here is {wanted}. {_remedy(name, wanted)}, and start it again"
        if code != self.code:
            return "its robotcore, drivers, apps or faults are not ours. Install the same, and start it again"
        return None

    @property
    def digest(self) -> str:
        """A digest of the files and their places."""
        total = hashlib.sha256()
        for file, content in sorted(self.files.items()):
            total.update(b"%b %b" % (os.fsencode(file), hashlib.sha256(content).digest()))
        return total.hexdigest()

    def unpack(self, root: Path) -> None:
        """Make ``root`` with the files below it, all or none; those of one folder stay beside each other."""
        with TemporaryDirectory(dir=root.parent) as folder:
            unfinished = Path(folder, root.name)
            unfinished.mkdir()
            for file, content in self.files.items():
                place = unfinished / _place(file)
                place.parent.mkdir(exist_ok=True)
                place.write_bytes(content)
            unfinished.rename(root)

    def app_in(self, root: Path, name: str) -> str:
        """Return an app's name where the files are unpacked below ``root``."""
        return str(root / _place(self.home / name)) if is_app_file(name) else name

    def description_in(self, root: Path, name: str) -> str:
        """Return a robot's or a world's name where the files are unpacked below ``root``."""
        return str(root / _place(self.home / name)) if is_own(name) else name


def _versions(backends: tuple[str, ...]) -> dict[str, str]:
    return {"robotcore": version("robotcore"), **libraries(backends)}


def _remedy(name: str, wanted: str) -> str:
    return f"Take the same {name} there" if name == PYTHON else f"pip install {name}=={wanted} there"


def _place(file: Path) -> Path:
    """Return a relative place for an absolute one; no ``..`` in it leads anywhere else."""
    folder = hashlib.sha256(os.fsencode(file.parent)).hexdigest()[:16]
    return Path(folder, file.name)
