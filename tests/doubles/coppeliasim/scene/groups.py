"""Collections: objects that a sensor is told to see, instead of all there are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tests.doubles.coppeliasim.scene.errors import SceneError
from tests.doubles.coppeliasim.scene.objects import Thing

if TYPE_CHECKING:
    from tests.doubles.coppeliasim.scene.graph import Graph

ALL, TREE, SINGLE = -2, -6, -8
"""What an item takes in: the API's ``handle_...``."""


@dataclass
class Collection:
    """Items in the order they were added: what each takes in, of which object, and whether it takes it out again."""

    items: list[tuple[int, Thing | None, bool]] = field(default_factory=list)

    def add(self, what: int, thing: Thing | None, *, is_out: bool) -> None:
        if what not in {ALL, TREE, SINGLE}:
            raise SceneError(f"the double collects trees, single objects and all, not {what}.")
        self.items.append((what, thing, is_out))

    def members(self, graph: Graph) -> set[Thing]:
        """Return what is in it now."""
        found: set[Thing] = set()
        for what, thing, is_out in self.items:
            named = [thing] if thing else []
            these = set(graph.tree() if what == ALL else graph.tree(named) if what == TREE else named)
            found = found - these if is_out else found | these
        return found
