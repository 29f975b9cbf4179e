"""The official binding, where the user has one: its modules and its library beside each other in a folder."""

from __future__ import annotations

import ctypes
import importlib.util
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from types import ModuleType

from robotcore.errors import BackendMissingError

MODULES = {"sim.py": "simConst.py", "vrep.py": "vrepConst.py"}
"""Each module, as CoppeliaSim and as V-REP call it, and its constants."""

LIBRARIES = {"linux": "remoteApi.so", "darwin": "remoteApi.dylib", "win32": "remoteApi.dll"}
_ASK = "It takes the folder that has vrep.py or sim.py, its constants and its library; without it ours is used"


def load_binding(path: str | Path) -> ModuleType:
    """Return the official binding found in a folder, or at one of its files, with the names that `simx` has too.

    It is loaded anew, under a name of its own. What keeps it from working raises BackendMissingError.
    """
    module, folder = _module_at(Path(path).expanduser())
    _require_library(folder)
    return _loaded(module)


def _module_at(path: Path) -> tuple[Path, Path]:
    folder = path if path.is_dir() else path.parent
    names = [path.name] if path.name in MODULES else list(MODULES)
    for name in names:
        if (module := folder / name).is_file():
            if not (folder / MODULES[name]).is_file():
                raise BackendMissingError(f"binding: {module} needs {MODULES[name]} beside it. {_ASK}")
            return module, folder
    raise BackendMissingError(f"binding: there is no {' or '.join(names)} in {folder}. {_ASK}")


def _require_library(folder: Path) -> None:
    """Load the library as the binding will: that only prints what is wrong, and then fails where nobody understands."""
    library = folder / LIBRARIES.get(sys.platform, LIBRARIES["linux"])
    if not library.is_file():
        raise BackendMissingError(f"binding: there is no {library.name} in {folder}. {_ASK}")
    try:
        ctypes.CDLL(str(library))
    except OSError as error:
        raise BackendMissingError(
            f"binding: {library} cannot be loaded ({error}). Is it for this system and processor? {_ASK}"
        ) from error


def _loaded(path: Path) -> ModuleType:
    """Import a binding that imports its constants by their plain name."""
    spec = importlib.util.spec_from_file_location(f"official_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise BackendMissingError(f"binding: {path} is no Python module. {_ASK}")
    module = importlib.util.module_from_spec(spec)
    constants = Path(MODULES[path.name]).stem
    sys.modules.pop(constants, None)
    sys.path.insert(0, str(path.parent))
    try:
        with redirect_stdout(StringIO()):
            spec.loader.exec_module(module)
    except Exception as error:
        raise BackendMissingError(f"binding: {path} cannot be imported ({error!r}). {_ASK}") from error
    finally:
        sys.path.remove(str(path.parent))
        sys.modules.pop(constants, None)
    if not hasattr(module, "simxStart"):
        raise BackendMissingError(f"binding: {path} has no simxStart. {_ASK}")
    return module
