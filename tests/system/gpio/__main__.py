"""Run the checks of tests/system/guest on a kernel's GPIO chip and camera: python -m tests.system.gpio [NAME]."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

from tests.system import needs, wheels
from tests.system.gpio.kernel import kernel
from tests.system.gpio.machine import REPORT_PORT, run_in_guest
from tests.system.gpio.programs import build_program
from tests.system.gpio.report import Report
from tests.system.speed import scaled

LIMIT_S = 900.0
"""The time limit of all checks on the reference machine, where they take about two minutes."""

GUEST = needs.ROOT / "tests" / "system" / "guest"
SUPPORT = (
    "__init__",
    "__main__",
    "bench",
    "chip",
    "conftest",
    "models",
    "scaled_limits",
    "scaled_loopback",
    "reporting",
)
BY_NAME = ("loopback",)
"""The files of checks that run only by their name, because they take about seven minutes."""

CONSOLE = needs.ROOT / "build" / "gpio-console.log"


def main(names: list[str]) -> bool:
    """Run the files of checks with these names, and return whether every check passed.

    Without names, run all files but those in `BY_NAME`.
    """
    needs.debian()
    chosen = [_file(name) for name in names] or [file for file in _files() if file.stem not in BY_NAME]
    CONSOLE.parent.mkdir(exist_ok=True)
    report = Report()
    with run_in_guest(kernel(), _command(chosen), CONSOLE, scaled(LIMIT_S)) as lines:
        report.read(lines)
    if not report.is_passed:
        print(f"The guest's console: {CONSOLE}")
    return report.is_passed


def _files() -> list[Path]:
    return sorted(path for path in GUEST.glob("*.py") if path.stem not in SUPPORT)


def _file(name: str) -> Path:
    known = {path.stem: path for path in _files()}
    if name not in known:
        sys.exit(f"no file of checks is called {name!r}. There are: {', '.join(known)}")
    return known[name]


def _command(files: Iterable[Path]) -> list[str]:
    environment = [
        "PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin",
        f"PYTHONPATH={':'.join(map(str, _packages()))}",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD=1",
        "HOME=/run",
        "LG_WD=/tmp",
        f"ECHO_HELPER={build_program('echo')}",
        f"WIRES_HELPER={build_program('wires')}",
        f"CHECKS_PORT={REPORT_PORT}",
    ]
    checks = [sys.executable, "-m", "tests.system.guest", *map(str, files)]
    return ["/usr/bin/env", "-C", str(needs.ROOT), *environment, *checks]


def _packages() -> list[Path]:
    """Return the folders for Python's path: this checkout, and lgpio if it is not installed."""
    if find_spec("lgpio"):
        return [needs.ROOT]
    site = needs.cache() / f"site-{sys.version_info.major}.{sys.version_info.minor}"
    if not site.is_dir():
        wheels.install(site, ["lgpio>=0.2.2"])
    return [needs.ROOT, site]


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("gpio", lambda: main(sys.argv[1:])))
