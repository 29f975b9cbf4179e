"""How often green-search finds the ball, and whether the same seed gives the same run.

python -m benchmarks.success --seeds 0-29 --worlds arena,clutter --backends kinematic,pybullet
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from itertools import product

from benchmarks.report import machine, print_table
from robotcore import RunRequest, RunResult, run

Case = tuple[str, str, int]


def main() -> None:
    """Run every combination and print how it went, with each failure by name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0-29", help="first-last")
    parser.add_argument("--worlds", default="arena,clutter")
    parser.add_argument("--backends", default="kinematic,pybullet")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--twice", type=int, default=5, help="how many seeds of each are run twice, for their digests")
    asked = parser.parse_args()
    first, _, last = asked.seeds.partition("-")
    seeds = range(int(first), int(last or first) + 1)
    groups = list(product(asked.backends.split(","), asked.worlds.split(",")))
    print(machine())
    with ProcessPoolExecutor(asked.jobs) as pool:
        rows = [_row(pool, backend, world, seeds, asked.twice) for backend, world in groups]
    columns = (
        "backend",
        "world",
        "verified",
        "contacts",
        "median time, s",
        "slowest, s",
        "equal digests",
        "different seeds",
    )
    print_table(columns, rows)


def _row(pool: ProcessPoolExecutor, backend: str, world: str, seeds: range, twice: int) -> list[str]:
    results = list(pool.map(_result, [(backend, world, seed) for seed in seeds]))
    again = list(pool.map(_result, [(backend, world, seed) for seed in seeds[:twice]]))
    for result in results:
        if not (result.verified and result.contacts == 0):
            print(
                f"  failed: {_command(result)}  # {result.outcome.value}, contacts {result.contacts}: {result.reason}"
            )
    verified = sum(bool(result.verified) for result in results)
    times = sorted(result.sim_time_s for result in results)
    same = sum(a.trace_sha256 == b.trace_sha256 for a, b in zip(results, again, strict=False))
    return [
        backend,
        world,
        f"{verified}/{len(results)}",
        str(sum(result.contacts or 0 for result in results)),
        f"{times[len(times) // 2]:.1f}",
        f"{times[-1]:.1f}",
        f"{same}/{len(again)}",
        f"{len({result.trace_sha256 for result in results})}/{len(results)}",
    ]


def _result(case: Case) -> RunResult:
    backend, world, seed = case
    return run(RunRequest("green-search", backend=backend, world=world, seed=seed))


def _command(result: RunResult) -> str:
    return f"robotcore run {result.app} --backend {result.backend} --world {result.world} --seed {result.seed}"


if __name__ == "__main__":
    main()
