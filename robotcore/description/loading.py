"""Loads the descriptions of robots and worlds, either shipped ones by their names or a user's from files."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from robotcore.description.file_reading import read_limited
from robotcore.description.generation.gaps import require_room
from robotcore.description.needed_version import KEY, require_version
from robotcore.description.robot import RobotDescription
from robotcore.description.types import StrictModel, freeze
from robotcore.description.validation import (
    BACKENDS,
    MAX_LIBRARY_MESSAGE,
    MAX_SHOWN_CHARACTERS,
    dotted_key,
    find_mistakes,
)
from robotcore.description.world import WorldDescription
from robotcore.errors import DescriptionError, Mistake, UnknownNameError, UsageError
from robotcore.plugins import backend_names
from robotcore.text import find_nearest

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
"""The greatest size of a file, in bytes. A file of this size is parsed in 2 s."""

MAX_ENTRIES = 1000
"""The greatest number of entries in a list or a table of a file."""

MAX_DOTS = 32
"""The greatest number of dots in a key. The parser's time and memory grow with the square of the number of dots."""

MAX_BITS = 64
"""The greatest number of bits of a whole number in a file, which is TOML's limit."""

_STRING = re.compile(
    r"""\"{3}(?:[^"\\]|\\.|"(?!""))*(?:\"{3})?|'{3}(?:[^']|'(?!''))*(?:'{3})?
    |"(?:[^"\\\n]|\\.)*"?|'[^'\n]*'?|\#[^\n]*""",
    re.VERBOSE | re.DOTALL,
)
"""Matches a string or a comment of TOML, also a string without an end, so that a search takes linear time."""

_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{MAX_DOTS + 1}}}")

KINDS: dict[str, type[StrictModel]] = {"robot": RobotDescription, "world": WorldDescription}
"""A mapping from the kind of a file to the model of its content."""


def robot_names() -> list[str]:
    """Return the names of the shipped robots.

    >>> robot_names()
    ['bubblerob', 'freenove-4wd', 'jetbot', 'lookout', 'picar', 'rover', 'scout', 'tracer']
    """
    return _list_shipped("robot")


def world_names() -> list[str]:
    """Return the names of the shipped worlds.

    >>> world_names()
    ['arena', 'bench', 'clutter', 'occluded', 'open', 'track']
    """
    return _list_shipped("world")


def read_shipped(name: str, kind: str = "robot") -> str:
    """Return the text of the file of a shipped robot or world. Raises UnknownNameError for an unknown name.

    kind: ``robot`` or ``world``.

    >>> read_shipped("rover").splitlines()[2]
    'name = "rover"'
    """
    if name not in (names := _list_shipped(kind)):
        raise UnknownNameError(kind, name, names)
    return _shipped_folder(kind).joinpath(f"{name}.toml").read_text(encoding="utf-8")


def is_own(name_or_file: str) -> bool:
    """Return whether a text is the path of a user's file, not the name of a shipped robot or world.

    >>> is_own("my_robot.toml"), is_own("rover")
    (True, False)
    """
    return name_or_file.endswith(".toml") or Path(name_or_file).name != name_or_file


def load_robot(name_or_file: str) -> RobotDescription:
    """Return the description of a shipped robot by its name, or of a user's robot from a ``.toml`` file.

    name_or_file: a name of `robot_names`, or a path that ends in ``.toml``.

    Raises UnknownNameError for an unknown name, UsageError for a file that cannot be read, and DescriptionError for
    mistakes in a file.

    >>> rover = load_robot("rover")
    >>> rover.drive.track_m, [device.name for device in rover.devices][:2]
    (0.155, ['left_motor', 'right_motor'])
    """
    return _make_robot(*_read(name_or_file, "robot"), _file_of(name_or_file))


def parse_robot(file: str, content: bytes) -> RobotDescription:
    """Return the description in the content of a user's file. Raises DescriptionError for mistakes in it."""
    return _make_robot(file, _parse(file, content), file)


