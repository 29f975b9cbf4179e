"""A fault as it is written: ``TARGET EFFECT[=VALUE] [KEY=VALUE …]``."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass

from robotcore.errors import UsageError

GRAMMAR = "TARGET EFFECT[=VALUE] [KEY=VALUE …]"
EXAMPLE = "camera drop=0.2 after=5"

LONGEST = 60
"""Of a text from a user, in a message."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


@dataclass(frozen=True)
class Spec:
    """What is to fail, how, and with which parameters, none of them understood yet.

    >>> str(Spec.parse("  camera drop=0.20   lasts=3.0 after=5 "))
    'camera drop=0.2 after=5 lasts=3'
    """

    target: str
    effect: str
    value: str | None = None
    parameters: tuple[tuple[str, str], ...] = ()

    @classmethod
    def parse(cls, text: str) -> Spec:
        """Read a spec; UsageError says in one line what is wrong with it."""
        words = text.split()
        if len(words) < 2:
            raise _refusal(text, f"{'an effect' if words else 'everything'} is missing")
        target, (effect, value), *rest = words[0], *(_parted(text, word) for word in words[1:])
        for key, given in rest:
            if given is None:
                raise _refusal(text, f"{shown(key)} has no value")
            if [other for other, _ in rest].count(key) > 1:
                raise _refusal(text, f"{key} is given twice")
        parameters = [(key, given) for key, given in rest if given is not None]
        return cls(_named(text, target), effect.replace("-", "_"), value, tuple(sorted(parameters)))

    def __str__(self) -> str:
        """The canonical form: the parameters in order, numbers as short as they can be."""
        effect = self.effect if self.value is None else f"{self.effect}={self.value}"
        return " ".join([self.target, effect, *(f"{key}={value}" for key, value in self.parameters)])

    @property
    def after_s(self) -> float:
        """From when on the fault is there."""
        return float(dict(self.parameters).get("after", 0.0))


def shown(text: str) -> str:
    """Return a text from a user in quotes, not too long for a message."""
    return repr(text if len(text) <= LONGEST else f"{text[:LONGEST]}…")


def _refusal(text: str, fault: str) -> UsageError:
    return UsageError(f'{shown(text)}: {fault}. Write {GRAMMAR}, such as "{EXAMPLE}"')


def _number_told(number: float) -> str:
    """Return a number as short as it can be and come out the same."""
    return repr(number).removesuffix(".0")


def _parted(text: str, word: str) -> tuple[str, str | None]:
    key, sign, value = word.partition("=")
    if sign and not value:
        raise _refusal(text, f"{shown(word)} has no value")
    return _named(text, key), _canonical(text, value) if sign else None


def _named(text: str, word: str) -> str:
    if not _NAME.fullmatch(word):
        raise _refusal(text, f"{shown(word)} is no name")
    return word


def _canonical(text: str, value: str) -> str:
    if not value.isprintable():
        raise _refusal(text, f"{shown(value)} cannot be printed")
    with suppress(ValueError):
        return _number_told(float(value))
    return value
