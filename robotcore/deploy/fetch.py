"""What a robot recorded comes home."""

from __future__ import annotations

import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from robotcore.deploy.agent.files import format_bytes, hash_file
from robotcore.deploy.connection.answers import EraseAnswer, Recordings, RemoteFile
from robotcore.deploy.connection.link import Link
from robotcore.deploy.connection.rsync import RECORDING
from robotcore.deploy.incoming import IncomingFiles
from robotcore.deploy.paths import list_names
from robotcore.deploy.progress import Step, Tell, begin
from robotcore.errors import DeployError
from robotcore.text import counted, escape

STEP = "brought"


@dataclass(frozen=True)
class Fetched:
    """Recordings by their names: those that were ``brought``, and those that were ``here`` already.

    ``different`` are here under the same name with other content, and were left alone on both sides; ``written`` are
    being written there; ``left`` are no recordings by their names or kinds, and stay on the robot, each name escaped.
    ``erased`` were deleted there.
    """

    folder: Path
    brought: tuple[str, ...] = ()
    here: tuple[str, ...] = ()
    different: tuple[str, ...] = ()
    written: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    erased: tuple[str, ...] = ()

    @property
    def newest(self) -> Path | None:
        """The last recording that is here; names tell when each was begun."""
        names = sorted((*self.brought, *self.here))
        return self.folder / names[-1] if names else None


def fetch(link: Link, folder: Path, tell: Tell = print, *, moves: bool = False) -> Fetched:
    """Bring home what is not here; ``moves`` deletes each recording there once it is here, to the byte.

    Only plain files with names of recordings come, only into the folder, and no file here is overwritten. Raises
    DeployError; what was brought by then is here.
    """
    step = begin(STEP, tell)
    step.say("what is there is looked at")
    there = link.call("recordings", Recordings).recordings
    found = _compare(there, folder)
    sizes = {each.name: each.bytes for each in there if each.name in found.brought}
    if sizes:
        _bring(link, folder, sizes, step)
    if moves:
        found = _erase(link, found, step)
    size = format_bytes(sum(sizes.values()))
    step.done(f"{counted(len(sizes), 'recording')}, {size}, to {escape(str(folder))}", *_notes(found))
    return found


def _compare(files: Sequence[RemoteFile], folder: Path) -> Fetched:
    """Return what is to be brought, and what is here of it: by name and size."""
    taken = {each.name: each for each in files if each.is_file and RECORDING.fullmatch(each.name)}
    left = {each.name for each in files} - taken.keys()
    written = {name for name, each in taken.items() if each.is_being_written}
    known = {name for name in taken if os.path.lexists(folder / name)} - written
    here = {name for name in known if _size_of(folder / name) == taken[name].bytes}
    brought = taken.keys() - known - written
    groups = [tuple(sorted(names)) for names in (brought, here, known - here, written, left)]
    return Fetched(folder, *groups)


def _size_of(path: Path) -> int | None:
    """Return the bytes of a plain file, or None for anything else, such as a link."""
    status = path.lstat()
    return status.st_size if stat.S_ISREG(status.st_mode) else None


def _bring(link: Link, folder: Path, sizes: dict[str, int], step: Step) -> None:
    incoming = IncomingFiles(folder, sizes)
    with incoming:
        link.bring(
            sorted(sizes),
            incoming.path,
            partial=incoming.partial,
            on_poll=incoming.check_limits,
            on_progress=lambda done, part: step.say(f"{part:.0%}, {format_bytes(done)}"),
        )
    if incoming.missing:
        raise DeployError(
            f"{link.host}: {list_names(incoming.missing)} did not come as plain files of the stated sizes. The other "
            f"recordings are in {escape(str(folder))}. Check that this is the right robot"
        )


def _erase(link: Link, found: Fetched, step: Step) -> Fetched:
    """Delete on the robot every recording whose SHA-256 equals that of the file here."""
    names = (*found.brought, *found.here)
    if not names:
        return found
    digests = {name: hash_file(found.folder / name) for name in names}
    gone = link.call("erase", EraseAnswer, on_say=lambda notice: step.say(notice.say), recordings=digests)
    different = {*gone.different} & digests.keys()
    return replace(
        found,
        here=tuple(name for name in found.here if name not in different),
        different=tuple(sorted({*found.different, *different})),
        erased=tuple(sorted({*gone.erased} & digests.keys())),
    )


def _notes(found: Fetched) -> list[str]:
    notes = [f"{name} is being written, and was left there" for name in found.written]
    notes += [
        f"{name} differs from the file of that name here. Both were kept. To fetch it, name another folder: -o DIR"
        for name in found.different
    ]
    if again := {*found.erased} & {*found.here}:
        notes.append(f"{counted(len(again), 'recording')} of those that were here already: deleted there")
    if found.left:
        notes.append(f"left on the robot because they are no recordings: {list_names(found.left)}")
    return notes
