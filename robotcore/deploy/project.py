"""The project to deploy, from its `pyproject.toml` and the options of the command line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, ConfigDict, Field, StringConstraints, ValidationError

from robotcore.description import RobotDescription, StrictModel, is_own, load_robot, load_world, read_table
from robotcore.description.validation import find_mistakes
from robotcore.errors import DescriptionError, UnknownNameError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.plugins import app_names
from robotcore.runtime.apps import app_name, is_app_file, load_app
from robotcore.runtime.plan import require_rate
from robotcore.runtime.settings import configure
from robotcore.sweep.spec import parse_seeds
from robotcore.sweep.statistics import Requirement
from robotcore.text import escape

FILE = "pyproject.toml"
TABLE = "robotcore"

ModelT = TypeVar("ModelT", bound=StrictModel)

Text = Annotated[str, StringConstraints(min_length=1)]
Texts = Annotated[tuple[Text, ...], Field(description="a list of strings")]


def _format_value(value: Any) -> str:
    """Return a value in the form of a command-line option."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, int, float)):
        return str(value)
    raise ValueError("should be a string, a number, true or false; correct it")


OptionText = Annotated[str, BeforeValidator(_format_value)]
"""A setting or an option, in the words of a command line."""


class DeployTable(StrictModel):
    """``[tool.robotcore.deploy]``: each key as the option of ``robotcore deploy push`` that overrides it."""

    backend: Text = "raspberrypi"
    settings: dict[str, OptionText] = Field(default_factory=dict)
    options: dict[str, OptionText] = Field(default_factory=dict)
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


def read_tables(folder: Path) -> Tables:
    """Return what a folder's ``pyproject.toml`` says, nothing where there is none; DescriptionError has every fault."""
    file = folder / FILE
    if not file.is_file():
        return Tables()
    table = read_table(str(file))
    tools = table.get("tool", {})
    ours = tools.get(TABLE) if isinstance(tools, Mapping) else None
    return Tables(
        robotcore=None if ours is None else _validate_table(RobotcoreTable, file, f"tool.{TABLE}", ours),
        project=_validate_table(ProjectTable, file, "project", table.get("project", {})),
        is_package="build-system" in table,
    )


def _validate_table(model: type[ModelT], file: Path, where: str, table: Any) -> ModelT:
    try:
        return model.model_validate(table, strict=True)
    except ValidationError as error:
        faults = [
            (f"{where}.{key}".rstrip("."), fault, remedy) for key, fault, remedy in find_mistakes(error, model, table)
        ]
        raise DescriptionError.of_all(str(file), faults) from error


def relative_file(folder: Path, base: Path, name: str, kind: str) -> str:
    """Return a file, named from ``base``, as its project's folder calls it; what stands behind a colon stays.

    It is a file to whoever reads it: ``./`` goes before what could be taken for an option or for something installed.
    Raises UsageError where it is not there, or outside of the folder: only what is inside is sent.
    """
    path, colon, rest = name.partition(":") if is_app_file(name) else (name, "", "")
    file = Path(os.path.normpath(base / path))
    if not file.is_file():
        raise UsageError(
            f"{escape(name)}: there is no such file. Name the {kind}'s file, or one that is installed",
            kind="no-such-file",
            file=name,
        )
    file = file.parent.resolve() / file.name
    if not file.is_relative_to(folder):
        raise UsageError(
            f"{escape(name)} is outside of {escape(str(folder))}, and only what is in there is sent. Move the {kind} "
            "into it, or name a folder that has both: --project DIR",
            kind="file-outside-project",
            file=name,
        )
    there = file.relative_to(folder).as_posix()
    is_plain = there.endswith((".py", ".toml")) and not there.startswith("-")
    return f"{'' if is_plain else './'}{there}{colon}{rest}"


def require_sendable(folder: Path) -> None:
    """Refuse, by UsageError, a folder that nobody means to send whole: the home, or what is above it."""
    if Path.home().resolve().is_relative_to(folder.resolve()):
        raise UsageError(
            f"{escape(str(folder))} would be sent whole, with all that is in your home. Make a folder for the project "
            "and put its files there: robotcore new",
            kind="home-folder",
        )


@dataclass(frozen=True)
class DeployOptions:
    """What a command line says; None is left to the project's file. Names of files are relative to where it was typed.

    ``settings`` and ``options`` are added to the project's, and go before them; ``folder`` is ``--project``.
    """

    app: str | None = None
    robot: str | None = None
    world: str | None = None
    backend: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)
    rate_hz: float | None = None
    seeds: str | None = None
    require: tuple[str, ...] | None = None
    record: bool | None = None
    folder: Path | None = None


