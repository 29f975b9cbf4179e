"""What a project's ``pyproject.toml`` says of the robot: its own tables, and the standard one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, ConfigDict, Field, StringConstraints, ValidationError

from robotcore.description import StrictModel, read_table
from robotcore.description.validation import find_mistakes
from robotcore.errors import DescriptionError

FILE = "pyproject.toml"
TABLE = "robotcore"

ModelT = TypeVar("ModelT", bound=StrictModel)

Text = Annotated[str, StringConstraints(min_length=1)]
Texts = Annotated[tuple[Text, ...], Field(description="a list of strings")]


def _told(value: Any) -> str:
    """Return a value as a command line says it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, int, float)):
        return str(value)
    raise ValueError("should be a string, a number, true or false; correct it")


Said = Annotated[str, BeforeValidator(_told)]
"""A setting or an option, in the words of a command line."""


class DeployTable(StrictModel):
    """``[tool.robotcore.deploy]``: each key as the option of ``robotcore deploy push`` that overrides it."""

    backend: Text = "raspberrypi"
    settings: dict[str, Said] = Field(default_factory=dict)
    options: dict[str, Said] = Field(default_factory=dict)
    rate_hz: Annotated[float, Field(gt=0)] = 20.0
    record: bool = True
    seeds: Text = "1-3"
    require: Texts = ()
    extras: Texts = ()


class RobotcoreTable(StrictModel):
    """``[tool.robotcore]``: files are relative to the project's folder; names are those of what is installed."""

    app: Text | None = None
    robot: Text | None = None
    world: Text | None = None
    deploy: DeployTable = DeployTable()


class ProjectTable(StrictModel):
    """``[project]``, as far as it matters here (PEP 621)."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    name: Text | None = None
    dependencies: Texts = ()
    optional: dict[str, Texts] = Field(alias="optional-dependencies", default_factory=dict)
    requires_python: str = Field(alias="requires-python", default="")


class Tables(StrictModel):
    """All that is read of a ``pyproject.toml``.

    ``robotcore`` is None where there is no such table; ``is_package`` where it says how the project is built.
    """

    robotcore: RobotcoreTable | None = None
    project: ProjectTable = ProjectTable()
    is_package: bool = False


def tables_of(folder: Path) -> Tables:
    """Return what a folder's ``pyproject.toml`` says, nothing where there is none; DescriptionError has every fault."""
    file = folder / FILE
    if not file.is_file():
        return Tables()
    table = read_table(str(file))
    tools = table.get("tool", {})
    ours = tools.get(TABLE) if isinstance(tools, Mapping) else None
    return Tables(
        robotcore=None if ours is None else _validated(RobotcoreTable, file, f"tool.{TABLE}", ours),
        project=_validated(ProjectTable, file, "project", table.get("project", {})),
        is_package="build-system" in table,
    )


def _validated(model: type[ModelT], file: Path, where: str, table: Any) -> ModelT:
    try:
        return model.model_validate(table, strict=True)
    except ValidationError as error:
        faults = [
            (f"{where}.{key}".rstrip("."), fault, remedy) for key, fault, remedy in find_mistakes(error, model, table)
        ]
        raise DescriptionError.of_all(str(file), faults) from error
