"""Commands that list the installed parts: ``apps``, ``backends``, ``faults``, ``kinds``, ``robots`` and ``worlds``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import refuse_without
from robotcore.cli.output import as_json, write_content, write_json, write_lines, write_table

if TYPE_CHECKING:
    from rich.console import RenderableType

    from robotcore.runtime.settings import Setting

_COMMON_PARAMETERS = """\
Every fault takes after=SECONDS, the time when it begins, and lasts=SECONDS, its duration, on the robot's clock.
The faults lost and stall also take every=SECONDS, the interval at which they repeat until lasts=SECONDS are over."""


@click.command("apps")
@as_json
def apps(*, as_json: bool) -> None:
    """List the apps, their settings, and the devices they need."""
    from robotcore.plugins import app_names

    rows = [_app_row(name) for name in app_names()]
    if as_json:
        write_json(rows)
    else:
        write_table(("app", "needs", "settings", "effect"), map(_app_cells, rows))


@click.command("backends")
@as_json
def backends(*, as_json: bool) -> None:
    """List the backends, and which of them are installed."""
    from robotcore.plugins import backend_names

    rows = [_backend_row(name) for name in backend_names()]
    if as_json:
        write_json(rows)
    else:
        write_table(("backend", "", "capabilities", "description"), map(_backend_cells, rows))


@click.command("faults")
@as_json
def faults(*, as_json: bool) -> None:
    """List the faults that --fault injects, and their targets."""
    from robotcore.plugins import fault_names

    rows = [_fault_row(name) for name in fault_names()]
    if as_json:
        write_json(rows)
    else:
        write_table(("fault", "on", "parameters", "example", "effect"), map(_fault_cells, rows))
        write_lines(f"\n{_COMMON_PARAMETERS}")


@click.command("kinds")
@as_json
def kinds(*, as_json: bool) -> None:
    """List the kinds of devices, their keys and their drivers."""
    from robotcore.plugins import kind_names

    rows = [_kind_row(name) for name in kind_names()]
    if as_json:
        write_json(rows)
    else:
        write_table(("kind", "keys", "values", "drivers", "description"), map(_kind_cells, rows))


@click.command("robots")
@click.argument("name", required=False)
@as_json
def robots(name: str | None, *, as_json: bool) -> None:
    """List the robots that --robot accepts by name.

    With NAME, print the file of that robot. Copy it to change it: `robotcore robots rover > my_robot.toml`.
    """
    from robotcore.description import read_shipped, robot_names

    if name is not None:
        refuse_without("the list of robots", "Leave it out to print a robot's file", json=as_json)
        write_content(read_shipped(name))
        return
    rows = [_robot_row(each) for each in robot_names()]
    if as_json:
        write_json(rows)
    else:
        cells = ((each["name"], "\n".join(each["devices"]), each["summary"]) for each in rows)
        write_table(("robot", "devices", "description"), cells)


@click.command("worlds")
@click.argument("name", required=False)
@as_json
def worlds(name: str | None, *, as_json: bool) -> None:
    """List the worlds that --world accepts by name.

    With NAME, print the file of that world. Copy it to change it: `robotcore worlds arena > my_world.toml`.
    """
    from robotcore.description import read_shipped, world_names

    if name is not None:
        refuse_without("the list of worlds", "Leave it out to print a world's file", json=as_json)
        write_content(read_shipped(name, "world"))
        return
    rows = [_world_row(name) for name in world_names()]
    if as_json:
        write_json(rows)
    else:
        write_table(("world", "floor", "obstacles", "targets", "description"), map(_world_cells, rows))


def _app_row(name: str) -> dict[str, Any]:
    """Return a row of ``robotcore apps``.

    The JSON keys:

    name: text; the name of the app.
    summary: text; the first line of its docstring, or why it cannot be imported.
    needs: list of text; the roles and devices that the app needs.
    milestones: list of text; the names of its milestones, in their order.
    settings: list of objects; its settings.
    settings[].name: text; the name for ``--set``.
    settings[].type: text; the type in Python, such as ``float``.
    settings[].default: text, number, true, false or null; the default.
    """
    from robotcore.errors import BackendMissingError
    from robotcore.runtime.apps import load_app
    from robotcore.runtime.needs import name_need
    from robotcore.runtime.settings import list_settings

    try:
        app = load_app(name)
    except BackendMissingError as error:
        return {"name": name, "summary": str(error), "needs": [], "milestones": [], "settings": []}
    return {
        "name": name,
        "summary": (app.__doc__ or "").strip().partition("\n")[0],
        "needs": sorted(map(name_need, app.needs)),
        "milestones": list(app.milestones),
        "settings": [_setting_row(setting) for setting in list_settings(app).values()],
    }


def _setting_row(setting: Setting) -> dict[str, Any]:
    has_plain_default = setting.default is None or isinstance(setting.default, (bool, int, float, str))
    return {
        "name": setting.name,
        "type": _format_bare_type(setting.type),
        "default": setting.default if has_plain_default else str(setting.default),
    }


def _format_bare_type(kind: Any) -> str:
    bare = getattr(kind, "__origin__", kind) if hasattr(kind, "__metadata__") else kind
    return bare.__name__ if isinstance(bare, type) else str(bare)


def _app_cells(app: dict[str, Any]) -> tuple[str, ...]:
    settings = "\n".join(f"{each['name']}={each['default']} ({each['type']})" for each in app["settings"])
    return app["name"], ", ".join(app["needs"]), settings, app["summary"]


def _backend_row(name: str) -> dict[str, Any]:
    """Return a row of ``robotcore backends``.

    The JSON keys:

    name: text; the name of the backend.
    installed: true or false; whether the packages that it needs are installed.
    summary: text; a description in a few words.
    vouches_for: list of text; its capabilities.
    remedy: text or null; how to install the missing packages. Null if it is installed.
    """
    from robotcore.errors import BackendMissingError
    from robotcore.hal.backend import load_backend

    try:
        backend = load_backend(name)
    except BackendMissingError as error:
        return {"name": name, "installed": False, "summary": "", "vouches_for": [], "remedy": str(error)}
    return {
        "name": name,
        "installed": backend.is_installed,
        "summary": backend.summary,
        "vouches_for": sorted(capability.value for capability in backend.capabilities),
        "remedy": None if backend.is_installed else backend.remedy,
    }


def _backend_cells(backend: dict[str, Any]) -> tuple[RenderableType, ...]:
    from rich.text import Text

    status = Text("installed", "green") if backend["installed"] else Text("missing", "red")
    summary = "\n".join(filter(None, (backend["summary"], backend["remedy"])))
    return backend["name"], status, ", ".join(backend["vouches_for"]), summary


def _fault_row(name: str) -> dict[str, Any]:
    """Return a row of ``robotcore faults``.

    The JSON keys:

    name: text; the name of the fault.
    on: list of text; the kinds of devices that the fault affects.
    parameters: list of objects; its parameters.
    parameters[].*: robotcore.runtime.faults.spec.Parameter
    example: text; a value for ``--fault``.
    summary: text; the first line of its docstring, or why it cannot be imported.
    """
    from robotcore.errors import BackendMissingError
    from robotcore.runtime.faults.planning import load_fault, read_effect, targets_for
    from robotcore.runtime.faults.spec import parameters_of

    effect = read_effect(name)
    try:
        fault = load_fault(name)
    except BackendMissingError as error:
        return {"name": effect, "on": [], "parameters": [], "example": "", "summary": str(error)}
    return {
        "name": effect,
        "on": targets_for(name),
        "parameters": [each._asdict() for each in parameters_of(effect, fault)],
        "example": fault.example,
        "summary": (fault.__doc__ or "").strip().partition("\n")[0],
    }


def _fault_cells(fault: dict[str, Any]) -> tuple[str, ...]:
    own = (each for each in fault["parameters"] if each["name"] not in ("after", "lasts"))
    parameters = "\n".join(f"{each['name']}: {each['unit']}, {each['limits']}".removesuffix(", ") for each in own)
    return fault["name"], ", ".join(fault["on"]), parameters, fault["example"], fault["summary"]


def _kind_row(name: str) -> dict[str, Any]:
    """Return a row of ``robotcore kinds``.

    The JSON keys:

    name: text; the name of the kind.
    summary: text; a description in a few words, or why it cannot be imported.
    keys: list of text; the keys of its table ``[[devices]]`` in a robot's file, without ``kind`` and ``name``.
    values: list of objects; the numbers of a sample. Empty without samples of numbers.
    values[].*: robotcore.hal.device.Value
    drivers: list of text; the names of its device drivers.
    simulated: true or false; whether simulators have devices of this kind.
    """
    from robotcore.errors import BackendMissingError, UsageError
    from robotcore.hal.device import list_values
    from robotcore.hal.kind import load_kind
    from robotcore.hardware import list_drivers

    try:
        kind = load_kind(name)
    except (BackendMissingError, UsageError) as error:
        return {"name": name, "summary": str(error), "keys": [], "values": [], "drivers": [], "simulated": False}
    return {
        "name": name,
        "summary": kind.summary,
        "keys": [key for key in kind.description.model_fields if key not in ("kind", "name")],
        "values": [each._asdict() for each in list_values(kind.sample)] if kind.sample else [],
        "drivers": list_drivers(kind.description),
        "simulated": kind.is_simulated,
    }


def _kind_cells(kind: dict[str, Any]) -> tuple[str, ...]:
    units = ((each["field"], each["unit"]) for each in kind["values"])
    values = "\n".join(f"{field} ({unit})" if unit else field for field, unit in units)
    return kind["name"], "\n".join(kind["keys"]), values, "\n".join(kind["drivers"]), kind["summary"]


def _robot_row(name: str) -> dict[str, Any]:
    """Return a row of ``robotcore robots``.

    The JSON keys:

    name: text; the name of the robot.
    summary: text; a description in a few words.
    drives: true or false; whether the robot has a drive.
    devices: list of text; the names of its devices.
    """
    from robotcore.description import load_robot

    robot = load_robot(name)
    return {
        "name": name,
        "summary": robot.summary,
        "drives": robot.drive is not None,
        "devices": [device.name for device in robot.devices],
    }


def _world_row(name: str) -> dict[str, Any]:
    """Return a row of ``robotcore worlds``.

    The JSON keys:

    name: text; the name of the world.
    summary: text; a description in a few words.
    floor_m: list of two numbers, m; the length and the width of the floor.
    obstacles: whole number; the number of obstacles.
    targets: whole number; the number of targets.
    varies: true or false; whether ``--seed`` changes the world.
    """
    from robotcore.description import load_world

    world = load_world(name)
    return {
        "name": name,
        "summary": world.summary,
        "floor_m": [world.floor.length_m, world.floor.width_m],
        "obstacles": len(world.obstacles),
        "targets": len(world.targets),
        "varies": world.variation is not None,
    }


def _world_cells(world: dict[str, Any]) -> tuple[str, ...]:
    length, width = world["floor_m"]
    floor = f"{length:g} m x {width:g} m"
    return world["name"], floor, str(world["obstacles"]), str(world["targets"]), world["summary"]
