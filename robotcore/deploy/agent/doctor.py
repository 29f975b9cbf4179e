"""Run robotcore's doctor of a release that is not active yet."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robotcore.deploy.agent.releases import Release
from robotcore.deploy.agent.service import build_launch
from robotcore.deploy.agent.units import SERVICE

DOCTOR_TIMEOUT_S = 180
"""How long the doctor may run, in s: the first start of a release compiles it, and an SD card is slow."""

FindingRow = dict[str, Any]
"""A finding of ``robotcore doctor --json``: about, level, what, said, remedy."""

_PROC = Path("/proc")
_SERVICE_GROUP = f"/{SERVICE}"
"""The end of the control group of each process of the running release. Source: cgroups(7)."""


def run_doctor(folder: Path, release: Release) -> list[FindingRow]:
    """Run the doctor of a release on this robot; return its findings, or one finding that it does not run.

    A pin that the running release holds is not an error, because that release stops before the new one starts.
    """
    try:
        done = _run_doctor(folder, f"--robot={release.robot}", f"--backend={release.backend}")
        return [_excuse_running_release(row) for row in json.loads(done.stdout)["findings"]]
    except subprocess.TimeoutExpired:
        return [_build_failure(f"has not ended within {DOCTOR_TIMEOUT_S} s")]
    except (ValueError, KeyError, TypeError):
        last = [line for line in done.stderr.splitlines() if line.strip()][-1:]
        return [_build_failure(f"does not run: {last[0] if last else f'it ended with {done.returncode}'}")]


def _run_doctor(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the doctor. The pin library's working folder (``LG_WD``) is a temporary one."""
    called = build_launch(folder, "doctor", "--json", *arguments)
    with TemporaryDirectory() as scratch:
        return subprocess.run(  # noqa: S603  no shell
            called.command,
            cwd=called.folder,
            env={**called.environment, "LG_WD": scratch},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=DOCTOR_TIMEOUT_S,
            check=False,
        )


def _excuse_running_release(row: FindingRow) -> FindingRow:
    holders = re.findall(r"process (\d+)", row["said"])
    if row["level"] != "error" or not holders or not all(map(_is_in_service, holders)):
        return row
    return {**row, "level": "ok", "said": f"{row['said']}: the running release, which stops first", "remedy": ""}


def _is_in_service(pid: str) -> bool:
    try:
        return _PROC.joinpath(pid, "cgroup").read_text().rstrip("\n").endswith(_SERVICE_GROUP)
    except OSError:
        return False


def _build_failure(said: str) -> FindingRow:
    remedy = "Run it at the desk; then push again"
    return {"about": "machine", "level": "error", "what": "doctor", "said": said, "remedy": remedy}
