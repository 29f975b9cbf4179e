"""An extension of Griffe that writes the docstrings of this project as Markdown, for the pages of the reference.

The name of a parameter and a colon begin its description, and ``>>>`` begins an example.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

from griffe import Extension, Object

import robotcore

PARAMETER = re.compile(r"[a-z_*][\w.*\[\]]*(?:, [a-z_*]\w*)*: +\S")
EXAMPLE = ">>> "


class MarkdownDocstrings(Extension):
    """Rewrites each docstring after Griffe has read it."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Rewrite the docstring of a module, class, function or attribute."""
        if obj.docstring:
            is_member = obj.is_attribute or obj.is_module or (obj.parent is not None and obj.parent.is_class)
            name = "" if is_member else obj.name
            obj.docstring.value = format_docstring(add_import(obj.docstring.value, obj.module.path, name))


def add_import(text: str, module: str, name: str) -> str:
    r"""Return a docstring whose first example imports the documented class or function, so that a reader can paste it.

    module: the module that defines it.
    name: its name; ``""`` for anything else.

    >>> print(add_import("Return 3.\n\n>>> three()\n3", "robotcore.example", "three"))
    Return 3.
    <BLANKLINE>
    >>> from robotcore.example import three
    >>> three()
    3
    """
    if not name or re.search(rf"^ *>>> (from|import) .*\b{name}\b", text, re.MULTILINE):
        return text
    source = "robotcore" if name in robotcore.__all__ else module
    return re.sub(r"^( *)>>> ", rf"\1>>> from {source} import {name}\n\1>>> ", text, count=1, flags=re.MULTILINE)


def format_docstring(text: str) -> str:
    r"""Return a docstring as Markdown: parameters as a list, and examples as fenced blocks.

    >>> print(format_docstring("Return a sum.\n\na: a number.\nb: a number,\n    in metres."))
    Return a sum.
    <BLANKLINE>
    - `a`: a number.
    - `b`: a number,
        in metres.
    """
    paragraphs = re.split(r"\n{2,}", inspect.cleandoc(text))
    return "\n\n".join(_format_paragraph(each) for each in paragraphs)


def _format_paragraph(paragraph: str) -> str:
    lines = paragraph.splitlines()
    if paragraph.startswith(EXAMPLE):
        return f"```pycon\n{paragraph}\n```"
    if PARAMETER.match(paragraph) and all(PARAMETER.match(line) or line.startswith(" ") for line in lines):
        return "\n".join(_format_parameter(line) if PARAMETER.match(line) else line for line in lines)
    return paragraph


def _format_parameter(line: str) -> str:
    names, _, text = line.partition(": ")
    return f"- {', '.join(f'`{name}`' for name in names.split(', '))}: {text}"
