"""Copies the recordings of a robot to this machine."""

from __future__ import annotations

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from robotcore.deploy import rsync
from robotcore.deploy.agent.files import format_bytes, hash_file, measure_free_space, measure_size
from robotcore.deploy.agent.uploads import delete
from robotcore.deploy.progress import OnStep, Step
from robotcore.deploy.robot_answers import EraseAnswer, RecordingsAnswer, RemoteFile
from robotcore.deploy.rpc import RobotLink
from robotcore.deploy.rsync import RECORDING
from robotcore.errors import DeployError, UsageError
from robotcore.text import escape, list_names, pluralize

STEP = "fetched"
"""The name of the step in progress reports."""


@dataclass(frozen=True)
class FetchResult:
    """The names of the robot's recordings, grouped by the result for each."""

    folder: Path
    """The folder for the recordings on this machine."""
    fetched: tuple[str, ...] = ()
    """The recordings that this fetch copied."""
    present: tuple[str, ...] = ()
    """The recordings that were in the folder before."""
    different: tuple[str, ...] = ()
    """The recordings that were not copied because the folder has a file of the same name with other content."""
    being_written: tuple[str, ...] = ()
    """The recordings that the robot is still writing."""
    skipped: tuple[str, ...] = ()
    """The files that were not copied because they are no recordings by name or type. Their names are escaped."""
    erased: tuple[str, ...] = ()
    """The recordings that the robot deleted after the copy."""

    @property
    def newest(self) -> Path | None:
        """The path of the robot's newest recording in the folder, or None. The names have the order of the runs."""
        names = sorted((*self.fetched, *self.present))
        return self.folder / names[-1] if names else None


def fetch(link: RobotLink, folder: Path, on_step: OnStep = print, *, deletes_on_robot: bool = False) -> FetchResult:
    """Copy the recordings of a robot that are not in the folder yet.

    The function copies only plain files that have the name of a recording, and overwrites no file.

    link: an open link to the robot.
    folder: the folder for the recordings. The function creates it if it does not exist.
    on_step: this function is called with the progress.
    deletes_on_robot: whether to delete each recording from the robot after its copy was verified by SHA-256.
    Raises DeployError if a call or a transfer fails. The recordings copied before stay in the folder.
    Raises UsageError if the folder cannot be written.
    """
    step = Step(STEP, on_step)
    step.update("listing the recordings")
    there = link.call("recordings", RecordingsAnswer).recordings
    found = _group_files(there, folder)
    sizes = {each.name: each.bytes for each in there if each.name in found.fetched}
    if sizes:
        _receive(link, folder, sizes, step)
    if deletes_on_robot:
        found = _erase_copied(link, found, step)
    size = format_bytes(sum(sizes.values()))
    step.finish(f"{pluralize(len(sizes), 'recording')}, {size}, to {escape(str(folder))}", *_format_details(found))
    return found


def _group_files(files: Sequence[RemoteFile], folder: Path) -> FetchResult:
    taken = {each.name: each for each in files if each.is_file and RECORDING.fullmatch(each.name)}
    left = {each.name for each in files} - taken.keys()
    written = {name for name, each in taken.items() if each.is_being_written}
    known = {name for name in taken if os.path.lexists(folder / name)} - written
    here = {name for name in known if _measure_file(folder / name) == taken[name].bytes}
    fetched = taken.keys() - known - written
    groups = [tuple(sorted(names)) for names in (fetched, here, known - here, written, left)]
    return FetchResult(folder, *groups)


def _receive(link: RobotLink, folder: Path, sizes: dict[str, int], step: Step) -> None:
    with IncomingFiles(folder, sizes) as incoming:
        rsync.receive(
            link,
            sorted(sizes),
            incoming.path,
            partial=incoming.partial,
            on_poll=incoming.check_limits,
            on_progress=lambda done, part: step.update(f"{part:.0%}, {format_bytes(done)}"),
        )
    if incoming.missing:
        raise DeployError(
            f"{link.host}: {list_names(incoming.missing)} did not arrive as plain files of the stated sizes. The other "
            f"recordings are in {escape(str(folder))}. Check that this is the right robot",
            kind="recordings-missing",
            missing=tuple(incoming.missing),
        )


def _erase_copied(link: RobotLink, found: FetchResult, step: Step) -> FetchResult:
    names = (*found.fetched, *found.present)
    if not names:
        return found
    digests = {name: hash_file(found.folder / name) for name in names}
    gone = link.call("erase", EraseAnswer, on_message=lambda message: step.update(message.text), recordings=digests)
    different = {*gone.different} & digests.keys()
    return replace(
        found,
        present=tuple(name for name in found.present if name not in different),
        different=tuple(sorted({*found.different, *different})),
        erased=tuple(sorted({*gone.erased} & digests.keys())),
    )


