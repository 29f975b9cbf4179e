"""Changes values in a robot's file, and keeps its comments, its order and its format."""

from __future__ import annotations

import copy
import difflib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from shlex import quote
from typing import Any

from robotcore.description.file_reading import read_limited
from robotcore.description.loading import MAX_FILE_BYTES, is_own, load_robot, parse_robot, read_toml
from robotcore.description.robot import RobotDescription
from robotcore.errors import UsageError
from robotcore.files import replace_file, require_replaceable

BYTE_ORDER_MARK = "\ufeff"


class RobotEditor:
    """Changes values in the file of a robot. Nothing is written until `write`.

    >>> from tempfile import TemporaryDirectory
    >>> from robotcore.description.loading import read_shipped
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "my_robot.toml")
    ...     _ = file.write_text(read_shipped("rover"))
    ...     editor = RobotEditor(str(file))
    ...     editor.set_drive(track_m=0.152)
    ...     editor.set_device("left_motor", lag_s=0.07)
    ...     editor.set_section("raspberrypi", "left_motor", model={"dead_band": 0.13})
    ...     editor.write()
    ...     load_robot(str(file)).drive.track_m
    0.152
    """

    def __init__(self, robot: str) -> None:
        """Read the file of a robot.

        robot: the path of a user's file.

        Raises UsageError for a shipped robot and for a file that cannot be read, and DescriptionError for mistakes in
        the file.
        """
        if not is_own(robot):
            load_robot(robot)  # an unknown name has its own error
            raise UsageError(
                f"{robot} is a shipped robot, whose file cannot be changed. Copy it: robotcore robots {robot} > "
                f"my_{robot.replace('-', '_')}.toml. Then name the copy with --robot",
                kind="shipped-robot",
                robot=robot,
            )
        import tomlkit

        self.file = robot
        self._content = read_limited(Path(robot), MAX_FILE_BYTES)
        load_robot(robot)
        self._before = self._content.decode("utf-8")
        plain = self._before.removeprefix(BYTE_ORDER_MARK).replace("\r\n", "\n")
        self._mark = BYTE_ORDER_MARK if self._before.startswith(BYTE_ORDER_MARK) else ""
        self._document: Any = tomlkit.parse(plain)
        self._expected: Any = read_toml(robot, plain.encode())

    def set_drive(self, **values: Any) -> None:
        """Set keys of ``[drive]``. Raises UsageError if the file has no such table."""
        self._set(("drive",), values)

    def set_device(self, device: str, **values: Any) -> None:
        """Set keys in the table of ``[[devices]]`` with a name. Raises UsageError if there is none."""
        numbers = [number for number, each in enumerate(self._expected["devices"]) if each.get("name") == device]
        if not numbers:
            raise self._missing(f"[[devices]] with the name {device!r}")
        self._set(("devices", numbers[0]), values)

    def set_section(self, section: str, device: str, **values: Any) -> None:
        """Set keys in the table of a device in a backend's section. A mapping changes keys of an inner table.

        Raises UsageError if the file has no such table.
        """
        self._set((section, device), values)

    def replace_section(self, section: str, device: str, table: Mapping[str, Any]) -> None:
        """Replace the table of a device in a backend's section. Keys with an equal value keep their format.

        Raises UsageError if the file has no such table.
        """
        self._set((section, device), table)
        _remove_others(self._document[section][device], table)
        self._expected[section][device] = copy.deepcopy(dict(table))

    def _set(self, path: tuple[str | int, ...], values: Mapping[str, Any]) -> None:
        for tree in (self._document, self._expected):
            table = tree
            for key in path:
                if isinstance(key, str) and key not in table:
                    raise self._missing(f"[{'.'.join(map(str, path))}]")
                table = table[key]
            _update(table, values)

    def _missing(self, table: str) -> UsageError:
        text = f"{self.file}: it has no table {table}. Add it, and check the file: robotcore check {self.file}"
        return UsageError(text, kind="no-such-table", file=self.file)

    @property
    def text(self) -> str:
        """The new text of the file."""
        new: str = self._document.as_string()
        return self._mark + _restore_line_endings(self._before.removeprefix(BYTE_ORDER_MARK), new)

    @property
    def has_changed(self) -> bool:
        """Whether the new text differs from the file."""
        return self.text != self._before

    @property
    def diff(self) -> str:
        """The changes as a unified diff; ``""`` without one."""
        texts = (each.replace("\r\n", "\n").removesuffix("\n") for each in (self._before, self.text))
        before, after = (each.split("\n") for each in texts)
        lines = difflib.unified_diff(before, after, self.file, f"{self.file} (new)", lineterm="")
        return "".join(f"{line}\n" for line in lines)

    def parse(self) -> RobotDescription:
        """Return the description in the new text. Raises DescriptionError for mistakes in it."""
        description = parse_robot(self.file, self.text.encode())
        if read_toml(self.file, self.text.encode()) != self._expected:
            raise UsageError(
                f"{self.file}: its format does not allow the change. Change the values by hand:\n{self.diff}",
                kind="not-editable",
                file=self.file,
            )
        return description

    def require_writable(self) -> None:
        """Raise UsageError if the file could not be written."""
        try:
            require_replaceable(Path(self.file))
        except OSError as error:
            raise self._refuse(error) from error

    def write(self, check: Callable[[RobotDescription], object] = lambda _robot: None) -> None:
        """Write the new text in place of the file. If anything fails, the file keeps its old content.

        check: checks the new description, such as by a backend's `check`. It raises an exception for mistakes.

        Raises the errors of `parse`, and UsageError if the file has changed since it was read or cannot be written.
        """
        check(self.parse())
        if read_limited(Path(self.file), MAX_FILE_BYTES) != self._content:
            text = f"{self.file}: another program has changed the file in the meantime, so it was not written. Repeat"
            raise UsageError(f"{text} the command", kind="file-changed", file=self.file)
        content = self.text.encode()
        try:
            self.require_writable()
            with replace_file(Path(self.file)) as part, part.open("wb") as new:
                new.write(content)
                new.flush()
                os.fsync(new.fileno())
        except OSError as error:
            raise self._refuse(error) from error
        self._content, self._before = content, self.text

    def _refuse(self, error: OSError) -> UsageError:
        file = Path(self.file)
        if file.is_symlink():
            target = os.path.realpath(file)
            text = f"{self.file} is a symbolic link, which is not replaced. Name its target: --robot {quote(target)}"
            return UsageError(text, kind="linked-file", file=self.file, target=target)
        text = f"{self.file}: cannot be written: {error.strerror}. Allow it, or name a copy of the file with --robot"
        return UsageError(text, kind="unwritable-file", file=self.file)


