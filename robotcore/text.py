"""Functions that format text for messages."""

from __future__ import annotations

from collections.abc import Collection


def pluralize(number: int, noun: str) -> str:
    """Return a number and its noun. The noun gets an s if the number is not 1.

    >>> pluralize(1, "warning"), pluralize(0, "warning")
    ('1 warning', '0 warnings')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def escape(text: str, *, keep: str = "") -> str:
    r"""Return a text with a backslash escape in place of each control or invisible character.

    Text from a recording, a robot or a file is untrusted. In a terminal, an escape sequence could rename the window,
    write to the clipboard, or forge a line.

    text: the text.
    keep: characters that are not escaped, such as a line break.

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
"""The greatest number of names that a message lists."""


def list_names(names: Collection[str], most: int = MOST_NAMED) -> str:
    """Return the first ``most`` names, escaped and separated by commas, and the number of the other names.

    >>> list_names(["a.mcap", "b.mcap", "c.mcap"], most=2)
    'a.mcap, b.mcap and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(map(escape, list(names)[:most]))}{more}"
