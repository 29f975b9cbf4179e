"""Where the firmware's source is."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from robotcore.errors import UsageError

NAME = "robotcore_bridge"
PLACES = (Path(__file__).parent / NAME, Path(__file__).parents[3] / "firmware" / NAME)
"""In an installed robotcore, and in a clone of the project."""


def shipped() -> Path:
    """Return the folder of the sketch that came with this robotcore."""
    return next(place for place in PLACES if (place / f"{NAME}.ino").is_file())


def chosen(folder: Path | None) -> Path:
    """Return the folder of a sketch: somebody's own, or what `copy` made of it, or the shipped one.

    Raises UsageError where it holds none: Arduino wants FOLDER/FOLDER.ino.
    """
    if folder is None:
        return shipped()
    for place in (folder.absolute(), folder.absolute() / NAME):
        if (place / f"{place.name}.ino").is_file():
            return place
    raise UsageError(f"{folder}: holds no sketch {folder.name}.ino. `robotcore firmware copy DIR` makes one to change")


def baud(folder: Path) -> int:
    """Return at how many baud a sketch talks, as its config.h says; 57600 where it says nothing."""
    header = folder / "config.h"
    said = re.search(r"(?m)^#define BAUD (\d+)", header.read_text()) if header.is_file() else None
    return int(said[1]) if said else 57600


def copy(into: Path) -> Path:
    """Copy the shipped sketch into a folder, to be wired in its config.h; return the sketch's folder.

    Raises UsageError where there is one already, or the folder cannot be written.
    """
    target = into / NAME
    try:
        shutil.copytree(shipped(), target)
    except FileExistsError as error:
        raise UsageError(f"{target}: is there already. Edit its config.h, or name another folder") from error
    except OSError as error:
        raise UsageError(f"{target}: {error.strerror}. Name a folder that you may write") from error
    return target
