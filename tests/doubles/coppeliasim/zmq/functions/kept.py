"""Signals and data that somebody leaves with the simulator."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene.objects import Thing
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session


@function("setStringSignal")
def set_string_signal(session: Session, name: str, value: Any) -> int:
    session.shared.signals[name] = value
    return 1


@function("getStringSignal")
def get_string_signal(session: Session, name: str) -> Any:
    return session.shared.signals.get(name)


@function("setInt32Signal")
def set_int32_signal(session: Session, name: str, value: int) -> int:
    session.shared.signals[name] = value
    return 1


@function("getInt32Signal")
def get_int32_signal(session: Session, name: str) -> Any:
    return session.shared.signals.get(name)


@function("setFloatSignal")
def set_float_signal(session: Session, name: str, value: float) -> int:
    session.shared.signals[name] = value
    return 1


@function("getFloatSignal")
def get_float_signal(session: Session, name: str) -> Any:
    return session.shared.signals.get(name)


@function("writeCustomStringData")
def write_custom_string_data(session: Session, thing: Thing, tag: str, data: str) -> int:
    session.shared.kept[thing, "data", tag] = data
    return 1


@function("readCustomStringData")
def read_custom_string_data(session: Session, thing: Thing, tag: str) -> Any:
    return session.shared.kept.get((thing, "data", tag))


@function("setNamedStringParam")
def set_named_string_param(session: Session, name: str, value: str) -> int:
    session.shared.kept["named", name] = value
    return 1


@function("getNamedStringParam")
def get_named_string_param(session: Session, name: str) -> bytes | None:
    value = session.shared.kept.get(("named", name))
    return None if value is None else value.encode()
