"""Objects by path: ``/rover/leftMotor``, ``./camera`` from an object, ``/box[1]``, ``*`` and ``?`` as wildcards.

As the simulator has it, a path need not name every object on the way: ``/leftMotor`` finds what ``/rover/leftMotor``
does, and what is nearer the root is found first.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase

from tests.doubles.coppeliasim.scene.objects import Thing


def find(roots: Sequence[Thing], path: str, index: int = 0, start: Thing | None = None) -> Thing | None:
    """Return the object that a path names, or None; ``index`` counts those that it fits, ``./`` begins at ``start``."""
    if path in {".", ":"}:
        return start
    if path.startswith("./"):
        roots, path = (start.children if start else roots), path[1:]
    if not path.startswith("/") or path.endswith("/"):
        return None
    fitting = _matching(roots, path[1:].split("/"))
    for _ in range(index):
        next(fitting, None)
    return next(fitting, None)


def shortest(roots: Sequence[Thing], thing: Thing) -> str:
    """Return the path that names it: with the models it is part of, and what else it takes to tell it from others."""
    path, above = "/" + _numbered(roots, thing), thing.parent
    while above:
        scope = above.parent.children if above.parent else roots
        if above.is_model_base or find(scope, path) is not thing:
            path = "/" + _numbered(roots, above) + path
        above = above.parent
    return path


def full(roots: Sequence[Thing], thing: Thing) -> str:
    """Return the path that names it and everything above it."""
    above = full(roots, thing.parent) if thing.parent else ""
    return f"{above}/{_numbered(roots, thing)}"


def _matching(level: Sequence[Thing], parts: Sequence[str]) -> Iterator[Thing]:
    name, number = _split(parts[0])
    left, deeper = number or 0, list[Thing]()
    for thing in level:
        is_fitting = fnmatchcase(thing.alias, name)
        if is_fitting and left == 0:
            if len(parts) == 1:
                yield thing
            else:
                yield from _matching(thing.children, parts[1:])
        left -= is_fitting and number is not None
        if not (is_fitting and number is not None):
            deeper.append(thing)
    for thing in deeper:
        yield from _matching(thing.children, parts)


def _split(part: str) -> tuple[str, int | None]:
    """Return the alias of a part of a path, and the number behind it if there is one."""
    numbered = re.fullmatch(r"(.+)\[(\d+)\]", part)
    return (numbered[1], int(numbered[2])) if numbered else (part, None)


def _numbered(roots: Sequence[Thing], thing: Thing) -> str:
    """Return its alias, with a number where siblings share it."""
    namesakes = [each for each in (thing.parent.children if thing.parent else roots) if each.alias == thing.alias]
    return thing.alias if len(namesakes) == 1 else f"{thing.alias}[{namesakes.index(thing)}]"
