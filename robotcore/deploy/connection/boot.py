"""One call as a script for ``python3 -I -`` on the robot: whatever of it is a user's goes in as JSON, in a literal."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.abc import Traversable  # moved in 3.11, and gone from here in 3.14

COMMAND = "python3 -I -"
"""All that a shell on the robot is ever given for a call."""

PACKAGE = "robotcore.deploy.agent"
OUTSIDE = ("robotcore/__init__.py", "robotcore/deploy/__init__.py")
"""The packages around it, which are empty on the robot."""


def script(action: str, told: Mapping[str, Any]) -> str:
    """Return what makes a robot's Python do an action with what it is told by name, in ASCII."""
    first = files(PACKAGE).joinpath("bootstrap.py").read_text(encoding="utf-8")
    given = ", ".join(map(ascii, (json.dumps(sources()), action, json.dumps(told))))
    return f"{first}\n\nsys.exit(answer_call({given}))\n"


def sources() -> dict[str, str]:
    """Return the source of each module that works on the robot, by its file."""
    return dict.fromkeys(OUTSIDE, "") | dict(_sources(files(PACKAGE), PACKAGE.replace(".", "/")))


def _sources(folder: Traversable, path: str) -> Iterator[tuple[str, str]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _sources(entry, f"{path}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{path}/{entry.name}", entry.read_text(encoding="utf-8")
