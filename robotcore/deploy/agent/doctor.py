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
"""The first start of a release compiles it; an SD card is slow."""

FindingRow = dict[str, Any]
"""A finding, as ``robotcore doctor --json`` tells of it: about, level, what, said, remedy."""


_PROC = Path("/proc")
_SERVICE_GROUP = f"/{SERVICE}"
"""In the control group of every process of the release that runs. Source: cgroups(7)."""


def run_doctor(folder: Path, release: Release) -> list[FindingRow]:
    """Return what the doctor of a release finds on this robot; where it does not run, that is the finding.

    Pins that the running release holds are no fault: it lets go of them before the new one starts.
    """
    try:
        ran = _run_doctor(folder, f"--robot={release.robot}", f"--backend={release.backend}")
        return [_excuse_running_release(row) for row in json.loads(ran.stdout)["findings"]]
    except subprocess.TimeoutExpired:
        return [_build_failure(f"has not ended within {DOCTOR_TIMEOUT_S} s")]
    except (ValueError, KeyError, TypeError):
        last = [line for line in ran.stderr.splitlines() if line.strip()][-1:]
        return [_build_failure(f"does not run: {last[0] if last else f'it ended with {ran.returncode}'}")]


def _run_doctor(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Let the doctor look; what the library for pins leaves in its working folder goes elsewhere (``LG_WD``)."""
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
    return {**row, "level": "ok", "said": f"{row['said']}: the release that runs, which lets go of it", "remedy": ""}


def _is_in_service(pid: str) -> bool:
    try:
        return _PROC.joinpath(pid, "cgroup").read_text().rstrip("\n").endswith(_SERVICE_GROUP)
    except OSError:
        return False


def _build_failure(said: str) -> FindingRow:
    remedy = "Run it at the desk; then push again"
    return {"about": "machine", "level": "error", "what": "doctor", "said": said, "remedy": remedy}