def _restore_line_endings(before: str, after: str) -> str:
    r"""Return a text in which each line has the ending that it has in an older text.

    A line that replaces another one gets the ending of that one, and a line that is added that of the line before it.

    before: the older text. Its lines end with ``\n`` or ``\r\n``.
    after: the text. Its lines end with ``\n``.
    """
    if "\r\n" not in before:
        return after
    old, new = before.split("\n"), after.split("\n")
    endings = ["\r\n" if line.endswith("\r") else "\n" for line in old[:-1]]
    found: list[str] = []
    plain = [line.removesuffix("\r") for line in old]
    for _, first, last, start, end in difflib.SequenceMatcher(None, plain, new, autojunk=False).get_opcodes():
        kept = endings[first:last]
        before_it = (kept or endings[:first] or endings[:1])[-1]
        found += (kept + [before_it] * (end - start))[: end - start]
    return "".join(line + ending for line, ending in zip(new, [*found[: len(new) - 1], ""], strict=True))


def _update(table: Any, values: Mapping[str, Any]) -> None:
    """Set values in a table of tomlkit, or in a plain dict. A value that is equal keeps its format."""
    for key, value in values.items():
        if isinstance(value, Mapping) and key in table:
            _update(table[key], value)
        elif key in table:
            if table[key] != value:
                table[key] = value
        elif type(table) is dict:
            table[key] = value
        else:
            _add(table, key, value)


def _remove_others(table: Any, kept: Mapping[str, Any]) -> None:
    """Remove the keys of a table of tomlkit, and of its inner tables, that another mapping does not have."""
    for key in [key for key in table if key not in kept]:
        del table[key]
    for key, value in kept.items():
        if isinstance(value, Mapping):
            _remove_others(table[key], value)


def _add(table: Any, key: str, value: Any) -> None:
    """Add a key behind the last one of a table, before the comments that precede the next table."""
    from tomlkit import inline_table, item
    from tomlkit.items import InlineTable, Table

    if isinstance(value, Mapping):
        new: Any = inline_table()
        new.update(value)
    else:
        new = item(value)
    if isinstance(table, InlineTable):
        new.trivia.trail = " "  # before the closing bracket
    body = table.value.body if isinstance(table, Table) else []
    after = next((number for number in range(len(body), 0, -1) if body[number - 1][0] is not None), len(body))
    comments = body[after:]
    del body[after:]
    table[key] = new
    body.extend(comments)
