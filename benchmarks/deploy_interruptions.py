"""Deploys interrupted at random moments: the old release runs, or the new one; never neither, and never half of one.

    python -m benchmarks.deploy_interruptions --trials 30 --seed 1

The robot is a Debian that systemd boots (tests/system/deploy); it needs root. In each trial a release that drives at
another speed is pushed, every third with something to be installed, every fifth broken. At a moment that the seed
draws, within the time that such a push takes, one of these is done: the client's push is killed, all connections to the
robot are, whoever conducts the trial there is, or the robot's power is cut and it is booted again. Then the motors
have to be driven, at the speed of the release that is in place, which is the old or the new one; a broken one may not
be. Exit status 1 where that is not so.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from random import Random
from time import perf_counter

from benchmarks.deploy import robot
from benchmarks.report import at_least_one, machine, print_table
from tests.system import needs
from tests.system.deploy.rover import Rover, with_requirement

KINDS = ("the client is killed", "the connections are killed", "the trial is killed", "the power is cut")
OLD, NEW, NEITHER = "the old runs", "the new runs", "NEITHER"
LIMIT_S = 180.0


@dataclass(frozen=True)
class Interruption:
    """What is done to a push, and when."""

    kind: str
    after_s: float
    speed_rad_s: float
    is_broken: bool
    need: str


def main() -> bool:
    """Print what came of each kind; return whether there was never neither."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=at_least_one, default=30)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    print(machine())
    came: Counter[tuple[str, str]] = Counter()
    with robot() as rover:
        takes_s = {has_needs: _taken_s(rover, _need(asked.trials) if has_needs else "") for has_needs in (False, True)}
        for trial in range(asked.trials):
            drawn = _drawn(trial, Random(f"{asked.seed} {trial}"), takes_s)
            outcome = _tried(rover, drawn)
            came[drawn.kind, outcome] += 1
            part = drawn.after_s / takes_s[bool(drawn.need)]
            print(f"{trial + 1:3}  {drawn.kind} after {part:.0%} of a push: {outcome}", file=sys.stderr, flush=True)
    outcomes = (OLD, NEW, NEITHER)
    print_table(("", *outcomes), [(kind, *(str(came[kind, each]) for each in outcomes)) for kind in KINDS])
    return not any(came[kind, NEITHER] for kind in KINDS)


def _drawn(trial: int, random: Random, takes_s: Mapping[bool, float]) -> Interruption:
    has_needs = trial % 3 == 2
    return Interruption(
        kind=KINDS[trial % len(KINDS)],
        after_s=random.uniform(0.0, takes_s[has_needs]),
        speed_rad_s=_speed(trial),
        is_broken=trial % 5 == 4,
        need=_need(trial) if has_needs else "",
    )


def _speed(trial: int) -> float:
    return 1.0 + trial % 50 / 10


def _need(trial: int) -> str:
    """Return a requirement that is another one in each trial, and met by the same package."""
    return f"six>=1.0.{trial}"


def _taken_s(rover: Rover, need: str) -> float:
    """Return how long a push takes that nobody interrupts."""
    start = perf_counter()
    with with_requirement(rover.project, need) if need else nullcontext():
        rover.drive(2.0)
    return perf_counter() - start


def _tried(rover: Rover, drawn: Interruption) -> str:
    """Push, interrupt, and return what runs when all has come to rest."""
    old = rover.release
    chosen = [f"speed_rad_s={drawn.speed_rad_s:g}", *(["fault=raise", "at=5"] if drawn.is_broken else [])]
    settings = [word for setting in chosen for word in ("--set", setting)]
    with (
        with_requirement(rover.project, drawn.need) if drawn.need else nullcontext(),
        rover.run_push(*settings) as push,
    ):
        with suppress(subprocess.TimeoutExpired):
            push.wait(drawn.after_s)
        _interrupt(drawn.kind, rover, push)
        push.communicate(timeout=LIMIT_S)
    return _running(rover, old, drawn)


def _running(rover: Rover, old: str, drawn: Interruption) -> str:
    rover.await_health_check()
    speed = _speed_of(rover)
    is_new = rover.release != old
    if (is_new and (drawn.is_broken or speed != drawn.speed_rad_s)) or not rover.motors.are_driven(speed):
        return NEITHER
    return NEW if is_new else OLD


def _speed_of(rover: Rover) -> float:
    """Return the speed of the release that is in place, as its manifest has it."""
    words = json.loads((rover.files / "current" / "release.json").read_text())["run"]
    return next(float(word.partition("=")[2]) for word in words if word.startswith("speed_rad_s="))


def _interrupt(kind: str, rover: Rover, push: subprocess.Popen[str]) -> None:
    match kind:
        case "the client is killed":
            push.kill()
        case "the connections are killed":
            rover.machine.as_root("systemctl", "kill", "--signal=KILL", "session-*", is_checked=False)
        case "the trial is killed":
            with suppress(subprocess.CalledProcessError):  # there is none before it begins
                rover.client.ssh("systemctl --user kill --signal=KILL robotcore-trial.service")
        case "the power is cut":
            rover.machine.cut_power()
            rover.motors.mark()
            rover.machine.boot()


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy_interruptions", main))
