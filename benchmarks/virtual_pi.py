"""Whether the app finds the ball through gpiozero as it does in the simulator, and how much memory that takes.

    python -m benchmarks.virtual_pi --seeds 1-50

Every seed is run in the simulator, on the drivers of a real Pi with the same simulator behind their virtual pins, and
once more there with some of the echoes lost. Memory is the most that a fresh process held (VmHWM, on Linux), by
importing robotcore, and by a whole run. Exit status 1 where a bound is broken.
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
"""The bounds: of verified runs on virtual pins, and of seeds with the same milestones as in the simulator."""

PROCESSES = (
    ("import robotcore", "import robotcore", 45.0),
    (
        "a run of green-search on virtualpi",
        "from robotcore import RunRequest, run; run(RunRequest('green-search', 'virtualpi', seed=1))",
        120.0,
    ),
)
"""What a process does, its code, and the bound of its memory, in MB of 2^20 bytes."""

HELD = "print([line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')][0])"


def main() -> int:
    """Weigh the processes, run the seeds, print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-50")
    parser.add_argument("--world", default="arena")
    parser.add_argument("--lost", type=float, default=0.2, help="the share of echoes that are lost")
    parser.add_argument("--jobs", type=int, default=count_cores())
    asked = parser.parse_args()
    print(machine())
    is_small = _is_small()
    return int(not (_is_sound(asked.world, parse_seeds(asked.seeds), asked.lost, LocalEngine(asked.jobs)) and is_small))


def _is_sound(world: str, seeds: tuple[int, ...], lost: float, engine: LocalEngine) -> bool:
    """Run every seed, print how the backends compare, and return whether virtual pins are as good as they must be."""
    both = Sweep(RunRequest("green-search"), ("kinematic", "virtualpi"), (world,), seeds)
    lossy = RunRequest("green-search", options={"lost_echoes": lost})
    records = list(run_sweep(both, engine).records())
    deaf = list(run_sweep(Sweep(lossy, ("virtualpi",), (world,), seeds), engine).records())
    groups = {group.backend: group for group in group_records(records)}
    groups[f"virtualpi, {100 * lost:g} % of the echoes lost"] = group_records(deaf)[0]
    print_table(("backend", "verified", "contacts", "median", "slowest"), [_row(*each) for each in groups.items()])
    for record in [*records, *deaf]:
        if record.is_failure:
            print(f"failing: {record.command}  # {format_failure(record)}")
    is_sure = all((group.verified_share or 0.0) >= VERIFIED for group in groups.values())
    return _is_alike(records) and is_sure


def _row(name: str, group: Group) -> tuple[str, ...]:
    return (
        name,
        f"{group.verified}/{group.runs}",
        format_contacts(group),
        format_time(group.median_time_s),
        format_time(group.slowest_time_s),
    )


def _is_alike(records: list[Record]) -> bool:
    """Print on how many seeds the milestones are those of the simulator, and return whether these are enough."""
    (agreement,) = compare_backends(records)
    same, pairs = agreement.same_milestones, len(agreement.pairs)
    print(f"the same milestones in the same order on {same} of {pairs} seeds")
    return same / pairs >= ALIKE


def _is_small() -> bool:
    """Print how much memory a fresh process held at most, and return whether that is little enough."""
    held = [(name, _held_mb(code), bound) for name, code, bound in PROCESSES]
    rows = [(name, f"{most:.1f} MB", f"{bound:g} MB") for name, most, bound in held]
    print_table(("a process that does", "held at most", "bound"), rows)
    return all(most <= bound for _, most, bound in held)


def _held_mb(code: str) -> float:
    """Return the most memory that a fresh process held that ran this code, in MB (2^20 bytes)."""
    done = subprocess.run(  # noqa: S603  our own code
        [sys.executable, "-c", f"{code}; {HELD}"], check=True, capture_output=True, text=True
    )
    return int(done.stdout.split()[-1]) / 1024


if __name__ == "__main__":
    sys.exit(main())
