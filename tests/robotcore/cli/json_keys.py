"""Compare the keys of an answer in JSON with those that the reference lists."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import click

from docs.generator.json_tables import LIST_COMMANDS, VARIANT, Key, find_keys
from robotcore.cli.main import robotcore


def list_commands(group: click.Group = robotcore, words: str = "") -> Iterator[tuple[str, click.Command]]:
    """Yield each command with its words after ``robotcore``."""
    for name in group.list_commands(click.Context(group)):
        command = group.get_command(click.Context(group), name)
        assert command
        if isinstance(command, click.Group):
            yield from list_commands(command, f"{words}{name} ")
        else:
            yield f"{words}{name}", command


COMMANDS = dict(list_commands())

WORDS = {
    dict: ("object",),
    list: ("list",),
    str: ("text",),
    bool: ("true",),
    int: ("whole number", "number"),
    float: ("number",),
    type(None): ("null",),
}
"""The words for the types of JSON, with which a type in the tables begins."""


def find_documented_keys(words: str) -> dict[str, Key]:
    """Return the keys of a command. ``words`` is a key of `SOURCES`."""
    return find_keys(words, COMMANDS[words.partition(VARIANT)[0]])


def list_disagreements(words: str, *answers: Any) -> list[str]:
    """Return the documented keys that the answers of a command lack, their other keys, and their values of other types.

    A key that is not always there may be missing, with those of its object.
    """
    documented = find_documented_keys(words)
    found = [
        f"{words}: one answer is no list" for each in answers if isinstance(each, list) != (words in LIST_COMMANDS)
    ]
    rows = [row for answer in answers for row in (answer if isinstance(answer, list) else [answer])]
    values = [pair for row in rows for pair in _list_values(row, documented)]
    printed = {key for key, _ in values}
    types = {key: each.value for key, each in documented.items()}
    found += [
        f"{key} is {each!r}, not {types[key]}"
        for key, each in values
        if key in types and not _has_type(each, types[key])
    ]
    absent = {key for key, each in documented.items() if each.is_optional} - printed
    inner = tuple(f"{key}{end}" for key in absent for end in (".", "[]"))
    missing = {key for key in documented.keys() - printed - absent if not key.startswith(inner)}
    found += [f"not printed: {key}" for key in sorted(missing)]
    return found + [f"not documented: {key}" for key in sorted(printed - documented.keys())]


def _has_type(value: Any, documented: str) -> bool:
    alternatives = re.split(", | or ", documented.partition(":")[0])
    return any(each.startswith(WORDS[type(value)]) for each in alternatives)


def _list_values(value: Any, documented: Mapping[str, Key], path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the keys and values of an object, and of the objects in it that have documented keys."""
    if isinstance(value, list):
        for each in value:
            yield from _list_values(each, documented, f"{path}[]")
    prefix = f"{path}." if path else ""
    known = {key.removeprefix(prefix).partition(".")[0] for key in documented if key.startswith(prefix)}
    if isinstance(value, dict) and known:
        variable = next((name for name in known if name.isupper()), "")
        for name, each in value.items():
            if not variable:
                yield f"{prefix}{name}", each
            yield from _list_values(each, documented, f"{prefix}{variable or name}")
