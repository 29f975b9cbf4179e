"""How long a first deploy takes, a second one, and rsync of the same files by hand.

    python -m benchmarks.deploy --rounds 5

The robot is a Debian that systemd boots (tests/system/deploy); it needs root. It has no network but the wire to the
desk, so the first deploy brings every wheel (the desk has them by then). The second one changes one file. Both include
the time in which the robot looks whether the release lives. By hand, rsync sends what the first one had sent, the
wheels too, to an empty folder, and nothing is installed. A round takes one of each; the medians are told. Exit
status 1 where the second takes more than half of the first.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

from benchmarks.deployed.robot import robot
from benchmarks.report import machine, print_table
from robotcore.deploy.aboard.releases.release import Release
from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.link import Link
from robotcore.deploy.packages.target import Target
from robotcore.deploy.packages.wheelhouse import wheels_for
from tests.system import needs
from tests.system.deploy.desk import HOST
from tests.system.deploy.rover import Rover

BOUND = 0.5


def main() -> bool:
    """Print the medians; return whether the second is at most half of the first."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    print(machine())
    taken: dict[str, list[float]] = {what: [] for what in WAYS}
    with robot() as rover:
        for _ in range(rounds):
            for what, way in WAYS.items():
                taken[what].append(_seconds(way(rover)))
    print_table(
        ("", "s: median", "least", "most"),
        [(what, *(f"{f(each):.1f}" for f in (statistics.median, min, max))) for what, each in taken.items()],
    )
    first, second = (statistics.median(taken[what]) for what in (FIRST, SECOND))
    print(f"the second takes {second / first:.2f} of the first; to be reached: {BOUND}")
    return second <= BOUND * first


def _first(rover: Rover) -> Callable[[], object]:
    rover.done("remove", "--yes")
    return lambda: rover.done("push", "--skip-checks", "--offline")


def _second(rover: Rover) -> Callable[[], object]:
    app = rover.project / "onwards.py"
    app.write_text(f"{app.read_text()}# Changed.\n")
    return lambda: rover.done("push", "--skip-checks", "--offline")


def _by_hand(rover: Rover) -> Callable[[], object]:
    """Send what is there back to where it came from, into a folder that is empty."""
    home = rover.desk.folder / "by hand"
    for folder in ("current/project", "current/site"):
        shutil.copytree(rover.files / folder, home / folder, symlinks=True, dirs_exist_ok=True)
    shutil.copytree(_wheels(rover), home / "wheels", dirs_exist_ok=True)
    rover.desk.ssh("rm -rf by-hand")
    return lambda: rover.desk.rsync(home, "by-hand")


def _wheels(rover: Rover) -> Path:
    """Return the folder of the desk's in which the wheels of the release that runs are by now."""
    with Link(Host.parse(HOST), rover.desk.config) as link:
        target = Target.of(link.call("probe"))
    return wheels_for(Release.read(rover.files / "current").requirements, target, lambda _: None)


def _seconds(work: Callable[[], object]) -> float:
    start = perf_counter()
    work()
    return perf_counter() - start


FIRST, SECOND = "first deploy, no network there", "second deploy, one file changed"
WAYS = {FIRST: _first, "rsync of the same files by hand": _by_hand, SECOND: _second}

if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.told("deploy", main))
