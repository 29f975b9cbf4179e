"""Whether the things of a world have room beside each other."""

from __future__ import annotations

from robotcore.description.world import WorldDescription


def require_room(world: WorldDescription, file: str) -> None:
    """Raise DescriptionError where two things overlap."""
