"""A page of the reference for each identifier of an error, and their index."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from docs.generator import error_catalogue
from docs.generator.error_catalogue import Entry, list_error_classes, read_catalogue
from docs.generator.key_tables import read_summary

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

NOTES = Path(__file__).with_name("error_notes.toml")
MAX_MESSAGES = 5
"""The greatest number of messages on a page."""

OWNERS = {
    "Finding": "A finding of `robotcore doctor`, `robotcore check` or `robotcore test-devices`.",
    "Mistake": "A wrong value in a file. The command raises a `DescriptionError`, exit status 2.",
    "AgentError": "An answer of the robot. `robotcore deploy` raises a `DeployError`, exit status 3.",
}
"""The sentences about errors that have no class in the tree of errors."""


def list_error_pages() -> Iterator[tuple[str, str]]:
    """Yield the name of each page, and its Markdown."""
    catalogue = read_catalogue()
    yield "index.md", _format_index(catalogue)
    for entry in catalogue.values():
        yield f"{entry.kind}.md", _format_page(entry)


@cache
def read_notes() -> dict[str, Any]:
    """Return the notes about errors whose messages have no cause or no remedy, by identifier."""
    return tomllib.loads(NOTES.read_text(encoding="utf-8"))


def list_causes(entry: Entry) -> list[str]:
    """Return the causes of an error: from its note, or else from its messages, or else from its class."""
    if note := read_notes().get(entry.kind, {}).get("cause"):
        return [note]
    return error_catalogue.list_causes(entry)[:MAX_MESSAGES] or [read_summary(error) for error in entry.errors]


def list_remedies(entry: Entry) -> list[str]:
    """Return what to do about an error: from its note, or else from its messages, or else from its class."""
    notes = read_notes()
    if note := notes.get(entry.kind, {}).get("remedy"):
        return [note]
    ancestors = [each.__name__ for error in entry.errors for each in error.__mro__]
    known = [notes["classes"][name] for name in (*ancestors, *sorted(entry.owners)) if name in notes["classes"]]
    return error_catalogue.list_remedies(entry)[:MAX_MESSAGES] or known[:1]


def _format_index(catalogue: dict[str, Entry]) -> str:
    rows = "\n".join(
        f"| [`{kind}`]({kind}.md) | {', '.join(sorted(entry.owners))} | {_shorten(_escape(list_causes(entry)[0]))} |"
        for kind, entry in catalogue.items()
    )
    return f"""\
# Errors

Each error has an identifier, its `kind`. With `--json`, a command prints it as the key `kind`. In Python, it is the
attribute `kind` of the exception. A script should compare it, because messages change.

A `Finding` is a line of `robotcore doctor`, `robotcore check` or `robotcore test-devices`. A `Mistake` is a wrong
value in a file: the command raises a `DescriptionError` with its identifier.

| kind | class | cause |
| --- | --- | --- |
{rows}
"""


def _format_page(entry: Entry) -> str:
    texts = [
        ". ".join(filter(None, message)) for message in entry.messages if error_catalogue.has_words(message.problem)
    ]
    parts = [f"# {entry.kind}", *map(_describe_owner, sorted(entry.owners))]
    if texts:
        parts += ["## Message", "An upper-case word or … stands for a value.", *map(_fence, texts[:MAX_MESSAGES])]
    if entry.examples:
        parts += ["## Example", _fence(entry.examples[0])]
    parts += ["## Cause", _format_list(list_causes(entry)), "## Remedy", _format_list(list_remedies(entry))]
    if entry.modules:
        parts += [f"Raised by {', '.join(f'`{module}`' for module in sorted(entry.modules))}."]
    return "\n\n".join(parts) + "\n"


def _describe_owner(name: str) -> str:
    if name in OWNERS:
        return OWNERS[name]
    error = next(each for each in list_error_classes() if each.__name__ == name)
    return f"`{name}`, exit status {error.exit_status}: {read_summary(error)}"


def _fence(text: str) -> str:
    return f"```text\n{text}\n```"


def _format_list(texts: list[str]) -> str:
    return "\n".join(f"- {_escape(_make_sentence(text))}" for text in texts)


def _make_sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "?", "…", ":")) else ".")


def _shorten(text: str) -> str:
    return text if len(text) <= 120 else f"{text[:117]}…"


def _escape(text: str) -> str:
    return re.sub(r"([\\*_\[|])", r"\\\1", " ".join(text.split())).replace("<", "&lt;")
