"""Loads apps by name or from a file. The file of an app can import the other modules of its folder."""

from __future__ import annotations

import os
import re
import sys
from contextlib import suppress
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from robotcore.errors import BehaviourError, UnknownNameError, UsageError
from robotcore.plugins import APPS, app_names, load_registered
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.forks import end_forks
from robotcore.text import escape, suggest_attribute

IMPORT_ADVICE = "Put the code that causes this below if __name__ == '__main__', or into step()"
"""The advice to the author of an app's file whose import ends the process or hangs."""


_SURROGATE = re.compile("[\ud800-\udfff]")
"""Matches what Python puts in place of a byte that is no valid UTF-8 in a file's name."""


def is_app_file(name: str) -> bool:
    """Return whether an app's name is a file name, such as ``my_app.py`` or ``my_app.py:MyApp``."""
    return name.partition(":")[0].endswith(".py")


def refuse_other_file(name: str) -> None:
    """Raise UsageError if the name is that of a folder or of another file, or of a ``.py`` file without its end."""
    path = Path(name)
    if name and os.path.isfile(f"{name}.py"):  # noqa: PTH113  it takes any name, however long
        raise UsageError(f"{name} is not an app. Did you mean the file {name}.py?", kind="not-an-app")
    if name and os.path.exists(path):  # noqa: PTH110
        what = "a folder" if path.is_dir() else "another file"
        raise UsageError(f"{name} is {what}, not an app. Name an app (robotcore apps) or a .py file", kind="not-an-app")


def app_path(name: str) -> Path:
    """Return the file of an app's name, for example ``my_app.py`` for ``my_app.py:MyApp``."""
    return Path(name.partition(":")[0])


def load_app_file(name: str) -> type[Behaviour]:
    """Return the behaviour that a file defines.

    name: the file, such as ``my_app.py``. If it defines several behaviours, ``my_app.py:MyApp`` selects one.

    Raises UsageError if the file or the behaviour does not exist, if the file's name is no valid UTF-8, or if the
    import of the file calls ``sys.exit``. Raises BehaviourError if the import raises another exception.
    """
    file, _, wanted = name.partition(":")
    path = app_path(name)
    if not os.path.isfile(path):  # noqa: PTH113
        raise UsageError(
            f"{file}: there is no such file. Name an app (robotcore apps) or a .py file", kind="no-such-file"
        )
    if _SURROGATE.search(name):  # a result and a recording have the name as UTF-8
        problem = f"{escape(file)}: the name is no valid UTF-8. Rename the file or its folder"
        raise UsageError(problem, kind="name-not-utf-8")
    apps = _find_behaviours(_import_file(path))
    if wanted and wanted not in apps:
        raise UnknownNameError(f"behaviour in {file}", wanted, list(apps))
    if len(apps) == 1 or wanted:
        return apps[wanted or next(iter(apps))]
    if apps:
        raise UsageError(
            f"{file} defines several behaviours. Choose one, for example {file}:{next(iter(apps))}",
            kind="several-behaviours",
        )
    raise UsageError(f"{file} defines no behaviour. Add a class that inherits robotcore.Behaviour", kind="no-behaviour")


class _SourceLoader(SourceFileLoader):
    """A loader that always compiles the source.

    Python's ``.pyc`` file contains the source's time in whole seconds. An edit in the same second would have no effect.
    """

    def path_stats(self, path: str) -> NoReturn:
        raise OSError


_importing: set[Path] = set()
"""The files of apps that are being imported."""


def _import_file(path: Path) -> ModuleType:
    if path.absolute() in _importing:
        raise UsageError(f"{path} runs itself while it is imported. {IMPORT_ADVICE}", kind="app-runs-itself")
    use_script_folder(path)
    name = f"app_{path.stem}"
    spec = spec_from_file_location(name, path, loader=_SourceLoader(name, str(path)))
    assert spec
    assert spec.loader
    module = module_from_spec(spec)
    sys.modules[module.__name__] = module
    _importing.add(path.absolute())
    try:
        spec.loader.exec_module(module)
    except SystemExit as error:
        status = "" if error.code is None else repr(error.code)
        raise UsageError(
            f"the import of {path} ends the process, with exit({status}). {IMPORT_ADVICE}", kind="app-exits"
        ) from error
    except Exception as error:
        parts = (f"{path} cannot be imported: {type(error).__name__}: {error}", suggest_attribute(error))
        raise BehaviourError(". ".join(filter(None, parts)), kind="app-not-importable") from error
    finally:
        _importing.discard(path.absolute())
    return module


def _find_behaviours(module: ModuleType) -> dict[str, type[Behaviour]]:
    return {
        name: thing
        for name, thing in vars(module).items()
        if isinstance(thing, type) and issubclass(thing, Behaviour) and thing.__module__ == module.__name__
    }


@dataclass
class _ScriptFolder:
    """The folder of the app's file that imports search first."""

    path: Path
    earlier_modules: frozenset[str]
    """The names of the modules that were imported before the folder was used."""

    def remove(self) -> None:
        """Remove the folder from the import path, and its modules from ``sys.modules``."""
        for name in {name.partition(".")[0] for name in sys.modules} - self.earlier_modules:
            module = sys.modules.get(name)
            files = getattr(module, "__path__", None) or filter(None, [getattr(module, "__file__", None)])
            if self.path in (Path(file).absolute().parent for file in files):
                for each in [each for each in sys.modules if each == name or each.startswith(f"{name}.")]:
                    del sys.modules[each]
        with suppress(ValueError):  # an app may have changed sys.path
            sys.path.remove(str(self.path))


_folder: _ScriptFolder | None = None


def use_script_folder(file: Path) -> None:
    """Let imports search the folder of an app's file first, as Python does for a script.

    Imports no longer search the folder of the app that was loaded before, and its modules are imported anew if the
    folder is used again.
    """
    global _folder  # noqa: PLW0603  the import path is global too
    path = file.parent.absolute()
    if _folder and _folder.path == path:
        return
    if _folder:
        _folder.remove()
    _folder = _ScriptFolder(path, frozenset(name.partition(".")[0] for name in sys.modules))
    sys.path.insert(0, str(path))


def load_app(name: str) -> type[Behaviour]:
    """Return the app with a registered name, or the app in a ``.py`` file.

    An underscore in a registered name counts as a hyphen. A copy of the process that the import makes with ``os.fork``
    ends.
    """
    with end_forks(f"the import of {name}"):
        if is_app_file(name):
            return load_app_file(name)
        if app_name(name) not in app_names():
            refuse_other_file(name)
        app: type[Behaviour] = load_registered("app", APPS, app_name(name))
        return app


def app_name(name: str) -> str:
    """Return an app's name as results contain it: with hyphens in place of underscores. A file name does not change."""
    return name if is_app_file(name) else name.replace("_", "-")
