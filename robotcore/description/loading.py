"""Descriptions from files: shipped ones by name, a user's own by path; every fault in a line."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from stat import S_ISDIR, S_ISREG
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from robotcore.description.generation.clearance import require_room
from robotcore.description.robot import RobotDescription
from robotcore.description.types import StrictModel, frozen
from robotcore.description.validation import (
    BACKENDS,
    MAX_LIBRARY_MESSAGE,
    MAX_SHOWN_CHARACTERS,
    Mistake,
    dotted_key,
    find_mistakes,
)
from robotcore.description.world import WorldDescription
from robotcore.errors import DescriptionError, UnknownNameError, UsageError
from robotcore.plugins import backend_names

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    if sys.version_info >= (3, 11):
        from importlib.resources.abc import Traversable
    else:
        from importlib.abc import Traversable

ModelT = TypeVar("ModelT", bound=StrictModel)
Table = dict[str, Any]

MAX_FILE_BYTES = 2**20
"""The most bytes of a file. A robot of a thousand devices needs a third; TOML of this size is parsed in two seconds."""

MOST_ENTRIES = 1000
"""The most entries of a list or a table in a file, such as devices, obstacles or faults."""

MOST_DOTS = 32
"""The most dots of a key in a file. The time and the memory that TOML takes grow with the square of their number."""

MOST_BITS = 64
"""The most bits of a whole number in a file, as TOML defines it."""

_STRING = re.compile(
    r"""\"{3}(?:[^"\\]|\\.|"(?!""))*(?:\"{3})?|'{3}(?:[^']|'(?!''))*(?:'{3})?
    |"(?:[^"\\\n]|\\.)*"?|'[^'\n]*'?|\#[^\n]*""",
    re.VERBOSE | re.DOTALL,
)
"""A string or a comment of TOML; one without its end too, so that a search takes no longer."""

_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{MOST_DOTS + 1}}}")

KINDS: dict[str, type[StrictModel]] = {"robot": RobotDescription, "world": WorldDescription}
"""What a file can describe. Those that are shipped are in a folder named after it: robots, worlds."""


def robot_names() -> list[str]:
    """Return the names of the robots that are shipped."""
    return _shipped_names("robot")


def world_names() -> list[str]:
    """Return the names of the worlds that are shipped."""
    return _shipped_names("world")


def is_own(name_or_file: str) -> bool:
    """Return whether a robot or a world is named by its file, as a user's own is."""
    return name_or_file.endswith(".toml") or Path(name_or_file).name != name_or_file


def load_robot(name_or_file: str) -> RobotDescription:
    """Return a shipped robot by name, or a user's own from a ``.toml`` file."""
    return _robot(*_read(name_or_file, "robot"), _own(name_or_file))


def load_world(name_or_file: str) -> WorldDescription:
    """Return a shipped world by name, or a user's own from a ``.toml`` file."""
    return _world(*_read(name_or_file, "world"))


def read_table(file: str) -> Table:
    """Return what is in a TOML file of the user's, its lists as tuples; an error names what cannot be read."""
    return _parsed(file, _content(Path(file)))


def load_any(name_or_file: str) -> RobotDescription | WorldDescription:
    """Return the robot or the world that a file describes; a shipped one by its name too."""
    file, table = _read(name_or_file, *KINDS)
    kind = _kind_of(table)
    if kind is None:
        fault = "it describes neither a robot nor a world"
        raise DescriptionError(file, "", fault, "A robot has a [body], a world has a [floor]")
    return _robot(file, table, _own(name_or_file)) if kind == "robot" else _world(file, table)


def _robot(file: str, table: Table, own: str | None) -> RobotDescription:
    _require_kind("robot", file, table)
    if BACKENDS in table:
        raise DescriptionError(
            file, BACKENDS, "a backend's section stands at the top", "Write [NAME], not [backends.NAME]"
        )
    sections = backend_names()
    present = {name: table[name] for name in sections if name in table}
    rest = {key: value for key, value in table.items() if key not in present}
    return _validated(RobotDescription, file, {**rest, BACKENDS: present}, sections, own)


def _world(file: str, table: Table) -> WorldDescription:
    _require_kind("world", file, table)
    world = _validated(WorldDescription, file, table)
    require_room(world, file)
    return world


def _validated(
    model: type[ModelT], file: str, table: Table, sections: Sequence[str] = (), own: str | None = None
) -> ModelT:
    try:
        return model.model_validate(table, strict=True, context={"file": own})
    except ValidationError as error:
        raise DescriptionError.of_all(file, find_mistakes(error, model, table, sections)) from error


