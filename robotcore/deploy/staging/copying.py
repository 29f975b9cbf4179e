"""A folder of the user's, copied as it is to be sent."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator
from pathlib import Path

from robotcore.deploy.paths import list_names
from robotcore.deploy.staging.files import Listing, listed
from robotcore.errors import UsageError
from robotcore.text import escape


def copied(folder: Path, target: Path) -> Listing:
    """Copy what is sent of an absolute folder; a socket or a pipe is nobody's to send, and is passed over.

    A link is kept where it leads to something that is sent too, and made relative. Raises UsageError with all those
    that do not: they would lead to nothing there, or to somebody else's file.
    """
    listing = listed(folder)
    links = dict(_links(folder, listing.names))
    for name in listing.names:
        place = target / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if name in links:
            place.symlink_to(links[name])
        elif (folder / name).is_file():
            _copy(folder / name, place)
    return listing


def _copy(file: Path, place: Path) -> None:
    try:
        shutil.copy(file, place)
    except OSError as error:
        raise UsageError(f"{escape(str(file))}: {error.strerror}. Let it be read, or let git ignore it") from error


def _links(folder: Path, names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield the links among the names and where they lead, from beside them."""
    top = folder.resolve()
    sent = {Path(name) for name in names}
    sent |= {parent for path in sent for parent in path.parents}
    astray = []
    for name in names:
        if not (link := top / name).is_symlink():
            continue
        leads = Path(os.path.realpath(link))
        if leads.exists() and leads.is_relative_to(top) and leads.relative_to(top) in sent:
            yield name, os.path.relpath(leads, link.parent.resolve())
        else:
            astray.append(f"{name} -> {link.readlink()}")
    if astray:
        raise UsageError(
            f"{list_names(astray)}: a link that leads to nothing that is sent. Put the file itself there, or let git "
            "ignore the link"
        )
