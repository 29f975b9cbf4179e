"""Apps by name or from a file, with the modules beside that file."""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from robotcore.errors import BehaviourError, UnknownNameError, UsageError
from robotcore.plugins import APPS, app_names, load_registered
from robotcore.runtime.behaviour import Behaviour

INSTEAD = "Put what it does there below if __name__ == '__main__', or into step()"
"""What to do with a file that does more than to define an app."""


def is_app_file(name: str) -> bool:
    """Return whether an app is named by its file."""
    return name.partition(":")[0].endswith(".py")


def refuse_other_file(name: str) -> None:
    """Raise UsageError where a name that is no app's is that of a folder or of a file, which can be none."""
    path = Path(name)
    if name and path.exists():
        what = "a folder" if path.is_dir() else "no .py file"
        raise UsageError(f"{name} is {what}, and no app. Name an app (robotcore apps), or the .py file of one")


def app_path(name: str) -> Path:
    """Return the file that an app is named by."""
    return Path(name.partition(":")[0])


def load_app_file(name: str) -> type[Behaviour]:
    """Return the behaviour that a file defines.

    Raises UsageError where there is no such file or behaviour, or where the file would end the process; BehaviourError
    where it raises.
    """
    file, _, wanted = name.partition(":")
    path = app_path(name)
    if not path.is_file():
        raise UsageError(f"{file}: there is no such file. Name an app (robotcore apps), or the file of one")
    apps = _behaviours_of(_imported(path))
    if wanted and wanted not in apps:
        raise UnknownNameError(f"behaviour in {file}", wanted, list(apps))
    if len(apps) == 1 or wanted:
        return apps[wanted or next(iter(apps))]
    if apps:
        raise UsageError(f"{file} holds several behaviours. Name one of them: {file}:{next(iter(apps))}")
    raise UsageError(f"{file} holds no behaviour. Let a class in it inherit robotcore.Behaviour")


class _Source(SourceFileLoader):
    """Takes a file as it is: compiled code is told from newer source by whole seconds and size only."""

    def path_stats(self, path: str) -> NoReturn:
        raise OSError


def _imported(path: Path) -> ModuleType:
    """Run the file as a module."""
    use_script_folder(path)
    name = f"app_{path.stem}"
    spec = spec_from_file_location(name, path, loader=_Source(name, str(path)))
    assert spec, "a .py file has a spec"
    assert spec.loader, "and a loader"
    module = module_from_spec(spec)
    sys.modules[module.__name__] = module
    try:
        spec.loader.exec_module(module)
    except SystemExit as error:
        status = "" if error.code is None else repr(error.code)
        raise UsageError(f"{path} ends its process when it is imported, by exit({status}). {INSTEAD}") from error
    except Exception as error:
        raise BehaviourError(f"{path} cannot be imported: {type(error).__name__}: {error}") from error
    return module


def _behaviours_of(module: ModuleType) -> dict[str, type[Behaviour]]:
    return {
        name: thing
        for name, thing in vars(module).items()
        if isinstance(thing, type) and issubclass(thing, Behaviour) and thing.__module__ == module.__name__
    }


@dataclass
class _Folder:
    """A folder to import from; ``others`` are the modules that came before it, ``kept`` those that are put away."""

    others: frozenset[str]
    kept: dict[str, ModuleType] = field(default_factory=dict)
    is_first: bool = False


_folders: dict[Path, _Folder] = {}


def use_script_folder(file: Path) -> None:
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


def load_app(name: str) -> type[Behaviour]:
    """Return the app of that name, an underscore counting as a hyphen; or the one in that ``.py`` file."""
    if is_app_file(name):
        return load_app_file(name)
    if app_name(name) not in app_names():
        refuse_other_file(name)
    app: type[Behaviour] = load_registered("app", APPS, app_name(name))
    return app


def app_name(name: str) -> str:
    """Return what an app is called in results: a file's own name, or the registered one with hyphens."""
    return name if is_app_file(name) else name.replace("_", "-")
