"""Try hostile names, settings and host strings in deploys. None may run a command, at the client or on the robot.

    python -m benchmarks.deploy_injection

The robot is a Debian that systemd boots (tests/system/deploy), which needs root. Each string would make a file called
``pwned`` if a shell, ssh or rsync interpreted it. A hostile host has to be refused before anything is started, and a
hostile release name has to be refused. A setting has to arrive unchanged, and so do files with hostile names. The exit
status is 1 if a ``pwned`` file was made, or if something arrived changed.
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
"""A shell command. If the file that it creates exists, a shell has executed it."""

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
    """Print the results of each kind of string. Return whether all strings were harmless."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    print(machine())
    rows, is_good = [], True
    with robot() as rover:
        for kind, try_all in KINDS.items():
            good = list(try_all(rover))
            ran = list(_find_canaries(rover))
            rows.append((kind, str(len(good)), f"{sum(good)}/{len(good)}", ", ".join(map(str, ran)) or "nothing"))
            is_good = is_good and all(good) and not ran
    print_table(("hostile", "tried", "refused, or arrived as it is", "ran"), rows)
    return is_good


def _try_hosts(rover: Rover) -> Iterator[bool]:
    for host in HOSTS:
        yield rover.client.run("deploy", "status", "--", host).returncode == REFUSED


def _try_releases(rover: Rover) -> Iterator[bool]:
    before = rover.release
    for name in RELEASES:
        yield rover.deploy("rollback", "--", name).returncode != 0 and rover.release == before


def _try_settings(rover: Rover) -> Iterator[bool]:
    for note in NOTES:
        rover.run("push", "--skip-checks", "--set", "speed_rad_s=2", "--set", f"note={note}")
        yield (rover.machine.home / "noted").read_text() == note


def _try_files(rover: Rover) -> Iterator[bool]:
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


def _find_canaries(rover: Rover) -> Iterator[Path]:
    """Yield the files that executed strings have created, at the client and on the robot."""
    for folder in (rover.machine.home, rover.client.folder, rover.project, Path.home(), Path.cwd()):
        yield from (path for path in folder.glob(f"**/{CANARY}*") if path.is_file())


KINDS: dict[str, Callable[[Rover], Iterator[bool]]] = {
    "host strings": _try_hosts,
    "releases' names": _try_releases,
    "settings": _try_settings,
    "names of files": _try_files,
}

if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy_injection", main))
