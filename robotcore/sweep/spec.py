"""What a sweep tries: one request in every backend, world and seed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

from robotcore.errors import UsageError
from robotcore.runtime.plan import Plan, RunRequest


@dataclass(frozen=True)
class Sweep:
    """A request, tried on every backend, in every world, with every seed.

    What the request itself says of these three does not count.
    """

    request: RunRequest
    backends: tuple[str, ...] = ("kinematic",)
    worlds: tuple[str, ...] = ("arena",)
    seeds: tuple[int, ...] = (0,)

    def __len__(self) -> int:
        return len(self.backends) * len(self.worlds) * len(self.seeds)

    @property
    def apps(self) -> tuple[str, ...]:
        """The app, and the one that judges it."""
        return (self.request.app, *filter(None, (self.request.judge,)))

    def requests(self) -> Iterator[RunRequest]:
        """Yield every run, seed by seed, so that what is cut short has tried every world about as often."""
        for seed, backend, world in product(self.seeds, self.backends, self.worlds):
            yield replace(self.request, backend=backend, world=world, seed=seed)

    def check(self) -> None:
        """Refuse now what would fail in every run: a wrong name, a setting, a backend that does not open."""
        if not len(self):
            raise UsageError("there is nothing to sweep: name one backend, one world and one seed, or more of them")
        names: dict[str, str] = {}
        for backend, world in product(self.backends, self.worlds):
            plan = Plan.of(replace(self.request, backend=backend, world=world, seed=self.seeds[0]))
            _require_simulator(plan)
            assert plan.world, "a world was asked for"
            if (other := names.setdefault(plan.world.name, world)) != world:
                raise UsageError(f"the worlds {other} and {world} are both called {plan.world.name!r}. Rename one")
            if world == self.worlds[0]:  # the backend alone knows what is wrong with its options
                plan.backend.open(plan.setup).close()


def _require_simulator(plan: Plan) -> None:
    if not plan.backend.builds_world(plan.description):
        raise UsageError(
            f"the backend {plan.backend.name!r} simulates no world, so there is nothing to sweep. "
            "Take --backend kinematic, or another simulator (robotcore backends)"
        )
