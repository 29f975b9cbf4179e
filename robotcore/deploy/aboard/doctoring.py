"""robotcore's doctor, of a release that has not run yet."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

from robotcore.deploy.aboard.release import ENVIRONMENT, PROJECT, SITE, Release

PATIENCE_S = 180
"""The first start of a release compiles it; an SD card is slow."""

Row = dict[str, Any]
"""A finding, as ``robotcore doctor --json`` tells of it: about, level, what, said, remedy."""


def findings_of(folder: Path, release: Release) -> list[Row]:
    """Return what the doctor of a release finds on this robot; where it does not run, that is the finding."""
    command = [str(folder / ENVIRONMENT / "bin/python"), "-m", "robotcore", "doctor", "--json"]
    told = {"PYTHONPATH": str(folder / SITE), "PYTHONNOUSERSITE": "1"}
    try:
        ran = subprocess.run(  # noqa: S603  our own command
            [*command, f"--robot={release.robot}", f"--backend={release.backend}"],
            cwd=folder / PROJECT,
            env={**os.environ, **told},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return [_failed(f"has not ended within {PATIENCE_S} s")]
    try:
        return list(json.loads(ran.stdout)["findings"])
    except (ValueError, KeyError, TypeError):
        last = [line for line in ran.stderr.splitlines() if line.strip()][-1:]
        return [_failed(f"does not run: {last[0] if last else f'it ended with {ran.returncode}'}")]


def _failed(said: str) -> Row:
    remedy = "Run it at the desk; then push again"
    return {"about": "machine", "level": "error", "what": "doctor", "said": said, "remedy": remedy}
