"""What a robot recorded comes home."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from robotcore.deploy.aboard.system.digest import sha256
from robotcore.deploy.aboard.system.disk import in_words
from robotcore.deploy.connection.link import Link
from robotcore.deploy.paths import told
from robotcore.deploy.progress import Tell, begin
from robotcore.errors import UsageError
from robotcore.text import counted

STEP = "brought"


@dataclass(frozen=True)
class Fetched:
    """Recordings by their names: those that were ``brought``, and those that were ``here`` already.

    ``different`` are here under the same name with other content, and were left alone on both sides; ``written`` are
    being written there.
    """

    folder: Path
    brought: tuple[str, ...] = ()
    here: tuple[str, ...] = ()
    different: tuple[str, ...] = ()
    written: tuple[str, ...] = ()

    @property
    def newest(self) -> Path | None:
        """The last recording that is here; names tell when each was begun."""
        names = sorted((*self.brought, *self.here))
        return self.folder / names[-1] if names else None


def fetch(link: Link, folder: Path, tell: Tell = print, *, moves: bool = False) -> Fetched:
    """Bring home what is not here; ``moves`` deletes each recording there once it is here, to the byte.

    No file here is ever overwritten by another one. Raises DeployError; what was brought by then is here.
    """
    step = begin(STEP, tell)
    step.say("what is there is looked at")
    sizes, found = _compared(link.call("recordings")["recordings"], folder)
    if moves:
        found = _proven_same(link, found)
    if wanted := [*found.brought, *(found.here if moves else ())]:
        _make(folder)
        link.bring(
            wanted, folder, moves=moves, on_progress=lambda done, part: step.say(f"{part:.0%}, {in_words(done)}")
        )
    size = in_words(sum(sizes[name] for name in found.brought))
    step.done(f"{counted(len(found.brought), 'recording')}, {size}, to {folder}", *_notes(found, moves=moves))
    return found


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{folder} cannot be made: {error.strerror}. Take another folder: -o DIR") from error


def _compared(found: Iterable[Mapping[str, Any]], folder: Path) -> tuple[dict[str, int], Fetched]:
    """Return the sizes of what is there, and what is here of it: by name and size."""
    there = {each["name"]: each for each in found}
    sizes: dict[str, int] = {name: each["bytes"] for name, each in there.items()}
    written = {name for name, each in there.items() if each["is_being_written"]}
    known = {name for name in sizes if (folder / name).exists()} - written
    here = {name for name in known if (folder / name).stat().st_size == sizes[name]}
    brought = sizes.keys() - known - written
    return sizes, Fetched(folder, *(tuple(sorted(names)) for names in (brought, here, known - here, written)))


def _proven_same(link: Link, found: Fetched) -> Fetched:
    """Return what is here with what differs in a byte apart: it must not be deleted there."""
    hashed = link.call("recordings", hashed=found.here)["recordings"]
    there = {each["name"]: each.get("sha256") for each in hashed}
    here = tuple(name for name in found.here if there.get(name) == sha256(found.folder / name))
    return replace(found, here=here, different=tuple(sorted({*found.different, *found.here} - {*here})))


def _notes(found: Fetched, *, moves: bool) -> list[str]:
    notes = [f"{told(name)} is being written, and was left there" for name in found.written]
    notes += [
        f"{told(name)} is here with other content; neither was touched. Take another folder: -o"
        for name in found.different
    ]
    if moves and found.here:
        notes.append(f"{counted(len(found.here), 'recording')} of those that were here already: deleted there")
    return notes
