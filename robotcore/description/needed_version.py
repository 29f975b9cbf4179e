"""The key ``robotcore`` of a robot's or a world's file: the versions of robotcore that can read the file."""

from __future__ import annotations

from typing import Any

from robotcore.compatibility import check_range
from robotcore.description.validation import format_value
from robotcore.errors import DescriptionError

KEY = "robotcore"


def require_version(file: str, table: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a file without the key `KEY`.

    The key is checked before all others, because a file for a newer robotcore may have keys that are unknown here.

    file: the name of the file.
    table: the content of the file.

    Raises DescriptionError if this robotcore is not in the range, or if the value is no range.

    >>> require_version("rover.toml", {"robotcore": ">=0.0.1", "name": "rover"})
    {'name': 'rover'}
    """
    if KEY not in table:
        return table
    needed = table[KEY]
    try:
        unmet = check_range(needed if isinstance(needed, str) and needed.strip() else "no range")
    except ValueError as error:
        problem = f"should be a range of versions, got {format_value(needed)}"
        raise DescriptionError(file, KEY, problem, 'Write a range such as ">=0.1"', kind="wrong-form") from error
    if unmet:
        raise DescriptionError(
            file,
            KEY,
            f"the file needs robotcore {unmet.needed}, and this is robotcore {unmet.installed}",
            unmet.remedy,
            kind="robotcore-version",
            needed=unmet.needed,
            installed=unmet.installed,
        )
    return {key: value for key, value in table.items() if key != KEY}
