"""``robotcore demo``: the main job, in the best simulator that is there."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("demo")
@click.option("--seed", type=int, default=7, show_default=True, help="Draw the world anew from this number.")
@click.option("--gui", is_flag=True, help="Open the simulator's window.")
@click.option("--picture", type=click.Path(path_type=Path), default=Path("demo.png"), show_default=True)
def command(seed: int, picture: Path, *, gui: bool) -> int:
    """Watch the rover find the green ball.

    Takes the best simulator that is installed, says why, and draws a picture of how it went.
    """
    from robotcore.cli.main import execute

    backend, why = chosen_backend()
    arguments = ["run", "green-search", "--backend", backend, "--seed", str(seed), "--picture", str(picture)]
    arguments += ["--gui"] if gui else []
    click.echo(f"{why}\n$ robotcore {' '.join(arguments)}")
    return execute(arguments)


def chosen_backend() -> tuple[str, str]:
    """Return the first physics simulator that is installed, else the built-in backend; and why."""
    from robotcore.catalogue import loadable_backends

    physical = [backend for backend in loadable_backends() if backend.brings_physics]
    for backend in physical:
        if backend.is_installed:
            return (
                backend.name,
                f"{backend.name} ({backend.summary}) is installed for this Python: the demo runs on it.",
            )
    missing = " ".join(f"{backend.name} is not installed. {backend.remedy}." for backend in physical)
    return "kinematic", f"{missing} The demo runs on the built-in kinematic simulator."
