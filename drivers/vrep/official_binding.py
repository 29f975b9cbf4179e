"""Load the user's copy of the simulator's official Python binding, call it, and convert return codes to errors."""

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

from drivers.vrep.wire.errors import NoServerError, RefusedError, RemoteApiError, ServerLostError, ServerTimeoutError
from robotcore.errors import BackendMissingError

MODULES = {"sim.py": "simConst.py", "vrep.py": "vrepConst.py"}
"""The file of the binding's module, for CoppeliaSim and for V-REP, and the file with the constants that it imports."""

LIBRARIES = {"linux": "remoteApi.so", "darwin": "remoteApi.dylib", "win32": "remoteApi.dll"}
_HINT = "Name the folder that contains vrep.py or sim.py, the constants and the library, or omit the option"


def load_binding(path: str | Path) -> ModuleType:
    """Import the official binding, and return its module. `drivers.vrep.simx` has functions with the same names.

    path: the folder of the binding, or one of its files.

    Each call imports a new module, with its own clients. Raises BackendMissingError if a file is missing or does not
    load.
    """
    module, folder = _find_module(Path(path).expanduser())
    _require_library(folder)
    return _import_module(module)


def _find_module(path: Path) -> tuple[Path, Path]:
    folder = path if path.is_dir() else path.parent
    names = [path.name] if path.name in MODULES else list(MODULES)
    for name in names:
        if (module := folder / name).is_file():
            if not (folder / MODULES[name]).is_file():
                raise BackendMissingError(
                    f"binding: {MODULES[name]} is missing beside {module}. {_HINT}", kind="binding-incomplete"
                )
            return module, folder
    raise BackendMissingError(
        f"binding: there is no {' or '.join(names)} in {folder}. {_HINT}", kind="binding-incomplete"
    )


def _require_library(folder: Path) -> None:
    """Load the native library of the binding. The binding itself would report a problem only later, and by a print."""
    library = folder / LIBRARIES.get(sys.platform, LIBRARIES["linux"])
    if not library.is_file():
        raise BackendMissingError(
            f"binding: there is no {library.name} in {folder}. {_HINT}", kind="binding-incomplete"
        )
    try:
        ctypes.CDLL(str(library))
    except OSError as error:
        raise BackendMissingError(
            f"binding: {library} cannot be loaded ({error}). Check whether it is for this system and processor. "
            f"{_HINT}",
            kind="binding-library",
        ) from error


def _import_module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"official_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise BackendMissingError(f"binding: {path} is not a Python module. {_HINT}", kind="binding-import")
    module = importlib.util.module_from_spec(spec)
    constants = Path(MODULES[path.name]).stem
    sys.modules.pop(constants, None)
    sys.path.insert(0, str(path.parent))
    try:
        with redirect_stdout(StringIO()):
            spec.loader.exec_module(module)
    except Exception as error:
        raise BackendMissingError(
            f"binding: {path} cannot be imported ({error!r}). {_HINT}", kind="binding-import"
        ) from error
    finally:
        sys.path.remove(str(path.parent))
        sys.modules.pop(constants, None)
    if not hasattr(module, "simxStart"):
        raise BackendMissingError(f"binding: {path} has no function simxStart. {_HINT}", kind="binding-import")
    return module


PERIOD_MS = 5
_OK, _NO_VALUE, _TIMEOUT, _REMOTE = 0, 1, 2, 8
_SERVER_STATE = 17
_VERSION = 1


class OfficialClient:
    """A client of the official binding, which is connected to one server. Calls from several threads take turns.

    binding: the imported module.
    host, port: the address of the server.
    answer_s: time limit of a call, in seconds.

    The binding reports errors by return codes. So the error messages have fewer details than those of this driver's own
    client.
    """

    def __init__(self, binding: ModuleType, host: str, port: int, answer_s: float) -> None:
        self.api, self._answer_s = binding, answer_s
        self._server = f"the simulator at {host}:{port}"
        self._lock = RLock()
        self._streams: set[tuple[Any, ...]] = set()
        self._client: int = binding.simxStart(host, port, True, True, -round(1000 * answer_s), PERIOD_MS)
        if self._client == -1:
            raise NoServerError(
                f"no server answers at {host}:{port}. Start the simulator, name its port with --port, or end the "
                "program that uses this port",
                address=f"{host}:{port}",
            )

    @property
    def is_connected(self) -> bool:
        return bool(self.api.simxGetConnectionId(self._client) != -1)

    @property
    def server_state(self) -> int:
        """The state of the simulation. Bit 0 is set while it runs or is paused, and bit 1 while it is paused."""
        self.call("simxGetPingTime")
        _, state = self.api.simxGetInMessageInfo(self._client, _SERVER_STATE)  # this function returns 1 for success
        return int(state)

    @property
    def time_s(self) -> float:
        """The newest time of the simulation that the server has sent, in seconds."""
        with self._lock:
            self.read_stream(self.find_name("simxGetInt32Param", "simxGetIntegerParameter"), _VERSION)
            if not self.is_connected:
                raise self._lost_error()
            return float(self.api.simxGetLastCmdTime(self._client)) / 1000

    def find_name(self, *names: str) -> str:
        """Return the first of the names for which the binding has a function. Versions of the binding differ."""
        return next((name for name in names if hasattr(self.api, name)), names[0])

    def call(self, function: str, *args: Any) -> Any:
        """Call a function that has no operation mode, and return its values without the return code."""
        with self._lock:
            return self._unwrap(getattr(self.api, function)(self._client, *args))

    def call_blocking(self, function: str, *args: Any) -> Any:
        """Call a function in blocking mode, and return its values without the return code."""
        return self.call(function, *args, self.api.simx_opmode_blocking)

    def read_stream(self, function: str, *args: Any) -> Any:
        """Return the newest values that the server has streamed for a function. The first call starts the stream."""
        stream = (function, *args)
        with self._lock:  # a blocking call removes the value of another thread's stream
            if stream in self._streams:
                mode = self.api.simx_opmode_buffer
                code, *values = getattr(self.api, function)(self._client, *args, mode)
                return self.call_blocking(function, *args) if code == _NO_VALUE else self._unwrap((code, *values))
            value = self.call_blocking(function, *args)
            getattr(self.api, function)(self._client, *args, self.api.simx_opmode_streaming)
            self._streams.add(stream)
            return value

    def send(self, function: str, *args: Any) -> None:
        """Call a function without waiting for the answer."""
        with self._lock:
            code = getattr(self.api, function)(self._client, *args, self.api.simx_opmode_oneshot)
            if code & ~_NO_VALUE or not self.is_connected:
                self._unwrap(code or _TIMEOUT)

    def close(self) -> None:
        """Wait until the server has executed the sent commands, and disconnect."""
        with self._lock:
            if self.is_connected:
                self.api.simxGetPingTime(self._client)
            self.api.simxFinish(self._client)

    def _unwrap(self, returned: Any) -> Any:
        code, *values = returned if isinstance(returned, tuple) else (returned,)
        if code == _OK:
            return values[0] if len(values) == 1 else values
        if not self.is_connected:
            raise self._lost_error()
        if code & _REMOTE:
            raise RefusedError(f"{self._server} refused the call (code {code})", code=code)
        raise ServerTimeoutError(
            f"{self._server} has not answered for {self._answer_s:g} s (code {code}). Restart the simulator", code=code
        )

    def _lost_error(self) -> RemoteApiError:
        return ServerLostError(
            f"the connection to {self._server} was lost. Check whether it was closed or its scene was stopped, "
            "start it, and run again"
        )
