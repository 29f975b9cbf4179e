"""Tables of the keys that a command with ``--json`` prints.

A key is documented in one place: below the field of a dataclass or model, or in the docstring of the function that
builds the dict. In a docstring, the paragraph after a line that ends with ``keys:`` has a line ``KEY: VALUE; MEANING.``
for each key. ``devices[].name`` is a key of each object in a list. ``motors.MOTOR.lag_s`` is a key of each object in an
object whose keys are names. The line ``devices[].*: module.Name`` stands for all keys of another class or function;
``without KEY`` leaves one out. The meaning of a key that some answers lack contains the word "Only".
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from pkgutil import resolve_name
from types import NoneType, UnionType
from typing import Any, NamedTuple, Union, get_args, get_origin, get_type_hints

import click
from pydantic import BaseModel

from docs.generator.key_tables import read_docstrings
from robotcore.cli.command_classes import AnsweringCommand

SOURCES = {
    "run": "robotcore.runtime.result.RunResult",
    "teleop": "robotcore.runtime.result.RunResult",
    "sweep": "robotcore.cli.sweep_output._build_answer",
    "replay": "robotcore.cli.recordings._build_replay_answer",
    "replay with another app or with `--set`": "robotcore.cli.recordings._build_evaluation_answer",
    "compare": "robotcore.recording.run_comparison.Comparison.to_dict",
    "info": "robotcore.cli.recordings._build_info_answer",
    "fidelity": "robotcore.cli.fidelity._build_answer",
    "apps": "robotcore.cli.lists._app_row",
    "backends": "robotcore.cli.lists._backend_row",
    "faults": "robotcore.cli.lists._fault_row",
    "kinds": "robotcore.cli.lists._kind_row",
    "robots": "robotcore.cli.lists._robot_row",
    "worlds": "robotcore.cli.lists._world_row",
    "wiring": "robotcore.cli.wiring._build_answer",
    "calibrate motors": "robotcore.cli.calibrate.motors._build_answer",
    "calibrate drive": "robotcore.cli.calibrate.drive._build_answer",
    "calibrate camera": "robotcore.cli.calibrate.camera_parts.CameraParts.to_dict",
    "calibrate range": "robotcore.cli.calibrate.range._build_answer",
    "doctor": "robotcore.cli.doctor._build_answer",
    "doctor with `--loopback`": "robotcore.cli.doctor.loopback._build_answer",
    "test-devices": "robotcore.cli.test_devices._build_answer",
    "deploy list": "robotcore.cli.deploy.list._build_answer",
    "deploy status": "robotcore.cli.deploy.app._build_answer",
    "deploy fetch": "robotcore.cli.deploy.fetch._build_answer",
}
"""The classes and functions with the keys, by the words of the command after ``robotcore``.

