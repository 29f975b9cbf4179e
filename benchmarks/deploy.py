"""Measure the time of a first deploy, of a second deploy, and of rsync of the same files by hand.

    python -m benchmarks.deploy --rounds 5

The robot is a Debian that systemd boots (tests/system/deploy), which needs root. Its only connection is that to the
client. So the first deploy sends every wheel, which the client has cached before. The second deploy sends one changed
file. For both, the benchmark prints the time until the new release first drives the motors, and the time until the
command ends. Between them, the robot checks the health of the release for some seconds. By hand, rsync sends the files
of the first deploy, with the wheels, to an empty folder, and nothing is installed. A round takes one of each, and the
benchmark prints medians. The exit status is 1 if the second deploy takes more than half of the first.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic

from benchmarks.report import at_least_one, machine, print_table
from robotcore.deploy.agent.releases import PROJECT, SITE, Release
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.robot_answers import ProbeAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.deploy.wheels import Platform, fetch_wheels
from tests.system import needs
from tests.system.deploy.client import HOST, Client
from tests.system.deploy.machine import make_machine as boot_machine
from tests.system.deploy.machine import require_machine
from tests.system.deploy.rover import BENCH, Rover

BOUND = 0.5
FIRST, SECOND = "first deploy, no network there", "second deploy, one file changed"
BY_HAND = "rsync of the same files by hand"
DRIVING, ENDED = "until it drives", "to the end"


@contextmanager
def robot() -> Iterator[Rover]:
    """Boot a robot that drives. Raises NotRunError if none can be booted."""
    require_machine()
    with TemporaryDirectory(prefix="robotcore-desk-") as folder, boot_machine() as target:
        target.boot()
        client = Client.of(Path(folder), target)
        rover = Rover(target, client, Path(shutil.copytree(BENCH, Path(folder) / "bench")))
        client.install(rover.project)
        rover.drive(2.0)
        yield rover


def main() -> bool:
    """Print the medians of all rounds. Return whether a second deploy takes at most half of the time of a first one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=at_least_one, default=5)
    rounds = parser.parse_args().rounds
    print(machine())
    taken: dict[tuple[str, str], list[float]] = defaultdict(list)
    with robot() as rover:
        for _ in range(rounds):
            for what, until, seconds in _run_round(rover):
                taken[what, until].append(seconds)
    print_table(
        ("", "", "s: median", "least", "most"),
        [(*which, *(f"{of(each):.1f}" for of in (statistics.median, min, max))) for which, each in taken.items()],
    )
    ratios = {
        until: statistics.median(taken[SECOND, until]) / statistics.median(taken[FIRST, until])
        for until in (DRIVING, ENDED)
    }
    shown = ", ".join(f"{ratio:.2f} {until}" for until, ratio in ratios.items())
    print(f"the share of the first deploy's time that the second one takes: {shown}; to be reached: {BOUND}")
    return ratios[ENDED] <= BOUND


def _run_round(rover: Rover) -> Iterator[tuple[str, str, float]]:
    """Yield each action of a round, the event that ends the action, and the seconds between both."""
    rover.run("remove", "--yes")
    yield from _time_deploy(rover, FIRST)
    yield BY_HAND, ENDED, _time_rsync(rover)
    app = rover.project / "drive_ahead.py"
    app.write_text(f"{app.read_text()}# Changed.\n")
    yield from _time_deploy(rover, SECOND)


def _time_deploy(rover: Rover, what: str) -> Iterator[tuple[str, str, float]]:
    rover.motors.mark()
    start = monotonic()
    rover.run("push", "--skip-checks", "--offline")
    yield what, ENDED, monotonic() - start
    process = rover.motors.await_driving()
    drove = min(each.time_s for each in rover.motors.commands() if each.process == process and each.rad_s)
    yield what, DRIVING, drove - start


def _time_rsync(rover: Rover) -> float:
    """Return the seconds that rsync alone takes for the same files, from the client to an empty folder."""
    home = rover.client.folder / "by hand"
    release = rover.files / "current"
    for folder in (release / PROJECT, release / SITE, _fetch_wheels(rover, Release.read(release).requirements)):
        shutil.copytree(folder, home / folder.name, symlinks=True, dirs_exist_ok=True)
    rover.client.ssh("rm -rf by-hand")
    start = monotonic()
    rover.client.rsync(home, "by-hand")
    return monotonic() - start


def _fetch_wheels(rover: Rover, requirements: tuple[str, ...]) -> Path:
    with RobotLink(RobotAddress.parse(HOST), rover.client.config) as link:
        return fetch_wheels(requirements, Platform.of(link.call("probe", ProbeAnswer)), print)


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy", main))
