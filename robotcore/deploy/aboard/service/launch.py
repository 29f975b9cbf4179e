"""How the robotcore of a release is called: its own Python, its own modules, in the project's folder."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.aboard.releases.release import ENVIRONMENT, PROJECT, SITE


@dataclass(frozen=True)
class Launch:
    """A command of robotcore's, ready for a process."""

    command: tuple[str, ...]
    folder: Path
    environment: dict[str, str]


def robotcore(release: Path, *arguments: str) -> Launch:
    """Return how robotcore is called in a release's folder; no ``drivers`` of the project's is taken for ours."""
    python = release / ENVIRONMENT / "bin" / "python"
    kept_apart = {"PYTHONPATH": str(release / SITE), "PYTHONNOUSERSITE": "1", "PYTHONSAFEPATH": "1"}
    return Launch((str(python), "-m", "robotcore", *arguments), release / PROJECT, {**os.environ, **kept_apart})