def _require_kind(kind: str, file: str, table: Table) -> None:
    if (other := _kind_of(table)) not in (None, kind):
        raise DescriptionError(file, "", f"it describes a {other}, not a {kind}", f"Name it as the {other}")


def _kind_of(table: Table) -> str | None:
    """Return what a table describes, by the keys that only one kind has; None where they do not tell."""
    robot, world = (set(model.model_fields) for model in KINDS.values())
    robots, worlds = len(table.keys() & (robot - world)), len(table.keys() & (world - robot))
    if robots == worlds:
        return None
    return "robot" if robots > worlds else "world"


def _shipped(kind: str) -> Traversable:
    return resources.files("robotcore.description").joinpath(f"{kind}s")


def _shipped_names(kind: str) -> list[str]:
    names = (file.name for file in _shipped(kind).iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def _read(name_or_file: str, *kinds: str) -> tuple[str, Table]:
    """Return what to call the file in messages, and what is in it."""
    if is_own(name_or_file):
        return name_or_file, _parsed(name_or_file, _content(Path(name_or_file)))
    shipped = {name: kind for kind in kinds for name in _shipped_names(kind)}
    if name_or_file not in shipped:
        file = f"{name_or_file}.toml"
        raise UnknownNameError(
            " or ".join(kinds), name_or_file, list(shipped), f"the file {file}" if _is_file(file) else ""
        )
    file = f"{name_or_file}.toml"
    return file, _parsed(file, _shipped(shipped[name_or_file]).joinpath(file).read_bytes())


def _own(name_or_file: str) -> str | None:
    """Return the file of the user's that is named, as it was; None for a name."""
    return name_or_file if is_own(name_or_file) else None


def _is_file(name: str) -> bool:
    try:
        return Path(name).is_file()
    except (OSError, ValueError):  # longer than a name can be, or with a NUL
        return False


def _content(path: Path) -> bytes:
    try:
        if (problem := _find_read_problem(path)) is None:
            return path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}. Name a file that can be read") from error
    except ValueError as error:
        raise UsageError(f"{str(path)!r} is no path: {error}. Name a file that can be read") from error
    raise UsageError(f"{path}: {problem}")


def _find_read_problem(path: Path) -> str | None:
    """Return why a file cannot be read, or None."""
    status = path.stat()
    if not (S_ISREG(status.st_mode) or S_ISDIR(status.st_mode)):  # the system tells of a folder
        return "it is a device or a pipe. Name a file that can be read"
    if S_ISREG(status.st_mode) and status.st_size > MAX_FILE_BYTES:
        return f"it has {status.st_size} bytes, at most {MAX_FILE_BYTES} are read. Name a smaller file"
    return None


def _parsed(file: str, content: bytes) -> Table:
    try:
        text = content.decode("utf-8-sig")
        problem = _find_long_key(text)
        table = {} if problem else tomllib.loads(text)
        problem = problem or next(_find_oversized(table, table), None)
        read = {} if problem else {key: frozen(value) for key, value in table.items()}
    except UnicodeDecodeError as error:
        raise DescriptionError(file, "", "it is not text", "A description is a TOML file in UTF-8") from error
    except (RecursionError, MemoryError) as error:
        raise DescriptionError(file, "", "it is nested too deep", "Take the nesting out") from error
    except ValueError as error:
        raise DescriptionError(
            file, "", f"it is not TOML: {str(error)[:MAX_LIBRARY_MESSAGE]}", "Mend it there"
        ) from error
    if problem:
        raise DescriptionError(file, *problem)
    return read


def _find_long_key(text: str) -> Mistake | None:
    """Return the fault of a key that has more than `MOST_DOTS` dots outside of quotes, if there is one."""
    if found := _LONG_KEY.search(_STRING.sub("_", text)):
        problem = f"it is nested too deep: the key {found[0][:MAX_SHOWN_CHARACTERS]}… has more than {MOST_DOTS} dots"
        return Mistake("", problem, "Take the nesting out")
    return None


def _find_oversized(table: Table, value: Any, place: tuple[str | int, ...] = ()) -> Iterator[Mistake]:
    """Yield a fault for each list or table in ``value`` of more than `MOST_ENTRIES`, and each longer whole number."""
    if isinstance(value, int) and value.bit_length() > MOST_BITS:
        problem = f"has {value.bit_length()} bits, at most {MOST_BITS} are read"
        yield Mistake(dotted_key(place, table), problem, "Take a smaller number")
    if not isinstance(value, (dict, list)):
        return
    if len(value) > MOST_ENTRIES:
        problem = f"has {len(value)} entries, at most {MOST_ENTRIES} are read"
        yield Mistake(dotted_key(place, table), problem, "Leave some out")
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        yield from _find_oversized(table, item, (*place, key))
