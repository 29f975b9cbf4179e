"""Shows the measured values of a command as a diff of the robot's file, and writes them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import write_line, write_lines

if TYPE_CHECKING:
    from robotcore.description.editing import RobotEditor
    from robotcore.hal.backend import Backend

write_option = click.option("--write", "is_writing", is_flag=True, help="Write the results to the robot's file.")
"""The option ``--write`` of a command."""


class RobotChanges:
    """Collects changes of a robot's file.

    robot: the name of a robot, or its file.
    is_writing: whether the changes are written. Then the file must be the user's own.

    Raises UsageError if the changes could not be written, before anything is measured.
    """

    def __init__(self, robot: str, *, is_writing: bool) -> None:
        from robotcore.description import is_own
        from robotcore.description.editing import RobotEditor

        self._robot, self._is_writing = robot, is_writing
        self._editor: RobotEditor | None = RobotEditor(robot) if is_writing or is_own(robot) else None
        if self._editor and is_writing:
            self._editor.require_writable()
        self.values: dict[str, dict[str, Any]] = {}
        """The new values of each table, for JSON and for a shipped robot, whose file has no diff."""
        self.diff = ""
        """The changes as a unified diff, after `finish`. Empty for a shipped robot."""
        self.is_written = False
        """Whether `finish` has written the file."""

    def set_device(self, device: str, values: Mapping[str, Any]) -> None:
        """Set keys in the table of ``[[devices]]`` with a name."""
        if self._editor:
            self._editor.set_device(device, **values)
        self._add(f"devices.{device}", values)

    def set_section(self, section: str, device: str, values: Mapping[str, Any]) -> None:
        """Set keys in the table of a device in a backend's section."""
        if self._editor:
            self._editor.set_section(section, device, **values)
        self._add(f"{section}.{device}", values)

    def replace_section(self, section: str, device: str, table: Mapping[str, Any]) -> None:
        """Replace the table of a device in a backend's section."""
        if self._editor:
            self._editor.replace_section(section, device, table)
        self._add(f"{section}.{device}", table)

    def _add(self, table: str, values: Mapping[str, Any]) -> None:
        self.values.setdefault(table, {}).update(values)

    def finish(self, backend: Backend) -> None:
        """Write the file, if the user wants it. The backend checks the new content first.

        Raises DescriptionError if the new content has mistakes, and UsageError if the file cannot be written.
        """
        if self._editor and self._editor.has_changed:
            self.diff = self._editor.diff
            if self._is_writing:
                self._editor.write(backend.check)
                self.is_written = True
            else:
                backend.check(self._editor.parse())

    def show(self) -> None:
        """Write the changes on stdout, and what the user can do with them."""
        if not self.values:
            return
        write_line()
        if self._editor is None:
            self._show_values()
        elif not self.diff:
            write_line(f"{self._robot} has these values already.")
        else:
            write_lines(self.diff.rstrip("\n"))
            write_line(
                f"Written to {self._robot}." if self.is_written else "Nothing was written. Add --write to write it."
            )

    def _show_values(self) -> None:
        import tomlkit

        for table, values in self.values.items():
            write_line(f"{table}: {tomlkit.item(dict(values)).as_string().strip().replace(chr(10), ', ')}")
        write_line(
            f"{self._robot} is a shipped robot, whose file cannot be changed. Copy it: robotcore robots {self._robot} "
            f"> my_{self._robot.replace('-', '_')}.toml"
        )
