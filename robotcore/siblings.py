"""The modules beside an app's file, kept apart from those beside another's.

Python knows one module of a name. Of two apps in folders of their own, each with a ``helper.py``, both would get
whichever came first.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType


@dataclass
class _Folder:
    """A folder to import from; ``others`` are the modules that came before it, ``kept`` those that are put away."""

    others: frozenset[str]
    kept: dict[str, ModuleType] = field(default_factory=dict)
    is_first: bool = False


_folders: dict[Path, _Folder] = {}


def import_beside(file: Path) -> None:
    """Let imports look beside this file first, as a script's do, and no longer beside the file that was given before.

    What was imported from beside it is there again, as it was.
    """
    here = file.parent.absolute()
    for place, folder in _folders.items():
        if folder.is_first and place != here:
            _put_away(place, folder)
    folder = _folders.setdefault(here, _Folder(frozenset(map(_outermost, sys.modules))))
    if not folder.is_first:
        _take_out(here, folder)


def _put_away(place: Path, folder: _Folder) -> None:
    folder.is_first = False
    for name in [name for name in sys.modules if _is_of(name, place, folder.others)]:
        folder.kept[name] = sys.modules.pop(name)
    with suppress(ValueError):  # an app may have changed the path
        sys.path.remove(str(place))


def _take_out(place: Path, folder: _Folder) -> None:
    folder.is_first = True
    sys.path.insert(0, str(place))
    sys.modules.update(folder.kept)
    folder.kept.clear()


def _is_of(name: str, folder: Path, others: frozenset[str]) -> bool:
    """Return whether a module, or the package it is in, lies in the folder itself; a library below it does not."""
    if (outermost := _outermost(name)) in others:
        return False
    module = sys.modules.get(outermost)
    places = getattr(module, "__path__", None) or filter(None, [getattr(module, "__file__", None)])
    return folder in (Path(place).absolute().parent for place in places)


def _outermost(name: str) -> str:
    return name.partition(".")[0]
