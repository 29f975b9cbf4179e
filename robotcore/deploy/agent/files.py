"""Files on the robot: their paths, writing that survives a power cut, sizes and hashes."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

FOLDER = "robotcore"
"""The name of the folder in the user's home that has all deployed files. It needs no quotes in a shell."""


@dataclass(frozen=True)
class Layout:
    """The paths of all deployed files and folders on a robot."""

    home: Path
    """The home folder of the user who logged in by ssh."""

    @property
    def root(self) -> Path:
        return self.home / FOLDER

    @property
    def incoming(self) -> Path:
        """The parent of the folders of uploads, and of folders that a process is deleting."""
        return self.root / "incoming"

    @property
    def releases(self) -> Path:
        return self.root / "releases"

    @property
    def environments(self) -> Path:
        """The parent of the environments' folders. Their names are ``DIGEST-RELEASE``."""
        return self.root / "environments"

    @property
    def recordings(self) -> Path:
        return self.root / "recordings"

    @property
    def current(self) -> Path:
        """The symbolic link to the folder of the current release."""
        return self.root / "current"

    @property
    def health_check(self) -> Path:
        """The file of the pending or running health check. Without such a check, it does not exist."""
        return self.root / "trial.json"

    @property
    def lock(self) -> Path:
        return self.root / "lock"

    @property
    def program(self) -> Path:
        """The ZIP file with this package that systemd starts as a program."""
        return self.root / "aboard.pyz"

    @property
    def units(self) -> Path:
        return self.home / ".config" / "systemd" / "user"


def write_file(path: Path, content: str | bytes) -> None:
    """Replace the content of a file atomically. After an error, the file has its old content."""
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
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(target)
    move_path(temporary, path)


def move_path(source: Path, to: Path) -> None:
    """Rename a file or a folder, and wait until the new name is on the disk.

    The function replaces a file, a link or an empty folder at the new path. Both paths must be on the same disk.
    """
    source.replace(to)
    for folder in {source.parent, to.parent}:
        sync_folder(folder)


def sync_folder(folder: Path) -> None:
    """Wait until all changes of names in a folder are on the disk."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _temporary_path(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}")


def measure_free_space(path: Path) -> int:
    """Return the free space in bytes for this user on the disk of a path. The path need not exist."""
    existing = next(folder for folder in (path, *path.parents) if folder.exists())
    status = os.statvfs(existing)
    return status.f_bavail * status.f_frsize


def measure_size(folder: Path) -> int:
    """Return the space in bytes that the files below a folder take on the disk."""
    total = 0
    for root, _, files in os.walk(folder):
        for name in files:
            with suppress(OSError):  # a file may be deleted during the call
                total += os.lstat(os.path.join(root, name)).st_blocks * 512  # noqa: PTH118  thousands of files
    return total


def format_bytes(size: int) -> str:
    """Return a number of bytes with a unit.

    >>> format_bytes(12_345_678)
    '12.3 MB'
    """
    if size < 1e6:
        return f"{size} bytes" if size < 1000 else f"{size / 1e3:.0f} kB"
    return f"{size / 1e6:.1f} MB" if size < 1e9 else f"{size / 1e9:.1f} GB"


def hash_file(file: Path) -> str:
    """Return the SHA-256 of a file in hex. The file may be larger than the memory."""
    digest = hashlib.sha256()
    with file.open("rb") as content:
        while piece := content.read(1 << 20):
            digest.update(piece)
    return digest.hexdigest()


def find_runtime_folder() -> Path:
    """Return the user's runtime folder, such as ``/run/user/1000``. It has the socket of the user's systemd.

    A reboot deletes its files. If the login sets no ``XDG_RUNTIME_DIR``, the folder exists for a user with lingering.
    """
    return Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}")
