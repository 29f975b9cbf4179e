"""Whether the supply is strong enough, and the chip cool enough."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

from robotcore.hal.finding import Finding

WHAT = "power"
VCGENCMD = "usr/bin/vcgencmd"
ANSWER_S = 5.0
LOW, CAPPED, THROTTLED, WARM = 0, 1, 2, 3
BITS = {
    LOW: "the voltage is low",
    CAPPED: "the clock is capped",
    THROTTLED: "the chip is throttled",
    WARM: "the chip is at its soft temperature limit",
}
"""Of the answer, now; 16 bits further up: at some time since it was started.
Source: https://www.raspberrypi.com/documentation/computers/os.html#get_throttled."""

SINCE = 16
STRONGER = "Take a stronger supply and a short, thick cable, and give the motors a battery of their own"
COOLER = "Let air to the chip, or put a cooler on it"


def power(root: Path, ask: Callable[[Path], str] | None = None) -> Iterator[Finding]:
    """Look whether the board has, or has had since it was started, too low a voltage or too hot a chip.

    ``ask`` returns what ``vcgencmd get_throttled`` prints, such as ``throttled=0x50005``.
    """
    word = int((ask or _asked)(root / VCGENCMD).strip().rpartition("=")[2], 16)
    now, before = _bits(word), _bits(word >> SINCE)
    if not now | before:
        yield Finding.ok(WHAT, "the voltage and the temperature are right, and have been since the start")
    if now:
        yield _finding(Finding.error if LOW in now else Finding.warning, f"{_words(now)} now", now)
    if past := before - now:
        yield _finding(Finding.warning, f"at some time since the start: {_words(past)}", past)


def _bits(word: int) -> set[int]:
    return {bit for bit in BITS if word >> bit & 1}


def _words(bits: set[int]) -> str:
    return ", ".join(BITS[bit] for bit in sorted(bits))


def _finding(make: Callable[[str, str, str], Finding], said: str, bits: set[int]) -> Finding:
    return make(WHAT, said, STRONGER if LOW in bits else COOLER)


def _asked(program: Path) -> str:
    """Return the firmware's answer; it tells members of the group video only."""
    command = [str(program), "get_throttled"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=ANSWER_S, check=False)  # noqa: S603
    if done.returncode:
        raise OSError(f"vcgencmd says: {(done.stderr or done.stdout).strip()}")
    return done.stdout
