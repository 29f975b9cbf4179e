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

MAX_ANSWER = 360.0
"""The greatest measured number that is plausible: an angle in degrees. A longer distance in metres is not either."""

CHECK_S = 0.1
"""The interval at which a prompt checks whether it must end, in seconds."""


def has_terminal() -> bool:
    """Return whether a person can answer: standard input is a terminal."""
    return sys.stdin is not None and not sys.stdin.closed and sys.stdin.isatty()


class TerminalPerson:
    """The person at the terminal. Questions are written on stderr.

    is_confirmed: whether the person has confirmed by ``--yes`` that the robot may move.
    """

    def __init__(self, *, is_confirmed: bool = False) -> None:
        self._is_confirmed = is_confirmed
        self.check: Callable[[], object] = lambda: None
        """Is called several times a second while the person types. It raises the error of an e-stop."""

    def prepare(self, instruction: str, *, has_question: bool = False) -> None:
        """Wait until the person has followed an instruction and presses Enter, unless ``--yes`` has confirmed it.

        has_question: whether `ask` follows after the robot has moved. Then ``--yes`` does not replace the person.

        Raises UsageError if no person can confirm it.
        """
        if self._is_confirmed and not has_question:
            return
        if not has_terminal():
            remedy = "Run the command in a terminal" + ("" if has_question else ", or add --yes")
            raise UsageError(f"no terminal to confirm this: {instruction}. {remedy}", kind="not-confirmed")
        if self._is_confirmed:
            return
        if self.read_line(f"{instruction}. Then press Enter.") is None:
            text = "standard input was closed before the robot moved. Repeat the command"
            raise UsageError(text, kind="not-confirmed")

    def ask(self, question: str, most: float = MAX_ANSWER) -> float:
        """Return the number that the person types, from -``most`` to ``most``. Raises UsageError after Ctrl-D."""
        while (answer := self.read_line(f"{question}:")) is not None:
            number = _parse_number(answer)
            if abs(number) <= most:
                return number
            problem = "is not plausible" if abs(number) > most else "is no number"
            write_line(f"{answer!r} {problem}. Type a number such as 1.024, from {-most:g} to {most:g}", is_error=True)
        text = f"standard input was closed before this answer: {question}. Repeat the command"
        raise UsageError(text, kind="no-answer")

    def read_number(self, prompt: str, find_problem: Callable[[float], str] = lambda _number: "") -> float | None:
        """Return a number that the person types; None for an empty line, without a terminal, and after Ctrl-D.

        find_problem: returns the problem of a number; ``""`` for a valid one.
        """
        while answer := self.read_line(prompt):
            number = _parse_number(answer)
            problem = find_problem(number) if math.isfinite(number) else f"{answer!r} is no number"
            if not problem:
                return number
            write_line(f"{problem}. Type another number, or press Enter to end", is_error=True)
        return None

    def choose(self, prompt: str, choices: Mapping[str, str]) -> str | None:
        """Return the key of a choice; None without a terminal, after Ctrl-D, and if the person skips the question.

        choices: the meanings of the answers, by what the person types.
        """
        listed = ", ".join(f"{key} = {meaning}" for key, meaning in choices.items())
        while (answer := self.read_line(f"{prompt} [{listed}, Enter = skip]")) is not None:
            if not answer:
                return None
            if answer.lower() in choices:
                return answer.lower()
            write_line(f"{answer!r} is no answer. Type one of: {', '.join(choices)}", is_error=True)
        return None

    def confirm(self, instruction: str) -> bool:
        """Return whether the person has followed an instruction; False without a terminal, and after Ctrl-D."""
        while (answer := self.read_line(f"{instruction}. [Enter = ready, s = skip]")) is not None:
            if answer.lower() in ("", "s"):
                return not answer
            write_line(f"{answer!r} is no answer. Press Enter, or type s and press Enter", is_error=True)
        return False

    def read_line(self, prompt: str) -> str | None:
        """Return the line that the person types after a prompt; None without a terminal, and after Ctrl-D."""
        if not has_terminal():
            return None
        with suppress(OSError):
            sys.stderr.write(f"{escape(prompt)} ")
            sys.stderr.flush()
        try:
            while not select([sys.stdin], [], [], CHECK_S)[0]:
                self.check()
            self.check()
        except BaseException:
            write_line(is_error=True)  # the error gets a line of its own
            raise
        line = sys.stdin.readline()
        if not line:
            write_line(is_error=True)
            return None
        return line.strip()


def _parse_number(answer: str) -> float:
    """Return the number in an answer, with a point or a comma; NaN if it is none."""
    with suppress(ValueError):
        return float(answer.replace(",", "."))
    return math.nan
