"""A robot whose board is plugged in elsewhere than its file says: the option ``port``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import UsageError


def plugged_in_at(robot: RobotDescription, section: str, port: str | None) -> RobotDescription:
    """Return the robot with its one port at another place, or as it is where there is none to take.

    Raises UsageError where it has more ports than one, or none.
    """
    if port is None:
        return robot
    tables = robot.backends.get(section, {})
    ports = sorted({str(table["port"]) for table in tables.values() if _has_port(table)})
    if len(ports) != 1:
        has = f"has {len(ports)} ports, {', '.join(ports)}" if ports else "names no port"
        raise UsageError(
            f"--port {port} takes the place of a robot's one port, and {robot.source} {has}. Leave it out, and name "
            f"them in [{section}]"
        )
    moved = {name: {**table, "port": port} if _has_port(table) else table for name, table in tables.items()}
    return robot.model_copy(update={"backends": {**robot.backends, section: moved}})


def _has_port(table: Any) -> bool:
    return isinstance(table, Mapping) and "port" in table
