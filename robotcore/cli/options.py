"""The options that several commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore import text
from robotcore.errors import UnknownNameError, UsageError

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.backend import Backend


class FolderType(click.Path):
    """A click type for the path of a folder. It refuses an empty path, such as that of an unset shell variable."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, file_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not str(value):
            self.fail("the folder's name is empty. Name a folder, or leave the option out", param, ctx)
        return super().convert(value, param, ctx)


def parse_pair(value: str) -> tuple[str, str]:
    """Split ``KEY=VALUE`` at the first ``=``.

    >>> parse_pair("path=/a=b")
    ('path', '/a=b')
    """
    key, _, content = (part.strip() for part in value.partition("="))
    if not key or "=" not in value:
        raise click.BadParameter(f"{value!r} is not KEY=VALUE")
    return key, content


def parse_count(value: str) -> int:
    """Parse a whole number that is at least 1."""
    if not value.strip().isdecimal() or not int(value):
        raise click.BadParameter(f"{value!r} is not a whole number greater than 0. Give a number such as 4")
    return int(value)


def parse_seconds(value: str) -> float:
    """Parse a finite positive number of seconds."""
    try:
        seconds = float(value)
    except ValueError:
        seconds = 0.0
    if not 0 < seconds < inf:
        raise click.BadParameter(f"{value!r} is not a positive number of seconds. Give a number such as 90")
    return seconds


def parse_size(value: str) -> int:
    """Parse a size in bytes that is at least 1.

    >>> parse_size("500MB"), parse_size("1.5 GiB"), parse_size("4096")
    (500000000, 1610612736, 4096)
    """
    from pydantic import ByteSize, TypeAdapter, ValidationError

    try:
        found = TypeAdapter(ByteSize).validate_python(value.strip())
    except ValidationError:
        found = ByteSize(0)
    if found < 1:
        raise click.BadParameter(f"{value!r} is not a size in bytes. Give a size such as 500MB or 2GB")
    return int(found)


def parse_duration(value: str) -> float:
    """Parse a positive duration with its unit, and return it in seconds."""
    try:
        return text.parse_duration(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def parse_names(value: str) -> tuple[str, ...]:
    """Return the names in a text, which are separated by commas, without repetitions.

    >>> parse_names("open, arena,open")
    ('open', 'arena')
    """
    found = tuple(dict.fromkeys(name for part in value.split(",") if (name := part.strip())))
    if not found:
        raise click.BadParameter("the list of names is empty. Give one or more names, separated by commas")
    return found


def parse_faults(_context: click.Context, _parameter: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    """Return the canonical form of the values of ``--fault``. The faults in a file replace the file's name."""
    if not values:
        return ()
    from robotcore.runtime.faults.spec import read_specs

    try:
        return read_specs(values)
    except UsageError as error:
        raise click.BadParameter(str(error)) from error


Command = Callable[..., Any]

backend_option = click.option(
    "--option",
    "options",
    metavar="KEY=VALUE",
    type=parse_pair,
    multiple=True,
    help="Set an option of the backend, such as port=/dev/ttyUSB0.",
)
host_option = click.option(
    "--host", help="The host name or address of the simulator or robot: short for --option host=…"
)
port_option = click.option(
    "--port", help="The network or serial port of the simulator or robot: short for --option port=…"
)

_OPTIONS = (
    click.option(
        "--robot",
        default="rover",
        show_default=True,
        help="A robot's name, or its .toml file. List: `robotcore robots`.",
    ),
    click.option(
        "--rate",
        "rate_hz",
        metavar="HZ",
        type=float,
        default=20.0,
        show_default=True,
        help="Ticks per second. The app decides once per tick.",
    ),
    click.option(
        "--timeout",
        "timeout_s",
        metavar="SECONDS",
        type=float,
        default=120.0,
        show_default=True,
        help="End a run after this time on the robot's clock.",
    ),
    click.option(
        "--randomise", "--randomize", is_flag=True, help="Also vary colours, light, sensors and wheels with the seed."
    ),
    click.option(
        "--ideal",
        is_flag=True,
        help="Simulate devices without the latency, noise, distortion, lag, dead band and gains of the robot's file.",
    ),
    click.option(
        "--judge",
        metavar="APP",
        help="The name or file of an app. Its method verify, not that of APP, decides whether the run was a success.",
    ),
    click.option(
        "--fault",
        "faults",
        metavar="SPEC",
        multiple=True,
        callback=parse_faults,
        help='Inject a fault, such as "camera drop=0.2 after=5", or those in a .toml file. List: `robotcore faults`.',
    ),
    click.option(
        "--set",
        "settings",
        metavar="KEY=VALUE",
        type=parse_pair,
        multiple=True,
        help="Change a setting of the app, such as speed_m_s=0.2. List: `robotcore apps`.",
    ),
    backend_option,
)


def run_options(command: Command) -> Command:
    """Add the options of a run to a command. Each option has the name of a field of `RunRequest`."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def merge_options(options: Iterable[tuple[str, str]], **short: str | None) -> dict[str, str]:
    """Return the options of a backend by name. A given value of ``--host`` or ``--port`` replaces that of a pair."""
    return {**dict(options), **{key: value for key, value in short.items() if value is not None}}


def refuse_without(missing: str, remedy: str, **given: bool) -> None:
    """Raise UsageError for the first given option, because it has no effect without something else.

    missing: the noun for that, such as ``--backend``.
    remedy: an instruction for the user, as a sentence without its full stop.
    given: whether each option is given, by its name with ``_`` in place of ``-``.
    """
    _refuse_options(f"without {missing}. {remedy}", given)


def refuse_beside(other: str, **given: bool) -> None:
    """Raise UsageError for the first given option, because it has no effect with another option.

    other: the other option.
    given: as for `refuse_without`.
    """
    _refuse_options(f"with {other}. Leave it out", given)


def _refuse_options(condition: str, given: Mapping[str, bool]) -> None:
    for name in (name for name, is_given in given.items() if is_given):
        option = f"--{name.replace('_', '-')}"
        text = f"{option} has no effect {condition}"
        raise UsageError(text, kind="option-without-effect", option=option)


def load_connected_robot(backend: Backend, robot: str, options: Mapping[str, str]) -> RobotDescription:
    """Load a robot with the options of the connection to it, such as a serial port.

    Raises UnknownNameError if an option is not one of the backend's `connection_options`.
    """
    for unknown in sorted(options.keys() - backend.connection_options):
        raise UnknownNameError("option", unknown, sorted(backend.connection_options))
    return backend.load_robot(robot, options)
