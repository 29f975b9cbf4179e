"""Run this checkout's wheel on an emulated arm64, with old and with new libraries and with MuJoCo.

python -m tests.system.arm64
"""

from __future__ import annotations

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.system import needs, wheels
from tests.system.arm64.target import Target, target
from tests.system.speed import scaled

LIMIT_S = 300.0
"""The time limit of a run on the reference machine, where it takes about 25 s."""

LIBRARIES = {
    "old": ("numpy==1.24.*", "opencv-python-headless==4.6.*", "gpiozero>=2.0.1"),
    "new": ("gpiozero>=2.0.1",),
    "physics": ("mujoco>=3.5",),
}
SIDE_BY_SIDE = 2
VERSIONS = (
    "import cv2, numpy, platform; print(f'NumPy {numpy.__version__}, OpenCV {cv2.__version__}, {platform.machine()}')"
)
SUCCESS = {"outcome": "success", "verified": True, "exit_status": 0}
ON_A_PI: dict[str, dict[str, Any]] = {
    "run green-search --backend kinematic": SUCCESS,
    "run green-search --backend virtualpi": SUCCESS,
    "doctor": {"errors": 0, "exit_status": 0},
}
"""Expected keys of the ``--json`` output of each command."""

PAINTED: dict[str, dict[str, Any]] = {
    "run avoid-obstacles --backend mujoco": {"outcome": "success", "exit_status": 0},
    "run green-search --backend mujoco": SUCCESS,
}
"""Without OpenGL the pictures are painted."""

EXPECTED = {"old": ON_A_PI, "new": ON_A_PI, "physics": PAINTED}


def main() -> bool:
    """Return whether every run had the expected output."""
    needs.debian()
    machine = target()
    with TemporaryDirectory() as folder:
        wheel = wheels.build(Path(folder))
        for site, libraries in LIBRARIES.items():
            machine.install(site, [str(wheel), *libraries])
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        runs = [pool.submit(_is_passed, machine, site, command) for site in LIBRARIES for command in EXPECTED[site]]
        try:
            return all(run.result() for run in runs)
        except BaseException:
            pool.shutdown(cancel_futures=True)  # otherwise queued runs would still start
            raise


def _is_passed(machine: Target, site: str, command: str) -> bool:
    """Run a command of robotcore, print the result, and return whether it is as expected."""
    name = f"robotcore {command}, with {_versions(machine, site)}"
    try:
        run = _run(machine.command(site, "-m", "robotcore", *command.split(), "--json"))
    except subprocess.TimeoutExpired:
        print(f"not ok  {name}: it did not end within {scaled(LIMIT_S):.0f} s", flush=True)
        return False
    answer: dict[str, Any] = json.loads(run.stdout or "{}")
    expected = EXPECTED[site][command]
    got = {key: answer.get(key) for key in expected}
    if got == expected:
        print(f"ok      {name}", flush=True)
        return True
    reason = answer.get("reason") or needs.last_line(run.stderr)
    print(f"not ok  {name}\n          got {got}, expected {expected}: {reason}", flush=True)
    return False


def _versions(machine: Target, site: str) -> str:
    run = _run(machine.command(site, "-c", VERSIONS))
    return run.stdout.strip() or needs.last_line(run.stderr)


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=scaled(LIMIT_S))


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("arm64", main))
