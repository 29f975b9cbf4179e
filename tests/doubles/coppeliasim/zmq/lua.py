"""Run the Lua code of clients, which can call the same ``sim`` functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Script
from tests.doubles.coppeliasim.zmq.functions.registry import FUNCTIONS
from tests.doubles.coppeliasim.zmq.session import Session, constants

NOT_BEGUN = "script is not initialized (or has already ended)"


class LuaError(SceneError):
    """An error in Lua code. Its text contains the line."""


@dataclass(frozen=True)
class Buffer:
    """Bytes from the simulator. Lua gets them as bytes, even if they are text."""

    content: bytes


class Scripts:
    """The scripts of a server, each with its own globals, and the globals of ``eval``."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._running: dict[Script, Chunk] = {}
        self._console: Chunk | None = None

    def begin(self, script: Script) -> None:
        """Run the text of a script, unless it has been run."""
        self._running[script] = Chunk(self._session, script.text)

    def call(self, script: Script, name: str, args: Sequence[Any]) -> tuple[Any, ...]:
        """Call a function of a script, and return its results. An error ends the script."""
        if script not in self._running:
            raise SceneError(NOT_BEGUN)
        function = self._running[script].function(name)
        if function is None:
            raise SceneError("failed calling script function.")
        try:
            return function(*args)
        except Exception as error:
            del self._running[script]
            raise SceneError("error in script function.") from error

    def evaluate(self, text: str) -> tuple[Any, ...]:
        """Run Lua code, and return its results."""
        self._console = self._console or Chunk(self._session, "sim=require'sim'")
        return self._console.run(text)


class Chunk:
    """A Lua interpreter that has run a text. Its ``require`` supports ``sim`` only, and its ``print`` does nothing."""

    def __init__(self, session: Session, text: str) -> None:
        from lupa import LuaRuntime

        self._lua = LuaRuntime(encoding=None, unpack_returned_tuples=True)
        functions = {name: self._wrap(name, partial(call, session)) for name, call in FUNCTIONS.items()}
        self._sim = self._to_table({**constants(), **functions})
        self._lua.globals()[b"require"] = self._require
        self._lua.globals()[b"print"] = lambda *_: None
        self._lua.execute(text.encode())

    def function(self, name: str) -> Callable[..., tuple[Any, ...]] | None:
        """Return a global Lua function as a Python function; None if there is none."""
        body = self._lua.globals()[name.encode()]
        return partial(self._call, body) if body is not None else None

    def run(self, text: str) -> tuple[Any, ...]:
        """Run code, and return its results."""
        from lupa import LuaError as Failure

        try:
            return self._to_python_values(self._lua.execute(text.encode()))
        except Failure as error:
            raise LuaError(str(error)) from error

    def _call(self, body: Callable[..., Any], *args: Any) -> tuple[Any, ...]:
        return self._to_python_values(body(*map(self._to_table, args)))

    def _require(self, name: bytes) -> Any:
        if name != b"sim":
            raise SceneError(f"the double has no module {name.decode()}.")
        return self._sim

    def _wrap(self, name: str, call: Callable[[list[Any]], list[Any]]) -> Callable[..., Any]:
        def wrapped(*args: Any) -> Any:
            try:
                return tuple(self._to_lua(each) for each in call([_to_python(arg) for arg in args]))
            except SceneError as error:
                raise LuaError(f"1: in sim.{name}: {error}") from error

        return wrapped

    def _to_lua(self, value: Any) -> Any:
        return Buffer(value) if isinstance(value, bytes) else self._to_table(value)

    def _to_python_values(self, values: Any) -> tuple[Any, ...]:
        if values is None:
            return ()
        return tuple(map(_to_python, values)) if isinstance(values, tuple) else (_to_python(values),)

    def _to_table(self, value: Any) -> Any:
        if isinstance(value, str):
            return value.encode()
        if isinstance(value, (list, tuple)):
            return self._lua.table_from([self._to_table(each) for each in value])
        if isinstance(value, dict):
            return self._lua.table_from({self._to_table(key): self._to_table(each) for key, each in value.items()})
        return value


def _to_python(value: Any) -> Any:
    from lupa import lua_type

    if isinstance(value, Buffer):
        return value.content
    if isinstance(value, bytes):
        return _decode_text(value)
    if lua_type(value) != "table":
        return value
    items = {_to_python(key): _to_python(each) for key, each in value.items()}
    is_list = bool(items) and list(items) == list(range(1, len(items) + 1))
    return list(items.values()) if is_list else items


def _decode_text(value: bytes) -> str | bytes:
    try:
        return value.decode()
    except UnicodeDecodeError:
        return value
