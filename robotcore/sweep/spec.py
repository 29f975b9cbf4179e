"""The runs of a sweep, and seeds and requests as text for the command line."""

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
"""The maximum number of seeds of a sweep. The memory holds all requests, and so many runs take one core three weeks."""

_RANGE = re.compile(r"(\d{1,18})(?:\s*-\s*(\d{1,18}))?")

_OPTIONS = {
    "rate_hz": "--rate",
    "timeout_s": "--timeout",
    "settings": "--set",
    "options": "--option",
    "faults": "--fault",
    "has_real_time_priority": "--rt",
}
"""The command-line options whose names differ from their fields of `RunRequest`, by field."""


@dataclass(frozen=True)
class Sweep:
    """The specification of a sweep: one request for every backend, every world and every seed.

    >>> from robotcore import RunRequest
    >>> from robotcore.sweep.spec import format_command
    >>> sweep = Sweep(RunRequest("green-search"), worlds=("arena", "open"), seeds=(1, 2))
    >>> len(sweep)
    4
    >>> [format_command(request) for request in sweep.requests()][:2]
    ['robotcore run green-search --world arena --seed 1', 'robotcore run green-search --world open --seed 1']
    """

    request: RunRequest
    """The request. Its backend, world and seed are ignored."""

    backends: tuple[str, ...] = ("kinematic",)
    """The names of the backends."""

    worlds: tuple[str, ...] = ("arena",)
    """The names of the worlds, or paths of their files."""

    seeds: tuple[int, ...] = (0,)
    """The seeds."""

    def __post_init__(self) -> None:
        """Raise UsageError if the app has no name by which other processes can load it."""
        if not isinstance(self.request.app, str):
            name = self.request.app_reference
            raise UsageError(
                f"a sweep runs in other processes, which cannot load the class {name} without its file. Name the "
                f'file: RunRequest("my_app.py:{name}")',
                kind="app-not-named",
                app=name,
            )

    def __len__(self) -> int:
        return len(self.backends) * len(self.worlds) * len(self.seeds)

    @property
    def apps(self) -> tuple[str, ...]:
        """The name of the app, then the name of the judge if there is one."""
        return (self.request.app_reference, *filter(None, (self.request.judge,)))

    def requests(self) -> Iterator[RunRequest]:
        """Yield the request of every run, seed by seed, so that an interrupted sweep has covered all worlds equally."""
        for seed, backend, world in product(self.seeds, self.backends, self.worlds):
            yield replace(self.request, backend=backend, world=world, seed=seed)

    def check(self) -> None:
        """Check the app, the robot, the worlds and the settings, and open each backend once.

        Raises UsageError, for example for a wrong name or setting, and BackendError if a backend cannot be opened.
        """
        if not len(self):
            raise UsageError(
                "there is nothing to sweep. Name at least one backend, one world and one seed",
                kind="empty-sweep",
            )
        names: dict[str, str] = {}
        for backend, world in product(self.backends, self.worlds):
            plan = Plan.resolve(replace(self.request, backend=backend, world=world, seed=self.seeds[0]))
            if not plan.backend.builds_world(plan.description):
                raise UsageError(
                    f"the backend {plan.backend.name!r} simulates no world, so there is nothing to sweep. "
                    "Use --backend kinematic, or another simulator (robotcore backends)",
                    kind="no-simulator",
                    backend=plan.backend.name,
                )
            assert plan.world, "the request names a world"
            if (other := names.setdefault(plan.world.name, world)) != world:
                raise UsageError(
                    f"the worlds {other} and {world} are both called {plan.world.name!r}. Rename one",
                    kind="ambiguous-world-name",
                    worlds=[other, world],
                    name=plan.world.name,
                )
            if world == self.worlds[0]:  # opening the backend checks its options
                plan.backend.open(plan.setup).close()


def parse_seeds(text: str) -> tuple[int, ...]:
    """Return the seeds that a text lists, in the order of the text and each once.

    Raises UsageError if the text is not a list of numbers and ranges.

    >>> parse_seeds("1,5,9-12")
    (1, 5, 9, 10, 11, 12)
    """
    ranges = [_parse_range(text, part.strip()) for part in text.split(",")]
    if sum(map(len, ranges)) > MAX_SEEDS:
        raise UsageError(
            f"--seeds {text}: more than {MAX_SEEDS:,} seeds. Run several smaller sweeps",
            kind="too-many-seeds",
            seeds=text,
        )
    return tuple(dict.fromkeys(chain.from_iterable(ranges)))


def format_seeds(seeds: Sequence[int]) -> str:
    """Return seeds as text with ranges, as `parse_seeds` reads it.

    >>> format_seeds([1, 5, 9, 10, 11, 12])
    '1,5,9-12'
    """
    ranges: list[list[int]] = []
    for seed in seeds:
        if ranges and seed == ranges[-1][-1] + 1:
            ranges[-1][1:] = [seed]
        else:
            ranges.append([seed])
    return ",".join("-".join(map(str, ends)) for ends in ranges)


def _parse_range(text: str, part: str) -> range:
    found = _RANGE.fullmatch(part)
    seeds = range(int(found[1]), int(found[2] or found[1]) + 1) if found else range(0)
    if not seeds:
        raise UsageError(
            f"--seeds {text}: {part!r} is not a seed or a range. Write 7, or 1-200, or 1,5,9-12",
            kind="bad-seed",
            seeds=text,
            part=part,
        )
    return seeds


def format_command(request: RunRequest) -> str:
    """Return the shell command that repeats a run, with every option whose value is not the default."""
    return shlex.join(["robotcore", "run", request.app_reference, *format_options(request)])


def format_options(request: RunRequest) -> list[str]:
    """Return the options of ``robotcore run`` whose values are not the defaults, as a list of words."""
    words: list[str] = []
    for each in fields(request):
        default = each.default if each.default_factory is MISSING else each.default_factory()
        if each.name != "app" and (value := getattr(request, each.name)) != default:
            words += _format_option(_OPTIONS.get(each.name, f"--{each.name}"), value)
    return words


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
