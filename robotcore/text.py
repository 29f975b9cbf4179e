"""Functions that format text for messages, parse durations, and find the name that a wrong one stands for."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Sequence
from contextlib import suppress
from difflib import get_close_matches
from numbers import Integral, Real
from typing import Any


def pluralize(number: int, noun: str) -> str:
    """Return a number and its noun. The noun gets an s if the number is not 1.

    >>> pluralize(1, "warning"), pluralize(0, "warning")
    ('1 warning', '0 warnings')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def format_number(value: Any) -> str:
    """Return a number as text with two decimals, and a whole number or another value without a change.

    >>> format_number(-0.001), format_number(0.125), format_number(3)
    ('0.00', '0.12', '3')
    """
    if not isinstance(value, Real) or isinstance(value, Integral):
        return str(value)
    return f"{round(float(value), 2) + 0.0:.2f}"  # adding 0.0 turns -0.0 into 0.0


_DURATION = re.compile(r"(\d{1,9}(?:\.\d{1,9})?) ?(s|min|h)")
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}


def parse_duration(text: str) -> float:
    """Return a positive duration in seconds. Raises ValueError if the text has no such duration with its unit.

    >>> parse_duration("10min"), parse_duration("1.5 h"), parse_duration("90s")
    (600.0, 5400.0, 90.0)
    """
    found = _DURATION.fullmatch(text.strip())
    if not found or not float(found[1]):
        raise ValueError(f"{text!r} is not a duration. Give one such as 10min, 90s or 2h")
    return float(found[1]) * _SECONDS[found[2]]


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


_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def escape_formula(text: str) -> str:
    """Return a text for a cell of a CSV file. An apostrophe precedes what a spreadsheet would run as a formula.

    Source: https://owasp.org/www-community/attacks/CSV_Injection.
    """
    return f"'{text}" if text.startswith(_FORMULA_STARTS) else text


MAX_LISTED_NAMES = 5
"""The greatest number of names that a message lists."""


def list_names(names: Collection[str], most: int = MAX_LISTED_NAMES) -> str:
    """Return the first ``most`` names, escaped and separated by commas, and the number of the other names.

    >>> list_names(["a.mcap", "b.mcap", "c.mcap"], most=2)
    'a.mcap, b.mcap and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(map(escape, list(names)[:most]))}{more}"


_SEPARATORS = "-_./ "
"""The characters between the words of a name."""


def suggestion(name: str, known: Sequence[str]) -> str:
    """Return a sentence that suggests the known name that `find_nearest` returns, or else lists all known names.

    >>> suggestion("gren", ["green", "blue"]), suggestion("xyz", ["green", "blue"])
    ("Did you mean 'green'?", 'There are: blue, green.')
    """
    if close := find_nearest(name, known):
        return f"Did you mean {close!r}?"
    return f"There are: {', '.join(sorted(known)) or 'none'}."


def find_nearest(name: str, known: Sequence[str]) -> str | None:
    """Return the known name that ``name`` probably stands for, or None if no known name is near.

    A name is near if it has whole words of the other name at its start or its end, begins with the typed name, or has
    two thirds of its letters.

    >>> find_nearest("speed", ["seeds", "speed_m_s"]), find_nearest("--sead", ["--seed"])
    ('speed_m_s', '--seed')
    >>> find_nearest("stat", ["start", "status"])
    'status'
    """
    plain = _strip_name(name)
    by_name = {_strip_name(each): each for each in known}
    with_its_words = (each for each in by_name if _has_words_of(*sorted((plain, each), key=len)))
    longer = (each for each in by_name if len(plain) > 2 and each.startswith(plain))
    close = (*with_its_words, *longer, *get_close_matches(plain, by_name, n=1, cutoff=2 / 3))
    return by_name[close[0]] if close else None


def suggest_attribute(error: BaseException) -> str:
    """Return a sentence that suggests another name if an attribute, or a name in an import, does not exist.

    It is empty for another error, or if no name is near. Before Python 3.12, a traceback as text has no suggestion.

    >>> try:
    ...     "text".splitt()
    ... except AttributeError as error:
    ...     suggest_attribute(error)
    "Did you mean 'split'?"
    """
    with suppress(Exception):  # an app's own classes may define __str__ and __dir__
        match error:
            case AttributeError(name=str(name), obj=owner):
                known = [each for each in dir(owner) if not each.startswith("_")]
            case ImportError(name=str(module)) if str(error).startswith("cannot import name "):
                name, known = str(error).split("'")[1], dir(sys.modules[module])
            case _:
                return ""
        if close := find_nearest(name, known):
            return f"Did you mean {close!r}?"
    return ""


def _strip_name(name: str) -> str:
    return name.lower().strip(_SEPARATORS)


def _has_words_of(part: str, whole: str) -> bool:
    """Return whether a name begins or ends with all words of a shorter name. A letter at the end is no word."""
    begins = whole.startswith(part) and whole[len(part) :][:1] in tuple(_SEPARATORS)
    ends = len(part) > 1 and whole.endswith(part) and whole[: -len(part)][-1:] in tuple(_SEPARATORS)
    return bool(part) and (begins or ends)
