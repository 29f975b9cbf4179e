"""Shows the measured values of a command as a diff of the robot's file, and writes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from robotcore.cli.output import write_content, write_line

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.description.editing import RobotEditor
    from robotcore.hal.backend import Backend


class RobotChanges:
    """Collects changes of a robot's file.

    robot: the name of a robot, or its file.
    is_writing: whether the changes are written. Then the file must be the user's own.

    Raises UsageError if the changes could not be written, before anything is measured.
    """

    def __init__(self, robot: str, *, is_writing: bool) -> None:
        from robotcore.description import is_own, load_robot
        from robotcore.description.editing import RobotEditor

        self._robot, self._is_writing = robot, is_writing
        self._editor: RobotEditor | None = RobotEditor(robot) if is_writing or is_own(robot) else None
        if self._editor and is_writing:
            self._editor.require_writable()
        self._reason = ""
        self._values: dict[str, dict[str, Any]] = {}
        self._diff = ""
        self._known_doubts = _find_doubts(load_robot(robot)) if self._editor else []
        self._doubts: list[str] = []
        self.is_written = False
        """Whether `finish` has written the file."""

    def set_drive(self, **values: Any) -> None:
        """Set keys of ``[drive]``."""
        self._change("drive", values, lambda editor: editor.set_drive(**values))

    def set_device(self, device: str, **values: Any) -> None:
        """Set keys in the table of ``[[devices]]`` with a name."""
        self._change(f"devices.{device}", values, lambda editor: editor.set_device(device, **values))

    def set_section(self, section: str, device: str, **values: Any) -> None:
        """Set keys in the table of a device in a backend's section. A mapping changes keys of an inner table."""
        self._change(f"{section}.{device}", values, lambda editor: editor.set_section(section, device, **values))

    def replace_section(self, section: str, device: str, table: Mapping[str, Any]) -> None:
        """Replace the table of a device in a backend's section."""
        self._change(f"{section}.{device}", table, lambda editor: editor.replace_section(section, device, table))

    def _change(self, table: str, values: Mapping[str, Any], edit: Callable[[RobotEditor], None]) -> None:
        if self._editor:
            edit(self._editor)
        _merge(self._values.setdefault(table, {}), values)

    @property
    def changed_devices(self) -> set[str]:
        """The names of the devices whose tables change."""
        return {table.partition(".")[2] for table in self._values} - {""}

    def refuse(self, reason: str) -> None:
        """Show the changes, but do not write them.

        reason: a sentence without its full stop.
        """
        self._reason = reason

    def finish(self, backend: Backend) -> None:
        """Write the file, if the user wants it. The backend checks the new content first.

        Raises DescriptionError if the new content has mistakes, and UsageError if the file cannot be written.
        """
        if not (self._editor and self._editor.has_changed):
            return
        self._diff = self._editor.diff
        refused, self._reason = self._reason, "the new values have mistakes"
        parsed = self._editor.parse()
        backend.check(parsed)
        self._doubts = [each for each in _find_doubts(parsed) if each not in self._known_doubts]
        self._reason = refused
        if self._is_writing and not self._reason:
            self._reason = "it could not be written"
            self._editor.write()
            self._reason, self.is_written = "", True

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON.

        The JSON keys:

        values: object; the changed values of the robot's file, by table and key.
        diff: text; the change of the robot's file as a diff. Empty for a shipped robot, whose file cannot be changed.
        warnings: list of text; the new values that are doubtful.
        is_written: true or false; whether the file was changed.
        """
        return {
            "values": self._values,
            "diff": self._diff,
            "warnings": self._doubts,
            "is_written": self.is_written,
        }

    def show(self, *, is_right: bool) -> None:
        """Write the changes on stdout, and what the user can do with them.

        is_right: whether the file is right if there are no changes.
        """
        if not self._values and not is_right:
            return
        write_line()
        if not self._values or (self._editor and not self._diff):
            write_line(f"{self._robot} agrees with the measurement. There is nothing to correct.")
        elif self._editor is None:
            self._show_values()
        else:
            write_content(self._diff)
            write_line()
            for doubt in self._doubts:
                write_line(f"warning: {doubt}")
            write_line(self._describe_end())

    def _describe_end(self) -> str:
        if self._reason:
            return f"{self._robot} stays as it is: {self._reason}."
        return f"{self._robot} has been corrected." if self.is_written else f"Add --write to correct {self._robot}."

    def _show_values(self) -> None:
        import tomlkit

        for table, values in self._values.items():
            write_line(f"{table}: {tomlkit.item(dict(values)).as_string().strip().replace(chr(10), ', ')}")
        copy = f"my_{self._robot.replace('-', '_')}.toml"
        write_line(f"To correct a robot, copy its file: robotcore robots {self._robot} > {copy}")
        write_line(f"Then repeat this command with --robot {copy} --write.")


def _find_doubts(robot: RobotDescription) -> list[str]:
    """Return the warnings of `robotcore check` about a robot's file."""
    from robotcore.description.doubtful_values import find_doubtful_values

    return [*find_doubtful_values(robot)]


def _merge(table: dict[str, Any], values: Mapping[str, Any]) -> None:
    """Set values in a table. A mapping changes keys of an inner table."""
    for key, value in values.items():
        if isinstance(value, Mapping) and isinstance(table.get(key), dict):
            _merge(table[key], value)
        else:
            table[key] = dict(value) if isinstance(value, Mapping) else value