def load_world(name_or_file: str) -> WorldDescription:
    """Return the description of a shipped world by its name, or of a user's world from a ``.toml`` file.

    name_or_file: a name of `world_names`, or a path that ends in ``.toml``.

    Raises UnknownNameError for an unknown name, UsageError for a file that cannot be read, and DescriptionError for
    mistakes in a file.

    >>> arena = load_world("arena")
    >>> arena.floor.length_m, arena.target.name
    (4.0, 'ball')
    """
    return _make_world(*_read(name_or_file, "world"))


def find_floor_image(world: str) -> Path | None:
    """Return the path of the picture on the floor of a user's world; None if there is none.

    world: the world's file.

    Raises the errors of `load_world`.
    """
    image = load_world(world).floor.image
    return Path(world).parent / image.file if image else None


def read_table(file: str) -> Table:
    """Return the content of a TOML file, with its lists as tuples.

    Raises UsageError for a file that cannot be read, and DescriptionError for a file that is not TOML.
    """
    return _parse(file, read_limited(Path(file), MAX_FILE_BYTES))


def read_toml(file: str, content: bytes) -> Table:
    """Return the content of a robot's file, with lists and tables that can be changed.

    Raises DescriptionError for a content that is not TOML.
    """
    _parse(file, content)
    return tomllib.loads(content.decode("utf-8-sig"))


def load_any(name_or_file: str) -> RobotDescription | WorldDescription:
    """Return the description of a robot or of a world, by the name of a shipped one or from a user's file.

    Raises the same errors as `load_robot`.
    """
    file, table = _read(name_or_file, *KINDS)
    require_version(file, table)
    kind = _find_kind(table)
    if kind is None:
        problem, remedy = "it describes neither a robot nor a world", "Add [body] for a robot, or [floor] for a world"
        raise DescriptionError(file, "", problem, remedy, kind="no-robot-and-no-world")
    return _make_robot(file, table, _file_of(name_or_file)) if kind == "robot" else _make_world(file, table)


def _make_robot(file: str, table: Table, own: str | None) -> RobotDescription:
    table = require_version(file, table)
    _require_kind("robot", file, table)
    if BACKENDS in table:
        problem, remedy = "a backend's section must be a top-level table", "Write [NAME], not [backends.NAME]"
        raise DescriptionError(file, BACKENDS, problem, remedy, kind="misplaced-section")
    sections = backend_names()
    present = {name: table[name] for name in sections if name in table}
    rest = {key: value for key, value in table.items() if key not in present}
    return _validate(RobotDescription, file, {**rest, BACKENDS: present}, sections, own)


def _make_world(file: str, table: Table) -> WorldDescription:
    table = require_version(file, table)
    _require_kind("world", file, table)
    world = _validate(WorldDescription, file, table, own=file)
    require_room(world, file)
    return world


def _validate(
    model: type[ModelT], file: str, table: Table, sections: Sequence[str] = (), own: str | None = None
) -> ModelT:
    try:
        return model.model_validate(table, strict=True, context={"file": own})
    except ValidationError as error:
        raise DescriptionError.of_all(file, find_mistakes(error, model, table, (KEY, *sections))) from error


def _require_kind(kind: str, file: str, table: Table) -> None:
    if (other := _find_kind(table)) not in (None, kind):
        problem, remedy = f"it describes a {other}, not a {kind}", f"Name it as the {other}"
        raise DescriptionError(file, "", problem, remedy, kind=f"is-a-{other}")


def _find_kind(table: Table) -> str | None:
    # Each kind has keys that the other does not have. The table is of the kind of which it has more such keys.
    robot, world = (set(model.model_fields) for model in KINDS.values())
    robots, worlds = len(table.keys() & (robot - world)), len(table.keys() & (world - robot))
    if robots == worlds:
        return None
    return "robot" if robots > worlds else "world"


