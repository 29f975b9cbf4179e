"""The maker's binding: load the user's own copy, call it, and convert its return codes to errors."""

from __future__ import annotations

import ctypes
import importlib.util
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

from drivers.vrep.wire.errors import NobodyListensError, RefusedError, RemoteApiError, ServerHangsError, ServerLostError
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


PERIOD_MS = 5
_OK, _NO_VALUE, _TIMEOUT, _REMOTE = 0, 1, 2, 8
_SERVER_STATE = 17
_VERSION = 1


class Calls:
    """One client of a binding; calls from several threads take turns.

    Of a failure the binding tells a number; so messages here say less than those of our own client.
    """

    def __init__(self, binding: ModuleType, host: str, port: int, answer_s: float) -> None:
        self.api, self._answer_s = binding, answer_s
        self._where = f"the simulator at {host}:{port}"
        self._turn = RLock()
        self._streams: set[tuple[Any, ...]] = set()
        self._client: int = binding.simxStart(host, port, True, True, -round(1000 * answer_s), PERIOD_MS)
        if self._client == -1:
            raise NobodyListensError(
                f"nobody answers at {host}:{port}. Start the simulator, give its port with --port, or end the program "
                "that it serves"
            )

    @property
    def is_connected(self) -> bool:
        return bool(self.api.simxGetConnectionId(self._client) != -1)

    @property
    def server_state(self) -> int:
        """The bits of the newest header: 1 is running, 2 paused."""
        self.run("simxGetPingTime")
        _, state = self.api.simxGetInMessageInfo(self._client, _SERVER_STATE)  # its code is 1 where all is well
        return int(state)

    @property
    def time_s(self) -> float:
        """The simulation's newest time."""
        with self._turn:
            self.read(self.named("simxGetInt32Param", "simxGetIntegerParameter"), _VERSION)
            if not self.is_connected:
                raise self._lost()
            return float(self.api.simxGetLastCmdTime(self._client)) / 1000

    def named(self, *names: str) -> str:
        """Return which of its names a function has in this binding."""
        return next((name for name in names if hasattr(self.api, name)), names[0])

    def run(self, function: str, *args: Any) -> Any:
        """Call a function that takes no operation mode; return what came with its code."""
        with self._turn:
            return self._checked(getattr(self.api, function)(self._client, *args))

    def once(self, function: str, *args: Any) -> Any:
        """Return an answer that is waited for."""
        return self.run(function, *args, self.api.simx_opmode_blocking)

    def read(self, function: str, *args: Any) -> Any:
        """Return the newest answer of a stream, which begins with the first call."""
        stream = (function, *args)
        with self._turn:  # one that waits for an answer takes away what another thread would read
            if stream in self._streams:
                mode = self.api.simx_opmode_buffer
                code, *values = getattr(self.api, function)(self._client, *args, mode)
                return self.once(function, *args) if code == _NO_VALUE else self._checked((code, *values))
            value = self.once(function, *args)
            getattr(self.api, function)(self._client, *args, self.api.simx_opmode_streaming)
            self._streams.add(stream)
            return value

    def send(self, function: str, *args: Any) -> None:
        """Send without waiting; that nothing has come back yet is no failure."""
        with self._turn:
            code = getattr(self.api, function)(self._client, *args, self.api.simx_opmode_oneshot)
            if code & ~_NO_VALUE or not self.is_connected:
                self._checked(code or _TIMEOUT)

    def close(self) -> None:
        """Have done what was sent, and hang up."""
        with self._turn:
            if self.is_connected:
                self.api.simxGetPingTime(self._client)
            self.api.simxFinish(self._client)

    def _checked(self, returned: Any) -> Any:
        """Return what came with a code that is good; raise what it means where it is not."""
        code, *values = returned if isinstance(returned, tuple) else (returned,)
        if code == _OK:
            return values[0] if len(values) == 1 else values
        if not self.is_connected:
            raise self._lost()
        if code & _REMOTE:
            raise RefusedError(f"{self._where} refused (code {code})")
        raise ServerHangsError(f"{self._where} has not answered for {self._answer_s:g} s (code {code}). Restart it")

    def _lost(self) -> RemoteApiError:
        return ServerLostError(
            f"{self._where} is gone. Was it closed, its scene stopped, or killed? Start it, run again"
        )
