"""Interrupt deploys at random moments. Afterwards either the old release or the new one has to run.

    python -m benchmarks.deploy_interruptions --trials 30 --seed 1

The robot is a Debian that systemd boots (tests/system/deploy), which needs root. Each trial pushes a release that
drives at another speed. Every third push installs a package, and every fifth release is broken. At a random moment
within the time of such a push, one of four things happens:

- the client's push is killed
- all connections to the robot are killed
- the health check on the robot is killed
- the robot's power is cut, and the robot is booted again

Then the motors have to turn at the speed of the release that is in place. This is the old release or the new one, and
never a broken one. The exit status is 1 otherwise.
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
from tests.system.deploy.rover import Rover, add_requirement

KINDS = ("the client is killed", "the connections are killed", "the trial is killed", "the power is cut")
OLD, NEW, NEITHER = "the old runs", "the new runs", "NEITHER"
LIMIT_S = 180.0


@dataclass(frozen=True)
class Interruption:
    """An interruption of a push: what is interrupted, and when."""

    kind: str
    after_s: float
    speed_rad_s: float
    is_broken: bool
    need: str


def main() -> bool:
    """Print the outcomes of each kind of interruption. Return whether a release ran after each trial."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=at_least_one, default=30)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(machine())
    counts: Counter[tuple[str, str]] = Counter()
    with robot() as rover:
        takes_s = {
            has_needs: _measure_push_s(rover, _format_requirement(options.trials) if has_needs else "")
            for has_needs in (False, True)
        }
        for trial in range(options.trials):
            drawn = _draw_interruption(trial, Random(f"{options.seed} {trial}"), takes_s)
            outcome = _try_interruption(rover, drawn)
            counts[drawn.kind, outcome] += 1
            part = drawn.after_s / takes_s[bool(drawn.need)]
            print(f"{trial + 1:3}  {drawn.kind} after {part:.0%} of a push: {outcome}", file=sys.stderr, flush=True)
    outcomes = (OLD, NEW, NEITHER)
    print_table(("", *outcomes), [(kind, *(str(counts[kind, each]) for each in outcomes)) for kind in KINDS])
    return not any(counts[kind, NEITHER] for kind in KINDS)


def _draw_interruption(trial: int, random: Random, takes_s: Mapping[bool, float]) -> Interruption:
    has_needs = trial % 3 == 2
    return Interruption(
        kind=KINDS[trial % len(KINDS)],
        after_s=random.uniform(0.0, takes_s[has_needs]),
        speed_rad_s=_compute_speed(trial),
        is_broken=trial % 5 == 4,
        need=_format_requirement(trial) if has_needs else "",
    )


def _compute_speed(trial: int) -> float:
    return 1.0 + trial % 50 / 10


def _format_requirement(trial: int) -> str:
    """Return the requirement of a trial. The requirements differ, but one package meets all of them."""
    return f"six>=1.0.{trial}"


def _measure_push_s(rover: Rover, need: str) -> float:
    start = perf_counter()
    with add_requirement(rover.project, need) if need else nullcontext():
        rover.drive(2.0)
    return perf_counter() - start


def _try_interruption(rover: Rover, drawn: Interruption) -> str:
    old = rover.release
    chosen = [f"speed_rad_s={drawn.speed_rad_s:g}", *(["fault=raise", "at=5"] if drawn.is_broken else [])]
    settings = [word for setting in chosen for word in ("--set", setting)]
    with (
        add_requirement(rover.project, drawn.need) if drawn.need else nullcontext(),
        rover.run_push(*settings) as push,
    ):
        with suppress(subprocess.TimeoutExpired):
            push.wait(drawn.after_s)
        _interrupt(drawn.kind, rover, push)
        push.communicate(timeout=LIMIT_S)
    return _find_running(rover, old, drawn)


def _find_running(rover: Rover, old: str, drawn: Interruption) -> str:
    rover.await_health_check()
    speed = _read_speed(rover)
    is_new = rover.release != old
    if (is_new and (drawn.is_broken or speed != drawn.speed_rad_s)) or not rover.motors.are_driven(speed):
        return NEITHER
    return NEW if is_new else OLD


def _read_speed(rover: Rover) -> float:
    words = json.loads((rover.files / "current" / "release.json").read_text())["run"]
    return next(float(word.partition("=")[2]) for word in words if word.startswith("speed_rad_s="))


def _interrupt(kind: str, rover: Rover, push: subprocess.Popen[str]) -> None:
    match kind:
        case "the client is killed":
            push.kill()
        case "the connections are killed":
            rover.machine.as_root("systemctl", "kill", "--signal=KILL", "session-*", is_checked=False)
        case "the trial is killed":
            with suppress(subprocess.CalledProcessError):  # the health check has not begun yet
                rover.client.ssh("systemctl --user kill --signal=KILL robotcore-trial.service")
        case "the power is cut":
            rover.machine.cut_power()
            rover.motors.mark()
            rover.machine.boot()


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy_interruptions", main))
