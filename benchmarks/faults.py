"""Run green-search with one injected fault at a time. It has to find the ball, or to stop and name the fault.

    python -m benchmarks.faults --seeds 1-20 --backends kinematic,pybullet

Each fault is of a moderate strength. A run passes if the simulator verifies its success without a contact, or if it
stopped (exit status 3 or 4) for a reason that names the faulty part. All other runs are listed. The exit status is 1 if
there are any. `--fault` chooses one fault. A contact before a stop is excused under a fault that makes contacts
unavoidable; the table has the reason.
"""

from __future__ import annotations

import sys

from benchmarks.report import parse_options, print_table
from robotcore.runtime.plan import Plan, RunRequest
from robotcore.runtime.result import Outcome
from robotcore.sweep import LocalEngine, Record, Sweep, run_sweep
from robotcore.sweep.engine import count_cores
from robotcore.sweep.record import format_failure
from robotcore.sweep.spec import parse_seeds

APP = "green-search"
NAMING = (3, 4)
"""The exit statuses of a run that was ended by a device's error or by the safety stage."""


CASES = {
    "camera drop=0.3": "",
    "camera freeze after=5 lasts=0.5": "",
    "camera freeze after=5": "",
    "camera delay=0.15": "",
    "camera noise=15": "",
    "camera lost=1 after=5": "",
    "range drop=0.3": "",
    "range freeze after=5": "",
    "range delay=0.15": "",
    "range noise=0.03": "",
    "range no_echo=0.3": "",
    "range spikes=0.05": "two false echoes in a row may erase an obstacle from the map",
    "range stuck=1.5 after=5": "a robot that does not turn may be in a corridor, where echoes stay the same",
    "range lost=1 after=5": "",
    "encoders drop=0.2": "",
    "encoders freeze after=5": "",
    "encoders delay=0.1": "",
    "encoders slip=0.05": "until an echo contradicts the map, the pose is wrong",
    "left_encoder slip=1 after=5": "",
    "left_motor weak=0.7": "",
    "left_motor dead after=5": "",
    "left_motor reversed after=5": "",
    "drive dead after=5": "",
    "loop stall=0.3 after=5 every=5": "",
    "connection lost=1 after=5": "",
    "display lost=1 after=5": "",
}
"""The faults. The value is the reason why a fault makes a contact unavoidable, or empty if a contact is avoidable."""

COLUMNS = (
    *("fault", "backend", "succeeded", "stopped and named", "exit", "otherwise", "with contacts"),
    "why a contact is excused",
)


def main() -> int:
    """Run every fault on every backend, and print the results."""
    options = parse_options(__doc__, seeds="1-20", world="arena", backends="kinematic", jobs=count_cores(), fault="")
    backends = tuple(options.backends.split(","))
    rows, suspicious, is_passed = list[tuple[str, ...]](), list[Record](), True
    for fault, excuse in {options.fault: ""}.items() if options.fault else CASES.items():
        request = RunRequest(APP, faults=(fault,))
        sweep = Sweep(request, backends, (options.world,), parse_seeds(options.seeds))
        records = list(run_sweep(sweep, LocalEngine(options.jobs)).records())
        (planned,) = Plan.resolve(request).faults
        for backend in backends:
            runs = [record for record in records if record.result.backend == backend]
            named = [record for record in runs if _is_named(record, planned.target.devices)]
            succeeded = [record for record in runs if _has_succeeded(record)]
            others = [record for record in runs if record not in (*named, *succeeded)]
            touching = [record for record in runs if record.result.contacts != 0]
            counts = [f"{len(each)}/{len(runs)}" for each in (succeeded, named, others, touching)]
            statuses = ", ".join(sorted({str(record.result.exit_status) for record in named}))
            rows.append((f"`{fault}`", backend, *counts[:2], statuses, *counts[2:], excuse))
            inspected = [record for record in runs if record in others or record in touching]
            is_passed &= all(
                excuse and record.result.contacts and record.result.exit_status in NAMING for record in inspected
            )
            suspicious += inspected
    print_table(COLUMNS, rows)
    for record in suspicious:
        print(f"inspect: {record.command}  # {format_failure(record)}")
    return int(not is_passed)


def _has_succeeded(record: Record) -> bool:
    return record.result.outcome is Outcome.SUCCESS and record.result.verified is True


def _is_named(record: Record, devices: frozenset[str]) -> bool:
    result = record.result
    return result.exit_status in NAMING and not result.contacts and any(name in result.reason for name in devices)


if __name__ == "__main__":
    sys.exit(main())
