"""How the robotcore of a release is called: its own Python, its own modules, in the project's folder."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent.releases.release import ENVIRONMENT, PROJECT, SITE

ROBOTCORE = (
    "-c",
    (
        "import sys; sys.path[:] = [each for each in sys.path if each]; "
        "import runpy; runpy.run_module('robotcore', run_name='__main__', alter_sys=True)"
    ),
)
"""Arguments of Python's: ``-m robotcore`` that looks for no module in the working folder, so that no ``drivers`` of a
project's is taken for ours. Python has a variable for that from 3.11 on, too late."""


@dataclass(frozen=True)
class Launch:
    """A command of robotcore's, ready for a process."""

    command: tuple[str, ...]
    folder: Path
    environment: dict[str, str]


def robotcore(release: Path, *arguments: str) -> Launch:
    """Return how robotcore is called in a release's folder."""
    python = release / ENVIRONMENT / "bin" / "python"
    kept_apart = {"PYTHONPATH": str(release / SITE), "PYTHONNOUSERSITE": "1"}
    return Launch((str(python), *ROBOTCORE, *arguments), release / PROJECT, {**os.environ, **kept_apart})
