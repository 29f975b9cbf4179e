"""Run green-search with one injected fault at a time. It has to find the ball, or to stop and name the fault.

    python -m benchmarks.faults --seeds 1-20 --backends kinematic,pybullet

Each fault is of a moderate strength. A run passes if the simulator verifies its success without a contact, or if it
stopped (exit status 3 or 4) for a reason that names the faulty part. All other runs are listed. The exit status is 1 if
there are any. `--fault` chooses one fault. A contact before a stop is excused under a fault that makes contacts
unavoidable; the table has the reason.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

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


@dataclass(frozen=True)
class Case:
    """A fault, and the reason why it makes a contact unavoidable. The reason is empty if a contact is avoidable."""

    spec: str
    touching: str = ""


CASES = (
    Case("camera drop=0.3"),
    Case("camera freeze after=5 lasts=0.5"),
    Case("camera freeze after=5"),
    Case("camera delay=0.15"),
    Case("camera noise=15"),
    Case("camera lost=1 after=5"),
    Case("range drop=0.3"),
    Case("range freeze after=5"),
    Case("range delay=0.15"),
    Case("range noise=0.03"),
    Case("range no_echo=0.3"),
    Case("range spikes=0.05", "two false echoes in a row may erase an obstacle from the map"),
    Case("range stuck=1.5 after=5", "a robot that does not turn may be in a corridor, where echoes stay the same"),
    Case("range lost=1 after=5"),
    Case("encoders drop=0.2"),
    Case("encoders freeze after=5"),
    Case("encoders delay=0.1"),
    Case("encoders slip=0.05", "until an echo contradicts the map, the pose is wrong"),
    Case("left_encoder slip=1 after=5"),
    Case("left_motor weak=0.7"),
    Case("left_motor dead after=5"),
    Case("left_motor reversed after=5"),
    Case("drive dead after=5"),
    Case("loop stall=0.3 after=5 every=5"),
    Case("connection lost=1 after=5"),
    Case("display lost=1 after=5"),
)


@dataclass(frozen=True)
class Tally:
    """The runs with one fault on one backend. Each run is in one of three lists, whether or not it had a contact."""

    case: Case
    backend: str
    succeeded: Sequence[Record]
    named: Sequence[Record]
    others: Sequence[Record]

    @classmethod
    def of(cls, case: Case, backend: str, records: Sequence[Record]) -> Tally:
        devices = _list_devices(case.spec)
        succeeded = [record for record in records if _has_succeeded(record)]
        named = [record for record in records if _is_named(record, devices)]
        return cls(case, backend, succeeded, named, [each for each in records if each not in (*succeeded, *named)])

    @property
    def records(self) -> list[Record]:
        return [*self.succeeded, *self.named, *self.others]

    @property
    def touching(self) -> list[Record]:
        return [record for record in self.records if record.result.contacts != 0]

    @property
    def suspicious(self) -> list[Record]:
        """The runs to inspect: those with a contact, or with neither a success nor a reason that names the fault."""
        return [record for record in self.records if record in self.others or record in self.touching]

    @property
    def is_passed(self) -> bool:
        return all(self._is_excused(record) for record in self.suspicious)

    def _is_excused(self, record: Record) -> bool:
        return bool(self.case.touching and record.result.contacts and record.result.exit_status in NAMING)


def main() -> int:
    """Run every fault on every backend, and print the results."""
    options = parse_options(__doc__, seeds="1-20", world="arena", backends="kinematic", jobs=count_cores(), fault="")
    cases = (Case(options.fault),) if options.fault else CASES
    backends = tuple(options.backends.split(","))
    sweeps = {case: _build_sweep(case, backends, options.world, parse_seeds(options.seeds)) for case in cases}
    tallies = [tally for case, sweep in sweeps.items() for tally in _run_case(case, sweep, options.jobs)]
    columns = "fault, backend, succeeded, stopped and named, exit, otherwise, with contacts, why a contact is excused"
    print_table(columns.split(", "), map(_build_row, tallies))
    for tally in tallies:
        for record in tally.suspicious:
            print(f"inspect: {record.command}  # {format_failure(record)}")
    return int(not all(tally.is_passed for tally in tallies))


def _build_sweep(case: Case, backends: tuple[str, ...], world: str, seeds: tuple[int, ...]) -> Sweep:
    return Sweep(RunRequest(APP, faults=(case.spec,)), backends, (world,), seeds)


def _run_case(case: Case, sweep: Sweep, jobs: int) -> list[Tally]:
    records = list(run_sweep(sweep, LocalEngine(jobs)).records())
    by_backend = {name: [each for each in records if each.result.backend == name] for name in sweep.backends}
    return [Tally.of(case, backend, found) for backend, found in by_backend.items()]


def _has_succeeded(record: Record) -> bool:
    return record.result.outcome is Outcome.SUCCESS and record.result.verified is True


def _is_named(record: Record, devices: frozenset[str]) -> bool:
    result = record.result
    return result.exit_status in NAMING and not result.contacts and any(name in result.reason for name in devices)


def _list_devices(spec: str) -> frozenset[str]:
    (planned,) = Plan.of(RunRequest(APP, faults=(spec,))).faults
    return planned.target.devices


def _build_row(tally: Tally) -> tuple[str, ...]:
    runs = len(tally.records)
    return (
        f"`{tally.case.spec}`",
        tally.backend,
        f"{len(tally.succeeded)}/{runs}",
        f"{len(tally.named)}/{runs}",
        ", ".join(sorted({str(record.result.exit_status) for record in tally.named})),
        f"{len(tally.others)}/{runs}",
        f"{len(tally.touching)}/{runs}",
        tally.case.touching,
    )


if __name__ == "__main__":
    sys.exit(main())