def _format_details(found: FetchResult) -> list[str]:
    details = [f"{name} is still being written, and stays on the robot" for name in found.being_written]
    details += [
        f"{name} differs from the file of that name here. Both were kept. To fetch it, name another folder: -o DIR"
        for name in found.different
    ]
    if again := {*found.erased} & {*found.present}:
        details.append(f"{pluralize(len(again), 'recording')} of an earlier fetch: deleted on the robot")
    if found.skipped:
        details.append(f"left on the robot because they are no recordings: {list_names(found.skipped)}")
    return details


RESERVED_DISK_BYTES = 500_000_000
"""The space in bytes that a fetch leaves free on the disk of this machine."""

SLACK_BYTES = 1 << 20
"""The allowance in bytes for folders and partly filled blocks on the disk."""

PARTIAL = ".partial"
"""The name of the folder that keeps an incomplete file after the connection broke."""


class IncomingFiles:
    """A context manager with a temporary folder for incoming files.

    At the end of the ``with`` block, even after an error, it moves the files of the stated size into ``folder``. It
    deletes all other files.

    folder: the folder for the recordings.
    sizes: the size in bytes that the robot states for each requested recording, by the recording's name.
    """

    def __init__(self, folder: Path, sizes: Mapping[str, int]) -> None:
        self._folder, self._sizes = folder, sizes
        self.partial = folder / PARTIAL
        """The folder for an incomplete file."""
        self.missing = sorted(sizes)
        """The recordings that did not arrive as plain files of the stated size; valid after the ``with`` block."""

    def __enter__(self) -> IncomingFiles:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._require_room(sum(self._sizes.values()))
            self._remove_leftovers()
            self.partial.mkdir(mode=0o700, exist_ok=True)
            self.path = Path(tempfile.mkdtemp(prefix=".arriving-", dir=self._folder))
        except OSError as error:
            problem = f"{escape(str(self._folder))} cannot be made or written to: {error.strerror}"
            raise UsageError(f"{problem}. Name another folder: -o DIR", kind="folder-not-writable") from error
        return self

    def __exit__(self, *error: object) -> None:
        try:
            self.missing = [name for name in self.missing if not self._move_if_complete(name)]
        finally:
            shutil.rmtree(self.path, ignore_errors=True)
            with suppress(OSError):
                self._remove_leftovers()
                self.partial.rmdir()

    def check_limits(self) -> None:
        """Raise DeployError if the robot sent more bytes than it stated, or if this machine's disk is nearly full."""
        stated = sum(self._sizes.values())
        if measure_size(self.path) > stated + SLACK_BYTES:
            raise DeployError(
                f"the robot sends more than the {format_bytes(stated)} that it stated. "
                "Check that this is the right robot",
                kind="too-many-bytes",
                stated=stated,
            )
        self._require_room(0)

    def _require_room(self, size: int) -> None:
        free = measure_free_space(self._folder.absolute())
        if size + RESERVED_DISK_BYTES > free:
            raise DeployError(
                f"not enough room: the recordings need {format_bytes(size)}, the disk has {format_bytes(free)} free, "
                f"and {format_bytes(RESERVED_DISK_BYTES)} must stay free. Make room, or name a folder on another disk: "
                "-o DIR",
                kind="no-room",
                needed=size,
                free=free,
            )

    def _remove_leftovers(self) -> None:
        """Delete everything but incomplete requested files from the folder `partial`.

        rsync would follow a link in this folder, and overwrite the target of the link. Raises OSError if a file or
        folder cannot be deleted.
        """
        if self.partial.is_symlink():
            self.partial.unlink()
        for path in self.partial.iterdir() if self.partial.is_dir() else ():
            size = _measure_file(path)
            if size is None or size > self._sizes.get(path.name, -1):
                delete(path)
                if os.path.lexists(path):
                    raise OSError(errno.EPERM, f"{escape(path.name)} cannot be deleted")

    def _move_if_complete(self, name: str) -> bool:
        file, target = self.path / name, self._folder / name
        if _measure_file(file) != self._sizes[name] or os.path.lexists(target):
            return False
        with suppress(OSError):  # file systems of Windows have no file modes
            file.chmod(file.lstat().st_mode & 0o644)
        file.rename(target)
        return True


def _measure_file(path: Path) -> int | None:
    """Return the size of a plain file in bytes; None for another kind of file, such as a link."""
    try:
        status = path.lstat()
    except OSError:
        return None
    return status.st_size if stat.S_ISREG(status.st_mode) else None
