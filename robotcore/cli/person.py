"""Asks the person at the terminal. Without a terminal, no question is asked."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from select import select

from robotcore.cli.output import write_line
from robotcore.errors import UsageError
from robotcore.text import escape

CHECK_S = 0.1
"""The interval at which a prompt checks whether it must end, in seconds."""


def has_terminal() -> bool:
    """Return whether a person can answer: standard input is a terminal."""
    return sys.stdin is not None and not sys.stdin.closed and sys.stdin.isatty()


def read_answer(prompt: str, check: Callable[[], object] = lambda: None) -> str | None:
    """Return the line that the person types after a prompt on stderr; None without a terminal, and after Ctrl-D.

    check: is called several times a second while the person types. It raises an exception to end the prompt, such as
        after an e-stop.
    """
    if not has_terminal():
        return None
    with suppress(OSError):
        sys.stderr.write(f"{escape(prompt)} ")
        sys.stderr.flush()
    try:
        while not select([sys.stdin], [], [], CHECK_S)[0]:
            check()
        check()
    except BaseException:
        write_line(is_error=True)  # the error gets a line of its own
        raise
    line = sys.stdin.readline()
    if not line:
        write_line(is_error=True)
        return None
    return line.strip()


def choose(prompt: str, choices: Mapping[str, str], check: Callable[[], object] = lambda: None) -> str | None:
    """Return the key of a choice; None without a terminal, after Ctrl-D, and if the person skips the question.

    choices: the meanings of the answers, by what the person types.
    check: see `read_answer`.
    """
    listed = ", ".join(f"{key} = {meaning}" for key, meaning in choices.items())
    while (answer := read_answer(f"{prompt} [{listed}, Enter = skip]", check)) is not None:
        if not answer:
            return None
        if answer.lower() in choices:
            return answer.lower()
        write_line(f"{answer!r} is no answer. Type one of: {', '.join(choices)}", is_error=True)
    return None


def read_number(
    prompt: str, find_problem: Callable[[float], str], check: Callable[[], object] = lambda: None
) -> float | None:
    """Return a number that the person types; None for an empty line, without a terminal, and after Ctrl-D.

    find_problem: returns the problem of a number; ``""`` for a valid one.
    check: see `read_answer`.
    """
    while answer := read_answer(prompt, check):
        try:
            value = float(answer.replace(",", "."))
        except ValueError:
            value = math.nan
        problem = find_problem(value) if math.isfinite(value) else f"{answer!r} is no number"
        if not problem:
            return value
        write_line(f"{problem}. Type another number, or press Enter to end", is_error=True)
    return None


def require_ready(instruction: str, check: Callable[[], object] = lambda: None, *, is_confirmed: bool) -> None:
    """Wait until the person has followed an instruction and presses Enter.

    check: see `read_answer`.
    is_confirmed: whether the person has confirmed it before, by ``--yes``.

    Raises UsageError if no person can confirm it.
    """
    if is_confirmed:
        return
    if not has_terminal():
        text = f"no terminal to confirm this: {instruction}. Run the command in a terminal, or add --yes"
        raise UsageError(text, kind="not-confirmed")
    if read_answer(f"{instruction}. Then press Enter.", check) is None:
        text = "standard input was closed before the robot moved. Repeat the command"
        raise UsageError(text, kind="not-confirmed")
