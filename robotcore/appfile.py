"""An app from a file of the user's own: ``my_app.py``, or ``my_app.py:MyBehaviour`` where it holds several."""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from robotcore.behaviour import Behaviour
from robotcore.errors import BehaviourError, UnknownNameError, UsageError


def is_app_file(name: str) -> bool:
    """Return whether an app is named by its file."""
    return name.partition(":")[0].endswith(".py")


def load_app_file(name: str) -> type[Behaviour]:
    """Return the behaviour that a file defines.

    Raises UsageError where there is no such file or behaviour, BehaviourError where the file raises.
    """
    file, _, wanted = name.partition(":")
    path = Path(file)
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


def _imported(path: Path) -> ModuleType:
    """Run the file as a module; like a script's, its imports are looked for beside it first."""
    spec = spec_from_file_location(f"app_{path.stem}", path)
    assert spec, "a .py file has a spec"
    assert spec.loader, "and a loader"
    module = module_from_spec(spec)
    sys.modules[module.__name__] = module
    if str(path.parent) not in sys.path[:1]:
        sys.path.insert(0, str(path.parent))
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise BehaviourError(f"{path} cannot be imported: {type(error).__name__}: {error}") from error
    return module


def _behaviours_of(module: ModuleType) -> dict[str, type[Behaviour]]:
    return {
        name: thing
        for name, thing in vars(module).items()
        if isinstance(thing, type) and issubclass(thing, Behaviour) and thing.__module__ == module.__name__
    }
