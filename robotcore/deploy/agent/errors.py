"""Errors of the agent, and errors for known messages of other programs. The client uses both."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterable
from dataclasses import dataclass

MAKE_ROOM = "Make room on the robot: fetch its recordings with robotcore deploy fetch --move, and look at df -h"
"""The remedy in error messages about a full disk of the robot."""


class AgentError(Exception):
    """Raised if the robot cannot do the action.

    problem: the cause, as a sentence without its full stop.
    remedy: what the user can do, as a sentence without its full stop.
    kind: a stable identifier of the problem. The client chooses a better remedy for some kinds.
    fields: the values in the text of the problem, by name. They are not sent to the client.
    """

    def __init__(self, problem: str, remedy: str, kind: str, **fields: object) -> None:
        super().__init__(f"{problem}. {remedy}")
        self.problem, self.remedy, self.kind, self.fields = problem, remedy, kind, fields


@dataclass(frozen=True)
class KnownFailure:
    """A message of ssh, rsync or pip, and the error for it."""

    pattern: str
    """The regular expression that finds the message in the program's output."""
    kind: str
    """The kind of the error."""
    problem: str
    """The cause: a format string with the named groups of ``pattern``, and with values that the caller adds."""
    remedy: str
    """What the user can do: such a format string. The text of a group is quoted for a shell."""


def explain_known(
    failures: Iterable[KnownFailure],
    output: str,
    accepts: Callable[[re.Match[str]], bool] | None = None,
    **values: object,
) -> AgentError | None:
    """Return the error for the first failure whose message is in a program's output; None without such a message.

    accepts: whether a found message may be used. A robot may write messages that look like those of ssh.
    values: further values for the format strings, by name.
    """
    for failure in failures:
        found = re.search(failure.pattern, output, re.DOTALL | re.MULTILINE)
        if found and (accepts is None or accepts(found)):
            groups = found.groupdict("")
            quoted = {name: shlex.quote(text) for name, text in groups.items()}
            problem, remedy = failure.problem.format(**groups, **values), failure.remedy.format(**quoted, **values)
            return AgentError(problem, remedy, failure.kind)
    return None
