"""Compare green-search on virtual Raspberry Pi pins with green-search in the simulator, and measure memory.

    python -m benchmarks.virtual_pi --seeds 1-50

Every seed runs in the simulator, on the Pi's drivers with the same simulator behind virtual pins, and there again with
some echoes lost. Memory is the peak of a fresh process (VmHWM, on Linux) that imports robotcore, or executes a whole
run. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import argparse
import subprocess
import sys

from benchmarks.report import machine, print_table
from robotcore.runtime.plan import RunRequest
from robotcore.sweep import LocalEngine, Record, Sweep, run_sweep
from robotcore.sweep.local import count_cores
from robotcore.sweep.record import format_failure
from robotcore.sweep.spec import parse_seeds
from robotcore.sweep.statistics import Group, compare_backends, group_records
from robotcore.sweep.tables import format_contacts, format_time

VERIFIED, ALIKE = 0.97, 0.95
"""The bounds of two shares: verified runs on virtual pins, and seeds with the same milestones as in the simulator."""

PROCESSES = (
    ("import robotcore", "import robotcore", 45.0),
    (
        "a run of green-search on virtualpi",
        "from robotcore import RunRequest, run; run(RunRequest('green-search', 'virtualpi', seed=1))",
        120.0,
    ),
)
"""The title, the code and the bound of memory of each process, in MB (2^20 bytes)."""

HELD = "print([line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')][0])"


def main() -> int:
    """Measure the processes, run the seeds, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-50")
    parser.add_argument("--world", default="arena")
    parser.add_argument("--lost", type=float, default=0.2, help="the share of echoes that are lost")
    parser.add_argument("--jobs", type=int, default=count_cores())
    options = parser.parse_args()
    print(machine())
    is_small = _is_small()
    return int(
        not (_is_sound(options.world, parse_seeds(options.seeds), options.lost, LocalEngine(options.jobs)) and is_small)
    )


def _is_sound(world: str, seeds: tuple[int, ...], lost: float, engine: LocalEngine) -> bool:
    both = Sweep(RunRequest("green-search"), ("kinematic", "virtualpi"), (world,), seeds)
    lossy = RunRequest("green-search", options={"lost_echoes": lost})
    records = list(run_sweep(both, engine).records())
    deaf = list(run_sweep(Sweep(lossy, ("virtualpi",), (world,), seeds), engine).records())
    groups = {group.backend: group for group in group_records(records)}
    groups[f"virtualpi, {100 * lost:g} % of the echoes lost"] = group_records(deaf)[0]
    print_table(
        ("backend", "verified", "contacts", "median", "slowest"), [_build_row(*each) for each in groups.items()]
    )
    for record in [*records, *deaf]:
        if record.is_failure:
            print(f"failing: {record.command}  # {format_failure(record)}")
    is_sure = all((group.verified_share or 0.0) >= VERIFIED for group in groups.values())
    return _is_alike(records) and is_sure


def _build_row(name: str, group: Group) -> tuple[str, ...]:
    return (
        name,
        f"{group.verified}/{group.runs}",
        format_contacts(group),
        format_time(group.median_time_s),
        format_time(group.slowest_time_s),
    )


def _is_alike(records: list[Record]) -> bool:
    (agreement,) = compare_backends(records)
    same, pairs = agreement.same_milestones, len(agreement.pairs)
    print(f"the same milestones in the same order on {same} of {pairs} seeds")
    return same / pairs >= ALIKE


def _is_small() -> bool:
    held = [(name, _measure_peak_mb(code), bound) for name, code, bound in PROCESSES]
    rows = [(name, f"{most:.1f} MB", f"{bound:g} MB") for name, most, bound in held]
    print_table(("a process that does", "held at most", "bound"), rows)
    return all(most <= bound for _, most, bound in held)


def _measure_peak_mb(code: str) -> float:
    done = subprocess.run(  # noqa: S603  our own code
        [sys.executable, "-c", f"{code}; {HELD}"], check=True, capture_output=True, text=True
    )
    return int(done.stdout.split()[-1]) / 1024


if __name__ == "__main__":
    sys.exit(main())
