"""Options that several commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.errors import UnknownNameError, UsageError

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.backend import Backend


class Folder(click.Path):
    """A folder by its name; an empty one, such as a variable of the shell's that nobody has set, is none."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, file_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not str(value):
            self.fail("the name is empty. Name a folder, or leave the option out", param, ctx)
        return super().convert(value, param, ctx)


def pair(value: str) -> tuple[str, str]:
    """Return ``KEY=VALUE`` as a tuple of the two; only the first ``=`` parts them."""
    key, _, what = (part.strip() for part in value.partition("="))
    if not key or "=" not in value:
        raise click.BadParameter(f"{value!r} is not KEY=VALUE")
    return key, what


def count(value: str) -> int:
    """Return a whole number from 1 on."""
    if not value.strip().isdecimal() or not int(value):
        raise click.BadParameter(f"{value!r} is no count; take a whole number from 1 on")
    return int(value)


def size(value: str) -> int:
    """Return a size in bytes, from 1 on: ``500MB``, ``1.5 GiB``, ``4096``."""
    from pydantic import ByteSize, TypeAdapter, ValidationError

    try:
        found = TypeAdapter(ByteSize).validate_python(value.strip())
    except ValidationError:
        found = ByteSize(0)
    if found < 1:
        raise click.BadParameter(f"{value!r} is no size; take one such as 500MB or 2GB")
    return int(found)


def names(value: str) -> tuple[str, ...]:
    """Return the names between commas, in order, each once."""
    found = tuple(dict.fromkeys(name for part in value.split(",") if (name := part.strip())))
    if not found:
        raise click.BadParameter("name one or more, separated by commas")
    return found


def faults(_context: click.Context, _parameter: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    """Return specs of faults in their canonical form, those of a file in its place."""
    if not values:
        return ()
    from robotcore.runtime.faults.spec import read_specs

    try:
        return read_specs(values)
    except UsageError as error:
        raise click.BadParameter(str(error)) from error


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


def run_options(command: Command) -> Command:
    """Give a command these options, named as the fields of a `RunRequest`."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def connection_options(command: Command) -> Command:
    """Give a command ``--port`` and ``--option``; `merge_options` puts together what it takes for them."""
    option = click.option("--option", "options", metavar="KEY=VALUE", type=pair, multiple=True, help="Of the backend.")
    return click.option("--port", help="Short for --option port=…: where the robot is plugged in.")(option(command))


def merge_options(port: str | None, options: tuple[tuple[str, str], ...]) -> dict[str, str]:
    """Return the options of a backend."""
    return {**dict(options), **({} if port is None else {"port": port})}


def load_connected_robot(backend: Backend, robot: str, options: Mapping[str, str]) -> RobotDescription:
    """Return a robot as it is plugged in; raises UsageError where an option says nothing of that."""
    for unknown in sorted(options.keys() - backend.connection_options):
        raise UnknownNameError("option", unknown, sorted(backend.connection_options))
    return backend.load_robot(robot, options)
