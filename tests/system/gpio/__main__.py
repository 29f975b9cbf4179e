"""Run the checks of tests/system/guest on a kernel's GPIO chip and camera: python -m tests.system.gpio [NAME]."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path

from tests.system import needs, wheels
from tests.system.gpio.echo import build_echo
from tests.system.gpio.kernel import kernel
from tests.system.gpio.machine import TOLD, running

LIMIT_S = 420.0
CHECK_LIMIT_S = 90
GUEST = needs.ROOT / "tests" / "system" / "guest"
SUPPORT = ("__init__", "bench", "chip", "conftest", "sonar", "telling", "waiting", "wheel")


def main(names: list[str]) -> bool:
    """Run these files of checks, by default all; return whether every check was passed."""
    needs.debian()
    chosen = [_file(name) for name in names] or _files()
    console = needs.cache() / "gpio-console.log"
    with running(kernel(), _command(chosen), console, LIMIT_S) as lines:
        return _report(_heard(lines), console)


def _files() -> list[Path]:
    return sorted(path for path in GUEST.glob("*.py") if path.stem not in SUPPORT)


def _file(name: str) -> Path:
    known = {path.stem: path for path in _files()}
    if name not in known:
        sys.exit(f"no checks are called {name!r}; there are {', '.join(known)}")
    return known[name]


def _command(files: Iterable[Path]) -> list[str]:
    """Return what the guest runs: pytest, with the files of checks by name."""
    search = [str(needs.ROOT)]
    if not find_spec("lgpio"):
        site = needs.cache() / f"site-{sys.version_info.major}.{sys.version_info.minor}"
        wheels.install(site, ["lgpio>=0.2.2"])
        search.append(str(site))
    environment = [
        "PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin",
        f"PYTHONPATH={':'.join(search)}",
        "PYTHONDONTWRITEBYTECODE=1",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD=1",
        "HOME=/run",
        "LG_WD=/tmp",
        f"ECHO_HELPER={build_echo()}",
        f"CHECKS_TOLD={TOLD}",
    ]
    plugins = ["-p", "pytest_timeout", "-p", "tests.system.guest.telling", "-p", "no:cacheprovider"]
    pytest = [sys.executable, "-m", "pytest", *plugins, f"--timeout={CHECK_LIMIT_S}", "--color=no"]
    return ["/usr/bin/env", "-C", str(needs.ROOT), *environment, *pytest, *map(str, files)]


def _heard(lines: Iterable[str]) -> Iterator[dict[str, str]]:
    for line in lines:
        if line.startswith("{"):
            yield json.loads(line)


def _report(events: Iterable[dict[str, str]], console: Path) -> bool:
    """Print a line a check, as it comes; return whether all of them were run, and passed."""
    running, failed, is_whole = "the start of the guest", 0, False
    for event in events:
        match event:
            case {"begun": check}:
                running = check
            case {"passed": check}:
                print(f"ok      {check}", flush=True)
            case {"skipped": check, "why": why}:
                print(f"not run {check}: {why}", flush=True)
            case {"failed": check, "why": why}:
                failed += 1
                print(f"not ok  {check}\n{_indented(why)}", flush=True)
            case {"ended": _}:
                is_whole = True
    if not is_whole:
        print(
            f"not ok  {running}: it did not end within the {LIMIT_S:.0f} s that the guest has, or took the guest down"
        )
    if failed or not is_whole:
        print(f"The guest's console: {console}")
    return is_whole and not failed


def _indented(text: str) -> str:
    return "\n".join(f"          {line}" for line in text.splitlines())


if __name__ == "__main__":
    sys.exit(needs.told("gpio", lambda: main(sys.argv[1:])))
