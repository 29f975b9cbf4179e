"""Whether the board knows what time it is: it has no battery for its clock, but for a Pi 5 that was given one."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

from robotcore.hal.finding import Finding

WHAT = "clock"
SYNCHRONISED = "run/systemd/timesync/synchronized"
"""Made by systemd-timesyncd with the first answer of a time server. Source: systemd-timesyncd.service(8)."""

TIMEDATECTL = "usr/bin/timedatectl"
ANSWER_S = 5.0


def clock(root: Path, ask: Callable[[Path], str] | None = None) -> Iterator[Finding]:
    """Look whether a time server was heard since the start; runs do not need it, the dates of recordings do.

    ``ask`` returns what ``timedatectl`` prints of NTPSynchronized: another program than systemd's may keep the time.
    """
    if (root / SYNCHRONISED).exists() or (ask or _asked)(root / TIMEDATECTL).strip() == "yes":
        yield Finding.ok(WHAT, "set by a time server")
    else:
        said = "no time server was heard since the start: the dates of recordings are wrong"
        yield Finding.warning(WHAT, said, "Connect the board to a network once; sudo timedatectl set-ntp true")


def _asked(program: Path) -> str:
    command = [str(program), "show", "--property=NTPSynchronized", "--value"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=ANSWER_S, check=False)  # noqa: S603
    if done.returncode:
        raise OSError(f"timedatectl says: {done.stderr.strip()}")
    return done.stdout