With the options after `VARIANT`, the command has other keys.
"""

VARIANT = " with "

LIST_COMMANDS = frozenset({"apps", "backends", "faults", "kinds", "robots", "worlds"})
"""The commands that print a list of objects."""

WORDS = {str: "text", int: "whole number", float: "number", bool: "true or false", NoneType: "null"}
PLURALS = {"whole number": "whole numbers", "number": "numbers", "object": "objects"}
LINE = re.compile(r"([\w.*\[\]]+): +(.*)")


class Key(NamedTuple):
    """The type or unit of the value of a key, and its meaning."""

    value: str
    meaning: str

    @property
    def is_optional(self) -> bool:
        """Whether some answers lack the key."""
        return "Only " in self.meaning


def has_json(command: click.Command) -> bool:
    """Return whether a command has the option ``--json``."""
    return any("--json" in each.opts for each in command.params)


def format_json_section(words: str, command: click.Command) -> Iterator[str]:
    """Yield the paragraphs about the JSON of a command.

    words: the words of the command after ``robotcore``.
    """
    form = "a list of objects" if words in LIST_COMMANDS else "an object"
    yield f"With `--json`, the command prints one line: {form} with these keys. {_explain_keys(words, command)}"
    yield _format_keys(find_keys(words, command))
    for more in (each for each in SOURCES if each.startswith(f"{words}{VARIANT}")):
        yield f"With {more.partition(VARIANT)[2]}, the keys are:"
        yield _format_keys(find_keys(more, command))


def _explain_keys(words: str, command: click.Command) -> str:
    """Return sentences about the answer after an error, and about the parts of keys that are no names."""
    is_answering = isinstance(command, AnsweringCommand)
    sentences = [
        "After an error without a result, the object has `error` and `kind`, and may lack other keys."
        if is_answering
        else "If an error ends the command, it prints no JSON."
    ]
    variants = [each for each in SOURCES if each.partition(VARIANT)[0] == words]
    parts = [part for each in variants for key in find_keys(each, command) for part in key.split(".")]
    if any(part.endswith("[]") for part in parts):
        sentences.append("`[]` stands for each item of a list.")
    sentences += [f"`{name}` stands for each key of that object." for name in dict.fromkeys(filter(str.isupper, parts))]
    return " ".join(filter(None, sentences))


def find_keys(words: str, command: click.Command) -> dict[str, Key]:
    """Return the keys that a command prints.

    words: a key of `SOURCES`. Raises KeyError for another one.
    """
    failure = f"{type(command).__module__}.{type(command).__qualname__}.build_failure_answer"
    own = read_keys(SOURCES[words])
    return {**own, **(_leave_out(read_keys(failure), own) if isinstance(command, AnsweringCommand) else {})}


def read_keys(source: str, prefix: str = "") -> dict[str, Key]:
    """Return the keys of a class with documented fields, or those in the docstring of a function.

    source: the module and the name.
    prefix: the key that contains the object, such as ``devices[].``.
    """
    found = resolve_name(source)
    if isinstance(found, type) and (is_dataclass(found) or issubclass(found, BaseModel) or hasattr(found, "_fields")):
        return _read_fields(found, prefix)
    return _read_docstring(found, prefix)


def _read_docstring(documented: Any, prefix: str) -> dict[str, Key]:
    keys: dict[str, Key] = {}
    _, _, text = re.sub(r"\n +", " ", inspect.getdoc(documented) or "").partition("keys:\n\n")
    for line in text.partition("\n\n")[0].splitlines():
        if not (matched := LINE.fullmatch(line)):
            raise ValueError(f"{documented.__qualname__}: the line {line!r} is not 'KEY: VALUE; MEANING.'")
        key, words = matched.groups()
        if key.endswith("*"):
            source, _, without = words.partition(" without ")
            keys |= _leave_out(read_keys(source, inner := f"{prefix}{key[:-1]}"), {*keys, f"{inner}{without}"})
        else:
            value, _, meaning = words.partition("; ")
            keys[f"{prefix}{key}"] = Key(value, f"{meaning[:1].upper()}{meaning[1:]}")
    return keys


def _read_fields(model: type, prefix: str) -> dict[str, Key]:
    keys: dict[str, Key] = {}
    hints, texts = get_type_hints(model), read_docstrings(model)
    names = (
        [each.name for each in fields(model)]
        if is_dataclass(model)
        else [*getattr(model, "model_fields", getattr(model, "_fields", ()))]
    )
    for name in names:
        if hints[name] == BaseException | None:
            continue
        keys[f"{prefix}{name}"] = Key(_name_type(hints[name]), _translate(texts.get(name, "")))
        for inner, suffix in _list_objects(hints[name]):
            keys |= _leave_out(_read_fields(inner, f"{prefix}{name}{suffix}."), keys)
    return keys


def _list_objects(annotation: Any, suffix: str = "") -> Iterator[tuple[type, str]]:
    """Yield the documented classes in an annotation, each with the end of the key of its object."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if isinstance(annotation, type) and (is_dataclass(annotation) or issubclass(annotation, BaseModel)):
        yield annotation, suffix
    elif origin in (Union, UnionType):
        for each in parts:
            yield from _list_objects(each, suffix)
    elif isinstance(origin, type) and issubclass(origin, Mapping):
        yield from _list_objects(parts[1], f"{suffix}.NAME")
    elif isinstance(origin, type) and issubclass(origin, Sequence):
        yield from _list_objects(parts[0], f"{suffix}[]")


def _name_type(annotation: Any) -> str:
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin in (Union, UnionType):
        *words, last = dict.fromkeys(" or ".join(map(_name_type, parts)).split(" or "))
        return f"{', '.join(words)} or {last}" if words else last
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return f"text: {', '.join(f'``{each.value}``' for each in annotation)}"
    if isinstance(annotation, type) and issubclass(annotation, tuple):  # a NamedTuple, which json writes as a list
        origin, parts = annotation, tuple(get_type_hints(annotation).values())
    if isinstance(origin, type) and issubclass(origin, Sequence):
        return f"list of {PLURALS.get(word := _name_type(parts[0]), word)}"
    if isinstance(origin, type) and issubclass(origin, Mapping) and parts[1] in WORDS:
        return f"object of {PLURALS.get(word := WORDS[parts[1]], word)}"
    return WORDS.get(annotation, "object")


def _translate(text: str) -> str:
    """Return a text about a field with the words of JSON for those of Python.

    >>> _translate("None if it is unknown. It is not False.")
    'Null if it is unknown. It is not false.'
    """
    text = re.sub(r"(^|[.] )None\b", r"\1Null", text)
    return re.sub(r"\b(None|True|False)\b", lambda found: {"None": "null"}.get(found[0], found[0].lower()), text)


def _leave_out(keys: dict[str, Key], known: Container[str]) -> dict[str, Key]:
    return {key: each for key, each in keys.items() if key not in known}


def _format_keys(keys: Mapping[str, Key]) -> str:
    rows = (f"| `{name}` | {_escape(key.value)} | {_escape(key.meaning)} |" for name, key in keys.items())
    return "\n".join(["| key | value | meaning |", "| --- | --- | --- |", *rows])


def _escape(text: str) -> str:
    return text.replace("``", "`").replace("|", "\\|").replace("<", "&lt;")
