"""From a request to a reply: functions by name, Lua, and what is said where either fails."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.zmq.functions import FUNCTIONS
from tests.doubles.coppeliasim.zmq.session import Session
from tests.doubles.coppeliasim.zmq.table import table

WHERE = "354: in {}"
"""The line of the server's script that calls what a client asks for; its errors begin with it."""

Reply = dict[str, Any]


class NoFunctionError(Exception):
    """There is no function of that name, on a real server neither."""


def answer(session: Session, request: dict[str, Any]) -> Reply:
    """Return the reply to a request; raise `Waiting` where it is to come later."""
    if text := request.get("eval"):
        return _evaluated(session, text)
    name, args = request.get("func", ""), list(request.get("args") or [])
    try:
        return ret(_called(session, name, args))
    except SceneError as error:
        return {"err": f"{getattr(error, 'where', WHERE.format(name))}: {error}"}
    except NoFunctionError as error:
        return {"err": str(error)}
    except (TypeError, ValueError, LookupError, AttributeError) as error:  # arguments of other kinds than are foreseen
        return {"err": f"{WHERE.format(name)}: the double makes nothing of these arguments ({error})"}


def ret(values: list[Any]) -> Reply:
    """Return the reply with these values; none at all are an empty map, as an empty table of Lua's is."""
    return {"ret": values or {}}


def _called(session: Session, name: str, args: list[Any]) -> list[Any]:
    if name in session.shared.services:
        return [session.shared.services[name](*args)]
    if name == "zmqRemoteApi.require":
        return _required(args)
    if name == "zmqRemoteApi.info":
        return [table()] if args == ["sim"] else [{}]
    module, _, function = name.partition(".")
    if module == "sim" and function in FUNCTIONS:
        return FUNCTIONS[function](session, args)
    if module == "sim" and function in table():
        raise SceneError("the double of the simulator lacks this function; add it to tests/doubles/coppeliasim.")
    raise NoFunctionError(f"No such function: {name}")


def _required(args: list[Any]) -> list[Any]:
    if args != ["sim"]:
        raise SceneError(f"the double of the simulator has the module sim only, not {args}.")
    return []


def _evaluated(session: Session, text: str) -> Reply:
    try:
        return ret(list(session.shared.scripts.evaluate(text)))
    except SceneError as error:
        return {"err": str(error)}
