"""What green-search does where one part of the robot fails: it finds the ball all the same, or stops and says why.

    python -m benchmarks.faults --seeds 1-20 --backends kinematic,pybullet

Each fault is on its own and of a moderate strength. A run is well where the simulator verifies its success without a
contact, or where it was stopped (exit status 3 or 4) for a reason that names the part that failed. The others are told
one by one. Exit status 1 where there are any, but for those that touched something before they were stopped, under a
fault that makes this unavoidable: the table says why.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.report import machine, print_table
from robotcore.runtime.plan import Plan, RunRequest
from robotcore.runtime.result import Outcome
from robotcore.sweep import LocalEngine, Record, Sweep, run_sweep
from robotcore.sweep.local import count_cores
from robotcore.sweep.record import format_failure
from robotcore.sweep.spec import parse_seeds

APP = "green-search"
NAMING = (3, 4)
"""The exit statuses of a run that a device, or the safety stage, ended."""


@dataclass(frozen=True)
class Case:
    """A fault, and in words why a run may touch something under it, however careful the robot is; else nothing."""

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
    Case("range spikes=0.05", "two false echoes in a row may wipe out what stands there"),
    Case("range stuck=1.5 after=5", "who has not turned may be in a corridor, where echoes stay the same"),
    Case("range lost=1 after=5"),
    Case("encoders drop=0.2"),
    Case("encoders freeze after=5"),
    Case("encoders delay=0.1"),
    Case("encoders slip=0.05", "until an echo refutes the map, nobody knows that the robot is elsewhere"),
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
    """What the runs of one fault on one backend came to: each is in one of the first three, perhaps touching too."""

    case: Case
    backend: str
    succeeded: Sequence[Record]
    named: Sequence[Record]
    others: Sequence[Record]

    @classmethod
    def of(cls, case: Case, backend: str, records: Sequence[Record]) -> Tally:
        devices = _devices_of(case.spec)
        succeeded = [record for record in records if _has_succeeded(record)]
        named = [record for record in records if _names(record, devices)]
        return cls(case, backend, succeeded, named, [each for each in records if each not in (*succeeded, *named)])

    @property
    def records(self) -> list[Record]:
        return [*self.succeeded, *self.named, *self.others]

    @property
    def touching(self) -> list[Record]:
        return [record for record in self.records if record.result.contacts != 0]

    @property
    def spoilt(self) -> list[Record]:
        """The runs to look at."""
        return [record for record in self.records if record in self.others or record in self.touching]

    @property
    def is_passed(self) -> bool:
        return all(self._is_excused(record) for record in self.spoilt)

    def _is_excused(self, record: Record) -> bool:
        return bool(self.case.touching and record.result.contacts and record.result.exit_status in NAMING)


def main() -> int:
    """Run every fault on every backend and print how it went."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-20")
    parser.add_argument("--world", default="arena")
    parser.add_argument("--backends", default="kinematic")
    parser.add_argument("--jobs", type=int, default=count_cores())
    parser.add_argument("--fault", action="append", metavar="SPEC", help="one fault instead of all; may be repeated")
    asked = parser.parse_args()
    cases = tuple(map(Case, asked.fault)) if asked.fault else CASES
    backends = tuple(asked.backends.split(","))
    sweeps = {case: _sweep_of(case, backends, asked.world, parse_seeds(asked.seeds)) for case in cases}
    tallies = [tally for case, sweep in sweeps.items() for tally in _tallies(case, sweep, asked.jobs)]
    print(machine())
    columns = (
        "fault",
        "backend",
        "succeeded",
        "stopped and named",
        "exit",
        "otherwise",
        "with contacts",
        "the first one told",
        "why it may touch",
    )
    print_table(columns, map(_row, tallies))
    for tally in tallies:
        for record in tally.spoilt:
            print(f"look at: {record.command}  # {format_failure(record)}")
    return int(not all(tally.is_passed for tally in tallies))


def _sweep_of(case: Case, backends: tuple[str, ...], world: str, seeds: tuple[int, ...]) -> Sweep:
    return Sweep(RunRequest(APP, faults=(case.spec,)), backends, (world,), seeds)


def _tallies(case: Case, sweep: Sweep, jobs: int) -> list[Tally]:
    records = list(run_sweep(sweep, LocalEngine(jobs)).records())
    by_backend = {name: [each for each in records if each.result.backend == name] for name in sweep.backends}
    return [Tally.of(case, backend, found) for backend, found in by_backend.items()]


def _has_succeeded(record: Record) -> bool:
    return record.result.outcome is Outcome.SUCCESS and record.result.verified is True


def _names(record: Record, devices: frozenset[str]) -> bool:
    """Return whether the run was stopped, touching nothing, for a reason with the name of one of the devices in it."""
    result = record.result
    return result.exit_status in NAMING and not result.contacts and any(name in result.reason for name in devices)


def _devices_of(spec: str) -> frozenset[str]:
    (planned,) = Plan.of(RunRequest(APP, faults=(spec,))).faults
    return planned.target.devices


def _row(tally: Tally) -> tuple[str, ...]:
    runs = len(tally.records)
    reasons = [record.result.reason for record in (*tally.named, *tally.others)]
    return (
        f"`{tally.case.spec}`",
        tally.backend,
        f"{len(tally.succeeded)}/{runs}",
        f"{len(tally.named)}/{runs}",
        ", ".join(sorted({str(record.result.exit_status) for record in tally.named})),
        f"{len(tally.others)}/{runs}",
        f"{len(tally.touching)}/{runs}",
        reasons[0].partition(". ")[0] if reasons else "",
        tally.case.touching,
    )


if __name__ == "__main__":
    sys.exit(main())
