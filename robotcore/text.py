"""Small helpers for text that people read."""

from __future__ import annotations

from collections.abc import Collection


def pluralize(number: int, noun: str) -> str:
    """Return how many there are of what, in the plural but for one.

    >>> pluralize(1, "warning"), pluralize(0, "warning")
    ('1 warning', '0 warnings')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def escape(text: str, *, keep: str = "") -> str:
    r"""Return the text with every character that a terminal would obey, or not show, as a backslash escape.

    Text of a recording, a robot or a file is data: an escape sequence in it could rename the window, write to the
    clipboard, or forge a line. ``keep`` lists control characters that pass, such as a line break.

    >>> print(escape("\x1b]0;title\x07 end\u202e"))
    \x1b]0;title\x07 end\u202e
    >>> escape("two\nlines", keep="\n")
    'two\nlines'
    """
    if text.isprintable():
        return text
    return "".join(
        each if each.isprintable() or each in keep else each.encode("unicode_escape").decode("ascii") for each in text
    )


MOST_NAMED = 5
"""So many files are named in a message."""


def list_names(names: Collection[str], most: int = MOST_NAMED) -> str:
    """Return the first names, escaped, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(map(escape, list(names)[:most]))}{more}"
