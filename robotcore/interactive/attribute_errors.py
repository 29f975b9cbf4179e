"""The error for an attribute that a live robot or its drive does not have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NoReturn

from robotcore.text import find_nearest

MANOEUVRES = ("straight", "turn", "arc", "go_to", "follow_path", "face", "move")


def raise_attribute_error(name: str, owners: Mapping[str, object]) -> NoReturn:
    """Raise AttributeError with a similar name, or with the manoeuvres. ``__getattr__`` calls this function.

    name: the name of the attribute.
    owners: the object that does not have the attribute, and others whose names may be meant. The keys are their names.
    """
    label, owner = next(iter(owners.items()))
    if name.startswith("_") or hasattr(type(owner), name):  # a protocol of Python asks, or a property has failed
        object.__getattribute__(owner, name)
    known = {each: f"{place}.{each}" for place, found in owners.items() for each in dir(found) if each[0] != "_"}
    close = find_nearest(name, list(known))
    manoeuvres = f"The manoeuvres are robot.drive.{', '.join(MANOEUVRES[:-1])} and {MANOEUVRES[-1]}"
    raise AttributeError(
        f"{label} has no attribute {name!r}. {f'Did you mean {known[close]}?' if close else manoeuvres}"
    )
