"""The registry of ``sim`` functions, and the conversion of their arguments.

Functions have Python's types. A client's arguments are converted to them, or refused in the server's words. An object's
type (``joint: Joint``) accepts a handle.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any, TypeVar, get_type_hints

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import (
    ForceSensor,
    Joint,
    Lamp,
    Node,
    ProximitySensor,
    Script,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.zmq.session import Session

Function = Callable[..., Any]
FunctionT = TypeVar("FunctionT", bound=Function)
FUNCTIONS: dict[str, Call] = {}
"""The functions by name, such as ``getObject``."""

KINDS: dict[type[Node], str] = {
    Joint: "joint",
    Lamp: "light",
    Shape: "shape",
    VisionSensor: "vision sensor",
    ProximitySensor: "proximity sensor",
    ForceSensor: "force sensor",
    Script: "script",
}


class Call:
    """A registered function. A call converts the arguments of a client to the types of the parameters."""

    def __init__(self, function: Function) -> None:
        self._function = function
        hints = get_type_hints(function)
        parameters = list(inspect.signature(function).parameters.values())[1:]
        self._kinds = [hints[each.name] for each in parameters if each.kind is not each.VAR_POSITIONAL]
        self._least = sum(each.default is each.empty and each.kind is not each.VAR_POSITIONAL for each in parameters)
        self._takes_more = any(each.kind is each.VAR_POSITIONAL for each in parameters)

    def __call__(self, session: Session, args: Sequence[Any]) -> list[Any]:
        """Call the function, and return its results. Raises SceneError if the call is refused."""
        if len(args) < self._least:
            raise SceneError("the function requires more arguments.")
        typed = [
            _convert(session, kind, arg, i) for i, (kind, arg) in enumerate(zip(self._kinds, args, strict=False), 1)
        ]
        more = args[len(self._kinds) :] if self._takes_more else ()
        answer = self._function(session, *typed, *more)
        if answer is None:
            return []
        return list(answer) if isinstance(answer, tuple) else [answer]


def function(name: str) -> Callable[[FunctionT], FunctionT]:
    """Return a decorator that registers a function under its name in the API."""

    def register(body: FunctionT) -> FunctionT:
        FUNCTIONS[name] = Call(body)
        return body

    return register


def floats(numbers: Sequence[Any], count: int) -> list[float]:
    """Return the first ``count`` numbers of a table. Raises SceneError if there are fewer."""
    if len(numbers) < count:
        raise SceneError("incorrect table size.")
    return [float(number) for number in numbers[:count]]


def _convert(session: Session, kind: Any, arg: Any, place: int) -> Any:
    if isinstance(kind, type) and issubclass(kind, Node):
        return _find_node(session, kind, _number(arg, place))
    if kind is float:
        return float(_number(arg, place))
    if kind is int:
        return int(_number(arg, place))
    if kind is str and not isinstance(arg, str):
        raise SceneError(f"argument {place} is not a string/buffer.")
    if kind is list and not isinstance(arg, list):
        raise SceneError(f"argument {place} is not a table.")
    return arg


def _number(arg: Any, place: int) -> float:
    if isinstance(arg, bool) or not isinstance(arg, (int, float)):
        raise SceneError(f"argument {place} is not a number.")
    return arg


def _find_node(session: Session, kind: type[Node], handle: float) -> Node:
    node = session.simulator.graph[int(handle)]
    if not isinstance(node, kind):
        raise SceneError(f"object is not a {KINDS[kind]}.")
    return node
