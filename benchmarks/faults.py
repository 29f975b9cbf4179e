"""What green-search does where one part of the robot fails: it finds the ball all the same, or stops and says why.

    python -m benchmarks.faults --seeds 1-20 --backends kinematic,pybullet

Each fault is on its own and of a moderate strength. A run passes where the simulator verifies its success, or where it
ended safely (exit status 3 or 4) with the failed device's name in its reason. Exit status 1 where a run of a fault does
neither, hangs, or where more runs touch something than the fault makes unavoidable.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.report import machine, print_table
from robotcore.outcome import Outcome
from robotcore.plan import Plan, RunRequest
from robotcore.sweep import LocalEngine, Record, Sweep, run_sweep
from robotcore.sweep.local import cores
from robotcore.sweep.seeds import seeds_of
from robotcore.sweep.words import fault

APP = "green-search"
NAMING = (3, 4)
"""The exit statuses of a run that a device, or the safety stage, ended."""


@dataclass(frozen=True)
class Case:
    """A fault, and the share of runs in which it may make the robot touch something."""

    spec: str
    contacts: float = 0.0


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
    Case("range spikes=0.05"),
    Case("range stuck=1.5 after=5"),
    Case("range lost=1 after=5"),
    Case("encoders drop=0.2"),
    Case("encoders freeze after=5"),
    Case("encoders delay=0.1"),
    Case("encoders slip=0.05"),
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
    """What the runs of one fault on one backend came to."""

    case: Case
    backend: str
    records: Sequence[Record]

    @property
    def succeeded(self) -> int:
        return sum(_has_succeeded(record) for record in self.records)

    @property
    def named(self) -> list[Record]:
        """The runs that ended safely and say which device is at fault."""
        return [record for record in self.records if not _has_succeeded(record) and self._is_named(record)]

    @property
    def unexplained(self) -> list[Record]:
        """The runs that neither succeeded nor named the device."""
        return [record for record in self.records if not (_has_succeeded(record) or self._is_named(record))]

    @property
    def touching(self) -> list[Record]:
        return [record for record in self.records if record.result.contacts != 0]

    @property
    def is_passed(self) -> bool:
        return not self.unexplained and len(self.touching) <= self.case.contacts * len(self.records)

    def _is_named(self, record: Record) -> bool:
        result = record.result
        return result.exit_status in NAMING and any(name in result.reason for name in _devices_of(self.case.spec))


def main() -> int:
    """Run every fault on every backend and print how it went."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1-20")
    parser.add_argument("--world", default="arena")
    parser.add_argument("--backends", default="kinematic")
    parser.add_argument("--jobs", type=int, default=cores())
    parser.add_argument("--fault", action="append", metavar="SPEC", help="one fault instead of all; may be repeated")
    asked = parser.parse_args()
    cases = tuple(map(Case, asked.fault)) if asked.fault else CASES
    backends = tuple(asked.backends.split(","))
    sweeps = {case: _sweep_of(case, backends, asked.world, seeds_of(asked.seeds)) for case in cases}
    tallies = [tally for case, sweep in sweeps.items() for tally in _tallies(case, sweep, asked.jobs)]
    print(machine())
    columns = ("fault", "backend", "succeeded", "stopped, named", "exit", "neither", "with contacts", "how a run ended")
    print_table(columns, map(_row, tallies))
    _tell_unexplained(tallies)
    return int(not all(tally.is_passed for tally in tallies))


def _sweep_of(case: Case, backends: tuple[str, ...], world: str, seeds: tuple[int, ...]) -> Sweep:
    return Sweep(RunRequest(APP, faults=(case.spec,)), backends, (world,), seeds)


def _tallies(case: Case, sweep: Sweep, jobs: int) -> list[Tally]:
    records = list(run_sweep(sweep, LocalEngine(jobs)).records())
    by_backend = {name: [each for each in records if each.result.backend == name] for name in sweep.backends}
    return [Tally(case, backend, found) for backend, found in by_backend.items()]


def _has_succeeded(record: Record) -> bool:
    return record.result.outcome is Outcome.SUCCESS and record.result.verified is True


def _devices_of(spec: str) -> frozenset[str]:
    (planned,) = Plan.of(RunRequest(APP, faults=(spec,))).faults
    return planned.target.devices


def _row(tally: Tally) -> tuple[str, ...]:
    named, runs = tally.named, len(tally.records)
    exits = sorted({str(record.result.exit_status) for record in named})
    example = named or tally.unexplained
    return (
        f"`{tally.case.spec}`",
        tally.backend,
        f"{tally.succeeded}/{runs}",
        f"{len(named)}/{runs}",
        ", ".join(exits),
        f"{len(tally.unexplained)}/{runs}",
        f"{len(tally.touching)}/{runs}",
        example[0].result.reason if example else "",
    )


def _tell_unexplained(tallies: Sequence[Tally]) -> None:
    for tally in tallies:
        for record in tally.records:
            if record in tally.unexplained or record in tally.touching:
                print(f"look at: {record.command}  # {fault(record)}")


if __name__ == "__main__":
    sys.exit(main())
