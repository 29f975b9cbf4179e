"""What a sweep runs: one request with every backend, world and seed; seeds and requests as command-line text."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from itertools import chain, product
from typing import Any

from robotcore.errors import UsageError
from robotcore.runtime.plan import Plan, RunRequest

MAX_SEEDS = 1_000_000
"""Requests are kept in memory; and so many runs take a core three weeks."""

_RANGE = re.compile(r"(\d{1,18})(?:\s*-\s*(\d{1,18}))?")

_OPTIONS = {
    "rate_hz": "--rate",
    "timeout_s": "--timeout",
    "settings": "--set",
    "options": "--option",
    "faults": "--fault",
}
"""The options that are not called what the field of the request is called."""


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
            raise UsageError(
                "there is nothing to sweep: name one backend, one world and one seed, or more of them",
                kind="empty-sweep",
            )
        names: dict[str, str] = {}
        for backend, world in product(self.backends, self.worlds):
            plan = Plan.of(replace(self.request, backend=backend, world=world, seed=self.seeds[0]))
            _require_simulator(plan)
            assert plan.world, "a world was asked for"
            if (other := names.setdefault(plan.world.name, world)) != world:
                raise UsageError(
                    f"the worlds {other} and {world} are both called {plan.world.name!r}. Rename one",
                    kind="ambiguous-world-name",
                    worlds=[other, world],
                    name=plan.world.name,
                )
            if world == self.worlds[0]:  # the backend alone knows what is wrong with its options
                plan.backend.open(plan.setup).close()


def _require_simulator(plan: Plan) -> None:
    if not plan.backend.builds_world(plan.description):
        raise UsageError(
            f"the backend {plan.backend.name!r} simulates no world, so there is nothing to sweep. "
            "Take --backend kinematic, or another simulator (robotcore backends)",
            kind="no-simulator",
            backend=plan.backend.name,
        )


def parse_seeds(text: str) -> tuple[int, ...]:
    """Return the seeds in the order they are written, each once."""
    ranges = [_parse_range(text, part.strip()) for part in text.split(",")]
    if sum(map(len, ranges)) > MAX_SEEDS:
        raise UsageError(
            f"--seeds {text}: more than {MAX_SEEDS:,} seeds. Take fewer, in several sweeps if need be",
            kind="too-many-seeds",
            seeds=text,
        )
    return tuple(dict.fromkeys(chain.from_iterable(ranges)))


def format_seeds(seeds: Sequence[int]) -> str:
    """Return how seeds are written: what `parse_seeds` takes."""
    ranges: list[list[int]] = []
    for seed in seeds:
        if ranges and seed == ranges[-1][-1] + 1:
            ranges[-1][1:] = [seed]
        else:
            ranges.append([seed])
    return ",".join("-".join(map(str, ends)) for ends in ranges)


def _parse_range(text: str, part: str) -> range:
    found = _RANGE.fullmatch(part)
    if not found:
        raise UsageError(
            f"--seeds {text}: {part!r} is no seed. Write 7, or 1-200, or 1,5,9-12",
            kind="bad-seed",
            seeds=text,
            part=part,
        )
    first, last = int(found[1]), int(found[2] or found[1])
    if last < first:
        raise UsageError(
            f"--seeds {text}: {part} runs backwards. Write {last}-{first}", kind="reversed-seeds", seeds=text, part=part
        )
    return range(first, last + 1)


def format_command(request: RunRequest) -> str:
    """Return ``robotcore run …`` with every option that is not the default, quoted."""
    return shlex.join(["robotcore", "run", request.app, *format_options(request)])


def format_options(request: RunRequest) -> list[str]:
    """Return the options of ``robotcore run`` that are not the default, word by word."""
    return [
        word
        for name, value in _list_changed_fields(request)
        for word in _format_option(_OPTIONS.get(name, f"--{name}"), value)
    ]


def _list_changed_fields(request: RunRequest) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a request that are not what they are by default."""
    for each in fields(request):
        default = each.default if each.default_factory is MISSING else each.default_factory()
        if each.name != "app" and (value := getattr(request, each.name)) != default:
            yield each.name, value


def _format_option(option: str, value: Any) -> Iterator[str]:
    if value is True:
        yield option
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from (option, f"{key}={item}")
    elif isinstance(value, tuple):
        for item in value:
            yield from (option, item)
    else:
        yield from (option, repr(value).removesuffix(".0") if isinstance(value, float) else str(value))
