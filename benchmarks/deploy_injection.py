"""Fifty hostile names, settings and host strings: none runs anything, at the client or on the robot.

    python -m benchmarks.deploy_injection

The robot is a Debian that systemd boots (tests/system/deploy); it needs root. Each string would make a file called
``pwned`` if any shell, ssh or rsync took it for more than it is. A host has to be refused before anything is started.
A setting has to arrive as it is, letter by letter; so do files with such names, and their contents. A release's name
has to be refused. Exit status 1 where a file was made anywhere, or something did not arrive.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.deploy import robot
from benchmarks.report import machine, print_table
from tests.system import needs
from tests.system.deploy.rover import Rover

CANARY = "pwned"
TOUCH = f"touch {CANARY}"
"""A command that makes a file, if a shell runs it."""

HOSTS = (
    f"-oProxyCommand={TOUCH}",
    f"-oLocalCommand={TOUCH}",
    f"-F/dev/stdin;{TOUCH}",
    f"$({TOUCH})",
    f"`{TOUCH}`",
    f"rover;{TOUCH}",
    f"rover|{TOUCH}",
    f"rover&{TOUCH}",
    f"rover\n{TOUCH}",
    f"rover {TOUCH}",
    f"pi@rover -oProxyCommand={TOUCH}",
    f"$({TOUCH})@rover",
    f"-l{TOUCH}@rover",
    f"pi@-oProxyCommand={TOUCH}",
    f"rover:22;{TOUCH}",
    f"rover:$({TOUCH})",
    f"[::1]:22;{TOUCH}",
    f"[$({TOUCH})]:22",
    f"ssh://rover/;{TOUCH}",
    f"rover'\"; {TOUCH}; \"'",
)

RELEASES = (
    f"$({TOUCH})",
    f"../../../tmp;{TOUCH}",
    "../../.ssh",
    f"-rf;{TOUCH}",
    f"2026-11-21T22-40-03Z;{TOUCH}",
)

NOTES = (
    f"$({TOUCH})",
    f"`{TOUCH}`",
    f"'; {TOUCH}; '",
    f'"; {TOUCH}; "',
    f"a\n{TOUCH}\nb",
    f"--record={CANARY}",
    f"%h %t $HOME ${{IFS}}{TOUCH}",
    f"\\'; {TOUCH} #",
    f"=; {TOUCH} && {TOUCH} || {TOUCH}",
    f"ü \u202e 🤖 \x1b]0;{CANARY}\x07 \x1e{{}}",
)

FILES = (
    f"$({TOUCH})",
    f"`{TOUCH}`.txt",
    f";{TOUCH};",
    f"'; {TOUCH}; '",
    f'"; {TOUCH}; "',
    f"a\n{TOUCH}\nb",
    "-e sh",
    "--rsh=sh",
    "-rf",
    "*",
    "~root",
    f"a folder/|{TOUCH}|",
    "host::module",
    "\\\\server",
    "ünï 🤖 \u202e.txt",
)

REFUSED = 2


def main() -> bool:
    """Print how each kind came out; return whether all is well."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    print(machine())
    rows, is_good = [], True
    with robot() as rover:
        for kind, try_all in KINDS.items():
            good = list(try_all(rover))
            ran = list(_canaries(rover))
            rows.append((kind, str(len(good)), f"{sum(good)}/{len(good)}", ", ".join(map(str, ran)) or "nothing"))
            is_good = is_good and all(good) and not ran
    print_table(("hostile", "tried", "refused, or arrived as it is", "ran"), rows)
    return is_good


def _hosts(rover: Rover) -> Iterator[bool]:
    for host in HOSTS:
        yield rover.client.run("deploy", "status", "--", host).returncode == REFUSED


def _releases(rover: Rover) -> Iterator[bool]:
    before = rover.release
    for name in RELEASES:
        yield rover.deploy("rollback", "--", name).returncode != 0 and rover.release == before


def _settings(rover: Rover) -> Iterator[bool]:
    for note in NOTES:
        rover.run("push", "--skip-checks", "--set", "speed_rad_s=2", "--set", f"note={note}")
        yield (rover.machine.home / "noted").read_text() == note


def _files(rover: Rover) -> Iterator[bool]:
    """All in one push, in a folder, for an app and a robot that are called so too."""
    with TemporaryDirectory(prefix=f"it's $(touch {CANARY}) ") as folder:
        project = Path(shutil.copytree(rover.project, Path(folder) / f"`touch {CANARY}`; ü"))
        for name in FILES:
            (project / name).parent.mkdir(parents=True, exist_ok=True)
            (project / name).write_text(name)
        app = shutil.copy(project / "drive_ahead.py", project / f"drive;touch {CANARY};ahead.py")
        odd = Rover(rover.machine, rover.client, project)
        ran = odd.push("--app", Path(app).name, "--set", "speed_rad_s=2")
        there = odd.files / "current" / "project"
        for name in FILES:
            yield ran.returncode == 0 and there.joinpath(name).read_text() == name


def _canaries(rover: Rover) -> Iterator[Path]:
    """Yield what was made by a string that ran."""
    for folder in (rover.machine.home, rover.client.folder, rover.project, Path.home(), Path.cwd()):
        yield from (path for path in folder.glob(f"**/{CANARY}*") if path.is_file())


KINDS: dict[str, Callable[[Rover], Iterator[bool]]] = {
    "host strings": _hosts,
    "releases' names": _releases,
    "settings": _settings,
    "names of files": _files,
}

if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy_injection", main))
