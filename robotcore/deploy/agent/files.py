"""Files on the robot: their paths, their lock, writing that survives a power cut, sizes and hashes."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent.errors import AgentError

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
        return self.root / "health-check.json"

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


LOCK_TIMEOUT_S, LOCK_POLL_S = 20.0, 0.1
"""The default time limit for the wait for the lock, and the time between two attempts, in s."""


@contextmanager
def hold_lock(layout: Layout, activity: str, timeout_s: float = LOCK_TIMEOUT_S) -> Iterator[int]:
    """Hold the robot's lock during a ``with`` block, and yield the file handle of the lock.

    Only the process that holds the lock may change releases and environments. The kernel releases the lock when the
    process ends. If a child process inherits the handle, the lock stays held until that child has ended too.

    activity: the work of this process in words, for the error message of another process that waits in vain.
    timeout_s: the time limit for the wait, in s.
    Raises AgentError of the kind ``busy`` after the time limit.
    """
    until = time.monotonic() + timeout_s
    while (handle := _try_lock(layout, is_last=time.monotonic() >= until)) is None:
        time.sleep(LOCK_POLL_S)
    try:
        with suppress(OSError):  # `remove` must work on a full disk too
            os.ftruncate(handle, 0)
            os.pwrite(handle, f"{activity}, process {os.getpid()}".encode(), 0)
        yield handle
    finally:
        os.close(handle)


def _try_lock(layout: Layout, *, is_last: bool) -> int | None:
    """Return the handle of the locked file; None if another process holds the lock, or has removed the file."""
    import fcntl  # the computer of the developer, which imports this module too, may lack it

    layout.root.mkdir(parents=True, exist_ok=True)
    handle = os.open(layout.lock, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(layout.lock.stat(), os.fstat(handle)):
            return handle
    except FileNotFoundError:
        pass
    except BlockingIOError:
        if is_last:
            holder = os.pread(handle, 200, 0).decode(errors="replace") or "an unknown process"
            os.close(handle)
            problem = f"another deploy is at work on this robot: {holder}"
            raise AgentError(problem, "Wait for it to end, and try again", "busy", holder=holder) from None
    os.close(handle)
    return None


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


def locate_segments(recording: Path) -> Path:
    """Return the folder of the segments that a recording has while it is being written, and after a kill."""
    return recording.with_name(f"{recording.name}.segments")


def measure_recording(path: Path) -> int:
    """Return the size of a recording and of its segments, in bytes."""
    return path.stat().st_size + measure_size(locate_segments(path))


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
