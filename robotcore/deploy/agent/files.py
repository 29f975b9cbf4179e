"""Files on the robot: their layout, changes that survive a power cut, sizes and hashes."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
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


def write_file(path: Path, content: str | bytes) -> None:
    """Replace what is in a file in one step; where that fails, nothing is left of it."""
    beside = _temporary_path(path)
    try:
        with beside.open("wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
            file.flush()
            os.fsync(file.fileno())
        move_path(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def replace_link(path: Path, target: str) -> None:
    """Let a link lead elsewhere in one step; it is made where there is none."""
    beside = _temporary_path(path)
    with suppress(FileNotFoundError):
        beside.unlink()
    beside.symlink_to(target)
    move_path(beside, path)


def move_path(source: Path, to: Path) -> None:
    """Rename on the same disk; a file, a link or an empty folder that is there already is replaced."""
    source.replace(to)
    for folder in {source.parent, to.parent}:
        sync_folder(folder)


def sync_folder(folder: Path) -> None:
    """Wait until a folder's own entries are on the disk."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _temporary_path(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}")


MAKE_ROOM = "Make room there: a robot's recordings go home with robotcore deploy fetch --move, df -h tells the rest"
"""What to do about a full disk, at the desk's end too."""


def measure_free_space(path: Path) -> int:
    """Return what this user may still write on the disk that a path is on, or will be on."""
    there = next(folder for folder in (path, *path.parents) if folder.exists())
    told = os.statvfs(there)
    return told.f_bavail * told.f_frsize


def measure_size(folder: Path) -> int:
    """Return how many bytes all files below a folder take on the disk; those that vanish meanwhile take none."""
    total = 0
    for root, _, files in os.walk(folder):
        for name in files:
            with suppress(OSError):
                total += os.lstat(os.path.join(root, name)).st_blocks * 512  # noqa: PTH118  thousands of files
    return total


def format_bytes(size: int) -> str:
    """Return a number of bytes as somebody reads it.

    >>> in_words(12_345_678)
    '12.3 MB'
    """
    value = float(size)
    for unit in ("bytes", "kB", "MB"):
        if value < 1000:
            return f"{value:.0f} {unit}" if unit != "MB" else f"{value:.1f} {unit}"
        value /= 1000
    return f"{value:.1f} GB"


_PIECE_BYTES = 1 << 20


def hash_file(file: Path) -> str:
    """Return a file's SHA-256 in hex; it may be larger than the memory."""
    digest = hashlib.sha256()
    with file.open("rb") as content:
        while piece := content.read(_PIECE_BYTES):
            digest.update(piece)
    return digest.hexdigest()


def find_runtime_folder() -> Path:
    """Return the folder of what lasts until a reboot, in which systemd listens too.

    A login that does not know it has one all the same, where the user lingers.
    """
    return Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}")
