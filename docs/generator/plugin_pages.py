"""Pages of the reference about the parts that robotcore finds by entry points, and about the keys of files."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from docs.generator.key_tables import format_keys, list_tables, read_summary
from robotcore.description import RobotDescription, WorldDescription
from robotcore.description.types import StrictModel
from robotcore.hal.backend import Backend, load_backend
from robotcore.hal.device import list_values
from robotcore.hal.kind import load_kind
from robotcore.plugins import (
    DEVICES,
    app_names,
    backend_names,
    device_driver_names,
    fault_names,
    kind_names,
    load_registered,
)
from robotcore.runtime.apps import load_app
from robotcore.runtime.faults.planning import load_fault, read_effect, targets_for
from robotcore.runtime.faults.spec import parameters_of
from robotcore.runtime.needs import name_need
from robotcore.runtime.settings import list_settings


def list_plugin_pages() -> Iterator[tuple[str, str]]:
    """Yield the name of each page, and its Markdown."""
    yield "robot-file.md", _format_file_page(RobotDescription, "The keys of a robot's file", "descriptions.md")
    yield "world-file.md", _format_file_page(WorldDescription, "The keys of a world's file", "descriptions.md#a-world")
    yield "device-kinds.md", _format_kinds_page()
    yield "device-drivers.md", _format_drivers_page()
    yield "backends.md", _format_backends_page()
    yield "faults.md", _format_faults_page()
    yield "apps.md", _format_apps_page()


def _format_file_page(model: type[StrictModel], title: str, guide: str) -> str:
    version = 'The key `robotcore` names [the versions that can read the file](../compatibility.md), such as `">=0.1"`.'
    parts = [
        f"# {title}",
        f"[The guide](../{guide}) shows complete files. {version}",
        "## The file",
        format_keys(model),
    ]
    parts += _format_tables(model)
    if model is RobotDescription:
        parts += ["## Devices", "Each table `[[devices]]` has the keys of its [kind](device-kinds.md)."]
    return _join(parts)


def _format_tables(*models: type[BaseModel]) -> list[str]:
    """Return a section for each table that the keys of the models contain."""
    tables = dict.fromkeys(table for model in models for table in list_tables(model))
    return [part for each in tables for part in (f"## {each.__name__}", read_summary(each), format_keys(each))]


def _format_kinds_page() -> str:
    parts = ["# Kinds of devices", "The `kind` of a table `[[devices]]` in a robot's file. [The guide](../kinds.md)."]
    kinds = {name: load_kind(name) for name in kind_names()}
    for name, kind in kinds.items():
        parts += [f"## {name}", f"{_capitalise(kind.summary)}: `robotcore.kinds.{kind.device.__name__}`."]
        parts += [format_keys(kind.description, ("kind",))]
        if kind.sample:
            parts += ["A sample has these values:", _format_values(kind.sample)]
        drivers = [each for each in device_driver_names() if issubclass(kind.description, _load_driver(each).described)]
        parts += (
            [f"Drivers: {', '.join(f'[`{each}`](device-drivers.md#{each})' for each in drivers)}."] if drivers else []
        )
    return _join(parts + _format_tables(*(kind.description for kind in kinds.values())))


def _format_values(sample: type) -> str:
    rows = ["| value | unit |", "| --- | --- |"]
    rows += [f"| `{value.field}` | {value.unit} |" for value in list_values(sample)]
    return "\n".join(rows) if len(rows) > 2 else f"It is a `{sample.__name__}`."


def _format_drivers_page() -> str:
    parts = [
        "# Device drivers",
        "The `driver` of a device's table, such as `[raspberrypi.nose]`, and the other keys of the table.",
    ]
    drivers = {name: _load_driver(name) for name in device_driver_names()}
    for name, driver in drivers.items():
        parts += [f"## {name}", f"{_capitalise(driver.summary)}. {read_summary(driver)}", format_keys(driver)]
        parts += [f"It needs: `{driver.remedy}`." if driver.remedy.startswith("pip") else driver.remedy]
    return _join(parts + _format_tables(*drivers.values()))


def _load_driver(name: str) -> Any:
    return load_registered("device driver", DEVICES, name)


def _format_backends_page() -> str:
    parts = ["# Backends", "`--backend NAME` chooses a backend, and `--option KEY=VALUE` sets an option."]
    for name in backend_names():
        backend = load_backend(name)
        can = ", ".join(sorted(capability.value for capability in backend.capabilities))
        parts += [f"## {name}", f"{_capitalise(backend.summary)}.", f"Capabilities: {can}." if can else ""]
        options = _find_options(backend)
        parts += [format_keys(options) if options else "It has no options."]
    return _join(parts)


def _find_options(backend: Backend) -> type[StrictModel] | None:
    """Return the model of a backend's options, which its module uses."""
    values = vars(sys.modules[type(backend).__module__]).values()
    models = [each for each in values if inspect.isclass(each) and issubclass(each, StrictModel)]
    own = [each for each in models if each.__name__.endswith("Options")]
    return max(own, key=lambda each: len(each.model_fields), default=None)


def _format_faults_page() -> str:
    parts = [
        "# Faults",
        '`--fault "TARGET EFFECT=VALUE"` injects a fault: [the guide](../faults.md).',
        "Every fault takes `after` and `lasts` in seconds.",
    ]
    for name in fault_names():
        effect, fault = read_effect(name), load_fault(name)
        parts += [f"## {name}", read_summary(fault), f"On: {', '.join(targets_for(name))}."]
        rows = [
            f"| `{each.name}` | {each.unit} | {each.limits} |"
            for each in parameters_of(effect, fault)
            if each.name not in ("after", "lasts")
        ]
        parts += ["\n".join(["| parameter | unit | limits |", "| --- | --- | --- |", *rows])] if rows else []
        parts += [f'```text\n--fault "{fault.example}"\n```']
    return _join(parts)


def _format_apps_page() -> str:
    parts = ["# Apps", "`robotcore run NAME` runs an app, and `--set KEY=VALUE` changes a setting."]
    for name in app_names():
        app = load_app(name)
        needs = ", ".join(sorted(map(name_need, app.needs)))
        parts += [f"## {name}", read_summary(app), f"It needs: {needs}." if needs else ""]
        rows = [f"| `{each.name}` | `{each.default}` |" for each in list_settings(app).values()]
        parts += ["\n".join(["| setting | default |", "| --- | --- |", *rows])] if rows else []
    return _join(parts)


def _capitalise(text: str) -> str:
    return text[:1].upper() + text[1:]


def _join(parts: list[str]) -> str:
    """Return the Markdown of a page. A path such as ``docs/safety.md`` becomes a link."""
    text = "\n\n".join(filter(None, parts)) + "\n"
    return re.sub(r"docs/([\w-]+)\.md", r"[\1](../\1.md)", text)
