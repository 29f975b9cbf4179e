"""Measure how often green-search finds the ball, by the simulators' truth, and whether two simulators agree.

    python -m benchmarks.success --seeds 1-200 --worlds arena,clutter,occluded --backends kinematic,pybullet

Every failing run is listed with its cause. `--randomise` draws light, colours, textures, sensors and wheels too.
`--robot benchmarks/imperfect_rover.toml` has all imperfections that a robot's file can describe. The first seeds
(`--twice`) run twice, and have to give the same digests. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.report import parse_options, print_table
from robotcore.runtime.plan import RunRequest
from robotcore.sweep import LocalEngine, Record, Sweep, run_sweep
from robotcore.sweep.engine import count_cores
from robotcore.sweep.record import format_failure
from robotcore.sweep.spec import parse_seeds
from robotcore.sweep.statistics import Group, compare_backends, group_records
from robotcore.sweep.tables import format_contacts, format_time

VERIFIED, RANDOMISED, AGREEING = 0.98, 0.95, 0.97
"""The bounds of three shares: verified runs, verified runs with --randomise, and seeds on which simulators agree."""

IMPERFECT = 0.99
"""The bound of the share of verified runs with another robot than the rover."""


def main() -> int:
    """Execute the sweep, and print the results."""
    options = parse_options(
        __doc__,
        seeds="1-20",
        worlds="arena,clutter,occluded",
        backends="kinematic,pybullet",
        robot="rover",
        randomise=False,
        jobs=count_cores(),
        twice=3,
    )
    sweep = Sweep(
        RunRequest("green-search", robot=options.robot, randomise=options.randomise),
        tuple(options.backends.split(",")),
        tuple(options.worlds.split(",")),
        parse_seeds(options.seeds),
    )
    records = list(run_sweep(sweep, LocalEngine(options.jobs)).records())
    groups = group_records(records)
    print_table(
        ("backend", "world", "verified", "95 % interval", "contacts", "median", "slowest"), map(_build_row, groups)
    )
    _print_failures(records)
    is_repeatable = _is_repeatable(sweep, records, options.twice, options.jobs)
    bound = RANDOMISED if options.randomise else VERIFIED if options.robot == "rover" else IMPERFECT
    is_sure = all(
        (group.verified_share or 0.0) >= bound and group.contacts == 0 == group.contacts_unknown for group in groups
    )
    return int(not (is_sure and _is_agreed(records) and is_repeatable))


def _build_row(group: Group) -> tuple[str, ...]:
    low, high = group.verified_95 or (0.0, 1.0)
    return (
        group.backend,
        group.world,
        f"{group.verified}/{group.runs}",
        f"{100 * low:.1f} to {100 * high:.1f} %",
        format_contacts(group),
        format_time(group.median_time_s),
        format_time(group.slowest_time_s),
    )


def _print_failures(records: list[Record]) -> None:
    for record in sorted(records, key=lambda record: record.command):
        if record.is_failure:
            print(f"failing: {record.command}  # {format_failure(record)}")


def _is_agreed(records: list[Record]) -> bool:
    is_agreed = True
    for agreement in compare_backends(records):
        same, pairs = len(agreement.pairs) - len(agreement.differing), len(agreement.pairs)
        print(f"{agreement.first} and {agreement.second}: the same milestones and outcome in {same} of {pairs}")
        is_agreed &= same / pairs >= AGREEING
    return is_agreed


def _is_repeatable(sweep: Sweep, records: list[Record], twice: int, jobs: int) -> bool:
    known = {record.command: record.result.trace_sha256 for record in records}
    few = Sweep(sweep.request, sweep.backends, sweep.worlds, sweep.seeds[:twice])
    with TemporaryDirectory() as folder:
        again = list(run_sweep(few, LocalEngine(jobs), Path(folder, "again")).records())
    same = sum(known[record.command] == record.result.trace_sha256 for record in again)
    print(f"run twice: {same} of {len(again)} digests are equal; all runs: {len(set(known.values()))} digests")
    return same == len(again)


if __name__ == "__main__":
    sys.exit(main())
