"""``robotcore demo``: the main job, in the best simulator that works here."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.hal.backend import Backend

FIRST = "pybullet"
"""Its camera needs no OpenGL: where it is installed it works."""


@click.command("demo")
@click.option("--seed", type=int, default=7, show_default=True, help="Draw the world anew from this number.")
@click.option("--gui", is_flag=True, help="Open the simulator's window.")
@click.option("--picture", type=click.Path(path_type=Path), default=Path("demo.png"), show_default=True)
def command(seed: int, picture: Path, *, gui: bool) -> int:
    """Watch the rover find the green ball.

    Takes the best simulator that works here, says why, and draws a picture of how it went.
    """
    from robotcore.cli.main import execute

    backend, why = chosen_backend()
    arguments = ["run", "green-search", "--backend", backend, "--seed", str(seed), "--picture", str(picture)]
    arguments += ["--gui"] if gui else []
    write_line(why)
    write_line(f"$ robotcore {' '.join(arguments)}")
    return execute(arguments)


def chosen_backend() -> tuple[str, str]:
    """Return the first physics simulator that works here, else the built-in backend; and why."""
    from robotcore.hal.backend import loadable_backends

    physical = [backend for backend in loadable_backends() if backend.brings_physics]
    faults: list[str] = []
    for backend in sorted(physical, key=lambda backend: backend.name != FIRST):
        if not (fault := _fault_of(backend)):
            return backend.name, " ".join((*faults, f"{backend.name} ({backend.summary}): the demo runs on it."))
        faults.append(fault)
    return "kinematic", " ".join((*faults, "The demo runs on the built-in kinematic simulator."))


def _fault_of(backend: Backend) -> str:
    """Return why a simulator cannot be taken, and what to do; nothing where a robot opens, moves and sees in it."""
    if not backend.is_installed:
        return f"{backend.name} is not installed. {backend.remedy}."
    from robotcore.cli.doctor.smoke_test import diagnose
    from robotcore.hal.finding import Level

    broken = (finding for finding in diagnose(backend) if finding.level is Level.ERROR)
    return next((f"{backend.name}: {finding.said}." for finding in broken), "")
