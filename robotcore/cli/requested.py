"""The options that a run and a sweep share: what is asked for, whatever it is tried on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from robotcore.cli.values import faults, pair

Command = Callable[..., Any]

_OPTIONS = (
    click.option("--robot", default="rover", show_default=True, help="A robot's name, or its .toml file."),
    click.option(
        "--rate", "rate_hz", metavar="HZ", type=float, default=20.0, show_default=True, help="Ticks a second."
    ),
    click.option(
        "--timeout",
        "timeout_s",
        metavar="SECONDS",
        type=float,
        default=120.0,
        show_default=True,
        help="Give up a run after this time on the robot's clock.",
    ),
    click.option(
        "--randomise", "--randomize", is_flag=True, help="Draw looks, light, sensors and wheels from the seed too."
    ),
    click.option(
        "--judge",
        metavar="APP",
        help="Let this app's verify judge the end of a run, instead of APP's own: a name, or a file.",
    ),
    click.option(
        "--fault",
        "faults",
        metavar="SPEC",
        multiple=True,
        callback=faults,
        help='Let something fail: "camera drop=0.2 after=5", or a .toml file; see `robotcore faults`.',
    ),
    click.option("--set", "settings", metavar="KEY=VALUE", type=pair, multiple=True, help="A setting of the app."),
    click.option(
        "--option", "options", metavar="KEY=VALUE", type=pair, multiple=True, help="An option of the backend."
    ),
)


def requested(command: Command) -> Command:
    """Give a command these options, named as the fields of a `RunRequest`."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command
