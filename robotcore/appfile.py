"""An app from a file of the user's own: ``my_app.py``, or ``my_app.py:MyBehaviour`` where it holds several."""

from __future__ import annotations

import sys
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from robotcore.behaviour import Behaviour
from robotcore.errors import BehaviourError, UnknownNameError, UsageError
from robotcore.siblings import import_beside

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
    import_beside(path)
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