def _shipped_folder(kind: str) -> Traversable:
    return resources.files("robotcore.description").joinpath(f"{kind}s")


def _list_shipped(kind: str) -> list[str]:
    names = (file.name for file in _shipped_folder(kind).iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def _read(name_or_file: str, *kinds: str) -> tuple[str, Table]:
    """Return the name of a file for messages, and the content of the file.

    kinds: the kinds of shipped files among which a name is searched, such as ``robot``.
    """
    if is_own(name_or_file):
        return name_or_file, _parse(name_or_file, read_limited(Path(name_or_file), MAX_FILE_BYTES))
    shipped = {name: kind for kind in kinds for name in _list_shipped(kind)}
    if name_or_file not in shipped:
        if any(file.name == name_or_file and file.is_file() for file in Path().glob("*")):
            text = f"{name_or_file} is another file, not that of a {' or a '.join(kinds)}. Name a .toml file"
            raise UsageError(text, kind="not-a-description")
        raise UnknownNameError(" or ".join(kinds), name_or_file, list(shipped), _suggest_file(name_or_file))
    file = f"{name_or_file}.toml"
    return file, _parse(file, _shipped_folder(shipped[name_or_file]).joinpath(file).read_bytes())


def _file_of(name_or_file: str) -> str | None:
    return name_or_file if is_own(name_or_file) else None


def _suggest_file(name: str) -> str:
    """Return a suggestion of the file of this name in the current folder, or of one with a similar name."""
    files = [file.name for file in Path().glob("*.toml")]
    nearest = find_nearest(name, files) if "." in name else None
    file = nearest or f"{name}.toml"
    return f"the file {file}" if file in files else ""


def _parse(file: str, content: bytes) -> Table:
    try:
        text = content.decode("utf-8-sig")
        mistake = _find_long_key(text)
        table = {} if mistake else tomllib.loads(text)
        mistake = mistake or next(_find_oversized(table, table), None)
        content_read = {} if mistake else {key: freeze(value) for key, value in table.items()}
    except UnicodeDecodeError as error:
        remedy = "Name a TOML file in UTF-8"
        raise DescriptionError(file, "", "it is not text", remedy, kind="not-text") from error
    except (RecursionError, MemoryError) as error:
        problem = "its tables or lists are nested too deeply"
        raise DescriptionError(file, "", problem, "Remove the nesting", kind="nested-too-deep") from error
    except ValueError as error:
        problem = f"it is not TOML: {str(error)[:MAX_LIBRARY_MESSAGE]}"
        is_repeated = "twice" in problem
        remedy = "Write [[NAME]], such as [[devices]], for each table of a list" if is_repeated else "Correct the file"
        raise DescriptionError(file, "", problem, remedy, kind="not-toml") from error
    if mistake:
        raise DescriptionError.of_all(file, [mistake])
    return content_read


def _find_long_key(text: str) -> Mistake | None:
    if found := _LONG_KEY.search(_STRING.sub("_", text)):
        problem = f"the key {found[0][:MAX_SHOWN_CHARACTERS]}… has more than {MAX_DOTS} dots"
        return Mistake(problem, "Remove the nesting", kind="too-many-dots")
    return None


def _find_oversized(table: Table, value: Any, path: tuple[str | int, ...] = ()) -> Iterator[Mistake]:
    if isinstance(value, int) and value.bit_length() > MAX_BITS:
        problem = f"has {value.bit_length()} bits, and the limit is {MAX_BITS}"
        yield Mistake(problem, "Take a smaller number", kind="number-too-long", key=dotted_key(path, table))
    if not isinstance(value, (dict, list)):
        return
    if len(value) > MAX_ENTRIES:
        problem = f"has {len(value)} entries, and the limit is {MAX_ENTRIES}"
        yield Mistake(problem, "Remove some", kind="too-many-entries", key=dotted_key(path, table))
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        yield from _find_oversized(table, item, (*path, key))