@dataclass(frozen=True)
class Project:
    """What is proven at the desk, sent, and run on the robot.

    ``folder`` is the user's, absolute; None where only what is installed was named, and nothing of the user's is sent.
    ``app``, ``robot`` and ``world`` are names, or files relative to the folder. ``require`` are the bounds of a sweep
    that the app must keep, none for the usual ones. ``extras`` are robotcore's or the project's. ``metadata`` is
    ``[project]`` of its file; ``is_package`` where the folder can be built and installed.
    """

    folder: Path | None
    name: str
    app: str
    robot: str
    world: str | None = None
    backend: str = "raspberrypi"
    settings: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)
    rate_hz: float = 20.0
    seeds: str = "1-3"
    require: tuple[str, ...] = ()
    extras: tuple[str, ...] = ()
    is_recorded: bool = True
    is_package: bool = False
    metadata: ProjectTable = field(default_factory=ProjectTable)

    @property
    def files(self) -> tuple[str, ...]:
        """The files that it names, relative to its folder: without them it does not run."""
        app = (self.app.partition(":")[0],) if is_app_file(self.app) else ()
        return (*app, *(name for name in (self.robot, self.world) if name and is_own(name)))

    def load_description(self) -> RobotDescription:
        """Return the robot; raises what `load_robot` raises."""
        return load_robot(self.resolve(self.robot))

    def resolve(self, name: str) -> str:
        """Return a name or a file of the project as this process finds it, wherever it works."""
        return str(self.folder / name) if self.folder and (is_own(name) or is_app_file(name)) else name


def build_project(options: DeployOptions, here: Path | None = None) -> Project:
    """Return what is to be deployed from ``here``, by default the folder that this process works in.

    The project is the folder that was asked for; or this one, where its ``pyproject.toml`` has a ``[tool.robotcore]``,
    or a file of the user's is named. Raises UsageError where a name leads nowhere or a file is outside of the folder,
    DescriptionError where ``pyproject.toml`` is wrong.
    """
    here = (here or Path.cwd()).absolute()
    folder = here / options.folder if options.folder else here
    if options.folder and not folder.is_dir():
        raise UsageError(
            f"--project {options.folder}: there is no such folder. Name the one with your {FILE}",
            kind="no-such-folder",
            folder=str(options.folder),
        )
    tables = read_tables(folder)
    if not (options.folder or tables.robotcore or any(map(_is_file, _given_names(options)))):
        return _validate_project(_merge(options, Tables(), None, here))
    require_sendable(folder)
    return _validate_project(_merge(options, tables, folder.resolve(), here))


def _merge(options: DeployOptions, tables: Tables, folder: Path | None, here: Path) -> Project:
    """Return the project as the table has it, overridden by what was asked for."""
    table = tables.robotcore or RobotcoreTable()
    deploy = table.deploy
    app = _resolve_name(options, table, "app", folder, here)
    return Project(
        folder=folder,
        name=tables.project.name or (folder.name if folder else app_name(app)),
        app=app,
        robot=_resolve_name(options, table, "robot", folder, here),
        world=_resolve_name(options, table, "world", folder, here) if options.world or table.world else None,
        backend=options.backend or deploy.backend,
        settings={**deploy.settings, **options.settings},
        options={**deploy.options, **options.options},
        rate_hz=_first_given(options.rate_hz, deploy.rate_hz),
        seeds=_first_given(options.seeds, deploy.seeds),
        require=_first_given(options.require, deploy.require),
        extras=deploy.extras,
        is_recorded=_first_given(options.record, deploy.record),
        is_package=tables.is_package,
        metadata=tables.project,
    )


def _first_given(option: Any, default: Any) -> Any:
    return default if option is None else option


def _given_names(options: DeployOptions) -> list[str]:
    return [name for name in (options.app, options.robot, options.world) if name]


def _is_file(name: str) -> bool:
    return is_app_file(name) or is_own(name)


def _resolve_name(options: DeployOptions, table: RobotcoreTable, kind: str, folder: Path | None, here: Path) -> str:
    """Return the app, robot or world; a file of it relative to the project's folder."""
    given = getattr(options, kind)
    name = given or getattr(table, kind)
    if not name:
        raise UsageError(
            f'which {kind}? Name it with --{kind}, or in {FILE}: [tool.robotcore] {kind} = "…"',
            kind="missing-option",
            option=kind,
        )
    if folder is None or not _is_file(name):
        return str(name)
    return relative_file(folder, here if given else folder, name, kind)


def _validate_project(project: Project) -> Project:
    """Return the project; raise UsageError where something that it names is not there, or a number or a bound is none.

    The settings of an app of the user's own are looked at where it runs: its file is not imported here.
    """
    require_rate(project.rate_hz)
    load_backend(project.backend)
    if not is_app_file(project.app):
        if app_name(project.app) not in app_names():
            raise UnknownNameError("app", project.app, app_names())
        configure(load_app(project.app), project.settings)
    if not is_own(project.robot):
        load_robot(project.robot)
    if project.world and not is_own(project.world):
        load_world(project.world)
    parse_seeds(project.seeds)
    for bound in project.require:
        Requirement.parse(bound)
    return project
