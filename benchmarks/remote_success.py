"""Compare green-search over the servers' remote APIs with green-search in the kinematic simulator.

    python -m benchmarks.remote_success --seeds 1-50

Every seed runs in the kinematic simulator, in a double of CoppeliaSim, and in a double of V-REP. One CoppeliaSim serves
all seeds, and calls build its scenes. Each seed has its own V-REP, whose scene has the robot and the world. Each double
is a process. With `--coppeliasim HOST:PORT`, a real server builds the scenes. The
exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import ExitStack

import cv2

from benchmarks.remote.doubles import DoubleProcess
from benchmarks.report import machine, print_table
from robotcore.runtime.plan import RunRequest
from robotcore.sweep import Record
from robotcore.sweep.record import format_failure
from robotcore.sweep.single_run import perform
from robotcore.sweep.spec import parse_seeds
from robotcore.sweep.statistics import Group, compare_backends, group_records
from robotcore.sweep.tables import format_contacts, format_time

VERIFIED, ALIKE = 0.97, 0.97
"""The bounds: of verified runs, and of seeds with the same milestones as in the built-in simulator."""

REFERENCE = "kinematic"


def main() -> int:
    """Run the seeds, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-50")
    parser.add_argument("--world", default="arena")
    parser.add_argument("--backends", default="coppeliasim,vrep")
    parser.add_argument("--coppeliasim", metavar="HOST:PORT", help="a real server with an empty scene")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    seeds = parse_seeds(options.seeds)
    print(machine(), flush=True)
    records = [_run_seed(REFERENCE, options.world, seed) for seed in seeds]
    for backend in options.backends.split(","):
        runs = (
            _run_in_joined_scenes(options.world, seeds)
            if backend == "vrep"
            else _run_in_built_scenes(options.world, seeds, options.coppeliasim)
        )
        records += runs
    groups = group_records(records)
    print_table(("backend", "verified", "contacts", "median", "slowest"), map(_build_row, groups))
    is_alike = _is_alike(records)
    return int(not (is_alike and all((group.verified_share or 0.0) >= VERIFIED for group in groups)))


def _run_seed(backend: str, world: str, seed: int, **options: object) -> Record:
    return perform(RunRequest("green-search", backend, world=world, seed=seed, options=options)).record


def _run_in_built_scenes(world: str, seeds: tuple[int, ...], server: str | None) -> Iterator[Record]:
    with ExitStack() as stack:
        host, _, port = (
            server.rpartition(":") if server else ("127.0.0.1", "", stack.enter_context(DoubleProcess()).zmq_port)
        )
        for seed in seeds:
            yield _report_failure(_run_seed("coppeliasim", world, seed, host=host, port=int(port)), "")


def _run_in_joined_scenes(world: str, seeds: tuple[int, ...]) -> Iterator[Record]:
    for seed in seeds:
        with DoubleProcess("rover", world, seed) as double:
            yield _report_failure(_run_seed("vrep", world, seed, port=double.legacy_port), double.command)


def _report_failure(record: Record, beside: str) -> Record:
    """Return the record of a run. If the run failed, print its command, and the command ``beside`` of the server."""
    if record.is_failure:
        print(
            f"failing: {record.command}  # {format_failure(record)}",
            *([f"beside: {beside}"] if beside else ()),
            sep="\n",
        )
    return record


def _build_row(group: Group) -> tuple[str, ...]:
    return (
        group.backend,
        f"{group.verified}/{group.runs}",
        format_contacts(group),
        format_time(group.median_time_s),
        format_time(group.slowest_time_s),
    )


def _is_alike(records: list[Record]) -> bool:
    is_alike = True
    for agreement in compare_backends(records):
        if agreement.first == REFERENCE:
            same, pairs = agreement.same_milestones, len(agreement.pairs)
            print(f"{agreement.second}: the same milestones in the same order on {same} of {pairs} seeds")
            is_alike &= same / pairs >= ALIKE
    return is_alike


if __name__ == "__main__":
    sys.exit(main())
