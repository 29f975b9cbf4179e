"""Files on the robot: their layout, changes that survive a power cut, sizes and hashes."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

FOLDER = "robotcore"
"""The folder below the home. A shell needs no quotes for it."""

MAKE_ROOM = "Make room on the robot: fetch its recordings with robotcore deploy fetch --move, and look at df -h"
"""The remedy for a full disk; the client uses it too."""

_PIECE_BYTES = 1 << 20


@dataclass(frozen=True)
class Layout:
    """The paths of everything that a deploy puts on a robot."""

    home: Path
    """The home folder of the user who logged in."""

    @property
    def root(self) -> Path:
        return self.home / FOLDER

    @property
    def incoming(self) -> Path:
        """A folder for each upload, and folders that are being deleted."""
        return self.root / "incoming"

    @property
    def releases(self) -> Path:
        return self.root / "releases"

    @property
    def environments(self) -> Path:
        """A folder for each environment, named by its digest and the release that it was made for."""
        return self.root / "environments"

    @property
    def recordings(self) -> Path:
        return self.root / "recordings"

    @property
    def current(self) -> Path:
        """A link to the current release."""
        return self.root / "current"

    @property
    def health_check(self) -> Path:
        """The health check that is pending or running; absent otherwise."""
        return self.root / "trial.json"

    @property
    def lock(self) -> Path:
        return self.root / "lock"

    @property
    def program(self) -> Path:
        """This package as one file, which systemd starts."""
        return self.root / "aboard.pyz"

    @property
    def units(self) -> Path:
        return self.home / ".config" / "systemd" / "user"


def write_file(path: Path, content: str | bytes) -> None:
    """Replace a file's content atomically; if that fails, the old content stays."""
    temporary = _temporary_path(path)
    try:
        with temporary.open("wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
            file.flush()
            os.fsync(file.fileno())
        move_path(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def replace_link(path: Path, target: str) -> None:
    """Create a symbolic link, or change its target atomically."""
    temporary = _temporary_path(path)
    with suppress(FileNotFoundError):
        temporary.unlink()
    temporary.symlink_to(target)
    move_path(temporary, path)


def move_path(source: Path, to: Path) -> None:
    """Rename on the same disk, durably; an existing file, link or empty folder is replaced."""
    source.replace(to)
    for folder in {source.parent, to.parent}:
        sync_folder(folder)


def sync_folder(folder: Path) -> None:
    """Wait until a folder's entries are on the disk."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _temporary_path(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}")


def measure_free_space(path: Path) -> int:
    """Return the bytes that this user may still write on the disk of a path, which need not exist."""
    existing = next(folder for folder in (path, *path.parents) if folder.exists())
    status = os.statvfs(existing)
    return status.f_bavail * status.f_frsize


def measure_size(folder: Path) -> int:
    """Return the bytes of all files below a folder on the disk. A file that is deleted during the call counts 0."""
    total = 0
    for root, _, files in os.walk(folder):
        for name in files:
            with suppress(OSError):
                total += os.lstat(os.path.join(root, name)).st_blocks * 512  # noqa: PTH118  thousands of files
    return total


def format_bytes(size: int) -> str:
    """Return a number of bytes with a unit.

    >>> format_bytes(12_345_678)
    '12.3 MB'
    """
    value = float(size)
    for unit in ("bytes", "kB", "MB"):
        if value < 1000:
            return f"{value:.0f} {unit}" if unit != "MB" else f"{value:.1f} {unit}"
        value /= 1000
    return f"{value:.1f} GB"


def hash_file(file: Path) -> str:
    """Return a file's SHA-256 in hex; the file may be larger than the memory."""
    digest = hashlib.sha256()
    with file.open("rb") as content:
        while piece := content.read(_PIECE_BYTES):
            digest.update(piece)
    return digest.hexdigest()


def find_runtime_folder() -> Path:
    """Return the user's folder for files that last until a reboot; systemd's socket is there too.

    If the login does not set it, it still exists for a user with lingering.
    """
    return Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}")
