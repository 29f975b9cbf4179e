"""Lua that a client brings along."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene.errors import NoObjectError
from tests.doubles.coppeliasim.scene.objects import Script
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session


@function("createScript")
def create_script(session: Session, kind: int, text: str, options: int = 0, language: str = "lua") -> int:
    return session.simulator.graph.add(Script("script", text=text)).handle


@function("initScript")
def init_script(session: Session, script: Script) -> None:
    session.shared.scripts.begin(script)


@function("callScriptFunction")
def call_script_function(session: Session, name: str, handle: int, *args: Any) -> tuple[Any, ...]:
    script = session.simulator.graph.get(handle)
    if not isinstance(script, Script):
        raise NoObjectError("script does not exist.")
    return session.shared.scripts.call(script, name, args)
