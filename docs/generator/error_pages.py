"""A page of the reference for each identifier of an error, and their index."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from docs.generator import error_catalogue
from docs.generator.error_catalogue import Entry, Message, list_error_classes, read_catalogue
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
    catalogue = build_catalogue()
    yield "index.md", _format_index(catalogue)
    for entry in catalogue.values():
        yield f"{entry.kind}.md", _format_page(entry)


@cache
def read_notes() -> dict[str, Any]:
    """Return the notes about errors whose messages have no cause or no remedy, by identifier."""
    return tomllib.loads(NOTES.read_text(encoding="utf-8"))


def build_catalogue() -> dict[str, Entry]:
    """Return the entries of the source and the tests, and those of notes with a class, in alphabetical order."""
    catalogue = read_catalogue()
    for kind, note in read_notes().items():
        if "class" in note and kind not in catalogue:
            catalogue[kind] = Entry(kind, {note["class"]})
    return dict(sorted(catalogue.items()))


def explain(entry: Entry) -> list[Message]:
    """Return the causes of an error, each with its remedy: from its note, its messages or its classes."""
    note, classes = read_notes().get(entry.kind, {}), read_notes()["classes"]
    names = [each.__name__ for error in entry.errors for each in error.__mro__] + sorted(entry.owners)
    remedy = note.get("remedy") or next((classes[name] for name in names if name in classes), "")
    messages = error_catalogue.list_messages(entry)[:MAX_MESSAGES]
    if cause := note.get("cause"):
        from_message = next((each.remedy for each in messages if error_catalogue.has_words(each.remedy)), "")
        return [Message(cause, note.get("remedy") or from_message or remedy)]
    found = messages or [Message(read_summary(error), "") for error in entry.errors]
    return [
        Message(
            each.problem, each.remedy if error_catalogue.has_words(each.remedy) and "remedy" not in note else remedy
        )
        for each in found
    ]


def _format_index(catalogue: dict[str, Entry]) -> str:
    rows = "\n".join(
        f"| [`{kind}`]({kind}.md) | {', '.join(sorted(entry.owners))} | {_summarize(entry)} |"
        for kind, entry in catalogue.items()
    )
    return f"""\
# Errors

Each error has an identifier, its `kind`. Most commands with `--json`, such as `run`, print it as the key `kind`.
In Python, it is the attribute `kind` of the exception. A script should compare it, because messages change.

To find an error by its message, search this page for a part of the message without names and numbers. An upper-case
word or … stands for a value.

A `Finding` is a line of `robotcore doctor`, `robotcore check` or `robotcore test-devices`. A `Mistake` is a wrong
value in a file: the command raises a `DescriptionError` with its identifier.

| kind | class | messages |
| --- | --- | --- |
{rows}
"""


def _format_page(entry: Entry) -> str:
    parts = [f"# {entry.kind}", *map(_describe_owner, sorted(entry.owners))]
    for number, (cause, remedy) in enumerate(explain(entry), 1):
        parts += ["## Cause and remedy"] if number == 1 else []
        parts += [f"**Cause.** {_escape(_make_sentence(cause))}", f"**Remedy.** {_escape(_make_sentence(remedy))}"]
        parts += ["---"]
    parts.pop()
    if messages := _list_messages(entry):
        parts += [
            "## Message",
            "An upper-case word or … stands for a value. A message of a run has the values themselves.",
            *map(_fence, messages),
        ]
    if entry.modules:
        parts += [f"Raised by {', '.join(f'`{module}`' for module in sorted(entry.modules))}."]
    return "\n\n".join(parts) + "\n"


def _list_messages(entry: Entry) -> list[str]:
    """Return the messages of an error: one of a real run first, if there is one, then those of the source."""
    found = [". ".join(filter(None, each)) for each in entry.messages if error_catalogue.has_words(each.problem)]
    real = [read_notes()[entry.kind]["message"]] if "message" in read_notes().get(entry.kind, {}) else entry.examples
    return list(dict.fromkeys([*real[:1], *found]))[:MAX_MESSAGES]


def _describe_owner(name: str) -> str:
    if name in OWNERS:
        return OWNERS[name]
    error = next(each for each in list_error_classes() if each.__name__ == name)
    return f"`{name}`, exit status {error.exit_status}: {read_summary(error)}"


def _fence(text: str) -> str:
    return f"```text\n{text}\n```"


def _make_sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "?", "…", ":")) else ".")


def _summarize(entry: Entry) -> str:
    texts = _list_messages(entry) or [explain(entry)[0].problem]
    return "<br>".join(map(_escape, texts))


def _escape(text: str) -> str:
    """Return a text in one line, whose characters outside of backquotes have no meaning in Markdown."""
    parts = " ".join(text.split()).split("`")
    plain = [re.sub(r"([\\*_\[|])", r"\\\1", part).replace("<", "&lt;") for part in parts[::2]]
    parts[::2] = plain
    return "`".join(parts)
