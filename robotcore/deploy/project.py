"""The project to deploy: the tables of its ``pyproject.toml``, with the options of the command line applied."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import metadata
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, StringConstraints, ValidationError

from robotcore.deploy.agent.releases import DEFAULT_VIEW_PORT, MAX_VIEW_PORT, MIN_VIEW_PORT
from robotcore.description import (
    RobotDescription,
    StrictModel,
    find_floor_image,
    is_own,
    load_robot,
    load_world,
    read_table,
)
from robotcore.description.validation import find_mistakes
from robotcore.errors import DescriptionError, UnknownNameError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.plugins import app_names
from robotcore.runtime.apps import app_name, is_app_file, load_app
from robotcore.runtime.plan import require_no_lockstep, require_rate
from robotcore.runtime.settings import configure
from robotcore.sweep.spec import parse_seeds
from robotcore.sweep.statistics import Requirement
from robotcore.text import escape, parse_duration

__all__ = ["DeployOptions", "Project", "build_project"]

FILE = "pyproject.toml"
TABLE = "robotcore"

ModelT = TypeVar("ModelT", bound=StrictModel)

Text = Annotated[str, StringConstraints(min_length=1)]
Texts = Annotated[tuple[Text, ...], Field(description="a list of strings")]


def _format_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, int, float)):
        return str(value)
    raise ValueError("should be a string, a number, true or false; correct it")


OptionText = Annotated[str, BeforeValidator(_format_value)]
"""The text of a setting's or an option's value, as in a command-line option: ``true``, ``0.5``."""


WHOLE_RUN = "all"
"""The value of ``record_last`` for recordings of whole runs."""


def _require_duration(value: str) -> str:
    if value != WHOLE_RUN:
        try:
            parse_duration(value)
        except ValueError as error:
            raise ValueError(f'should be a duration such as "10min", or "{WHOLE_RUN}"; correct it') from error
    return value


class DeployTable(StrictModel):
    """The table ``[tool.robotcore.deploy]``. The options of ``robotcore deploy push`` override its keys."""

    backend: Text = "raspberrypi"
    settings: dict[str, OptionText] = Field(default_factory=dict)
    options: dict[str, OptionText] = Field(default_factory=dict)
    rate_hz: Annotated[float, Field(gt=0)] = 20.0
    record: bool = True
    record_last: Annotated[Text, AfterValidator(_require_duration)] = "10min"
    """The time before the end of a run that its recording keeps, such as ``10min``; ``all`` for the whole run."""
    view: Annotated[int, Field(ge=MIN_VIEW_PORT, le=MAX_VIEW_PORT)] | None = None
    """The port of the robot's 127.0.0.1 at which the app has its live page; None without a page."""
    rt: bool = False
    """Whether the ticks of the app have real-time priority on the robot. See the page "Safety"."""
    seeds: Text = "1-3"
    require: Texts = ()
    extras: Texts = ()


class RobotcoreTable(StrictModel):
    """The table ``[tool.robotcore]``.

    Each key names a file relative to the project's folder, or an installed app, robot or world.
    """

    app: Text | None = None
    robot: Text | None = None
    world: Text | None = None
    deploy: DeployTable = field(default_factory=DeployTable)


class ProjectTable(StrictModel):
    """The keys of the table ``[project]`` that a push reads. Source: PEP 621."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    name: Text | None = None
    dependencies: Texts = ()
    optional: dict[str, Texts] = Field(alias="optional-dependencies", default_factory=dict)
    requires_python: str = Field(alias="requires-python", default="")


class Tables(StrictModel):
    """The tables of a ``pyproject.toml`` that a push reads."""

    robotcore: RobotcoreTable | None = None
    """The table ``[tool.robotcore]``; None if the file has no such table."""
    project: ProjectTable = ProjectTable()
    is_package: bool = False
    """Whether the file has a table ``[build-system]``, so that pip can install the project."""


def read_tables(folder: Path) -> Tables:
    """Return the tables of the ``pyproject.toml`` in a folder, or empty tables if there is no such file.

    Raises DescriptionError with a list of all mistakes in the file.
    """
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
        mistakes = [each.below(where) for each in find_mistakes(error, model, table)]
        raise DescriptionError.of_all(str(file), mistakes) from error


def resolve_file(folder: Path, base: Path, name: str, kind: str) -> str:
    """Return the path of a file relative to the project's folder.

    The path begins with ``./`` if it would otherwise look like an option or like an installed name.

    folder: the project's folder.
    base: the folder to which ``name`` is relative.
    name: the name of the file. An app may be ``FILE:CLASS``.
    kind: ``app``, ``robot`` or ``world``, for the error message.
    Raises UsageError if the file does not exist, or is outside of the project's folder and would not be sent.
    """
    path, colon, rest = name.partition(":") if is_app_file(name) else (name, "", "")
    file = Path(os.path.normpath(base / path))
    if not file.is_file():
        raise UsageError(
            f"{escape(name)}: there is no such file. Name the {kind}'s file, or an installed {kind}",
            kind="no-such-file",
            file=name,
        )
    file = file.parent.resolve() / file.name
    if not file.is_relative_to(folder):
        raise UsageError(
            f"{escape(name)} is outside of {escape(str(folder))}, and only files in that folder are sent. Move the "
            f"{kind} into it, or name a folder that has both: --project DIR",
            kind="file-outside-project",
            file=name,
        )
    there = file.relative_to(folder).as_posix()
    is_plain = there.endswith((".py", ".toml")) and not there.startswith("-")
    return f"{'' if is_plain else './'}{there}{colon}{rest}"


@dataclass(frozen=True)
class DeployOptions:
    """The options of a push. Each option that is not None overrides the project's ``pyproject.toml``.

    File names are relative to the current folder.

    >>> DeployOptions(app="search.py", robot="my_robot.toml", seeds="1-3").seeds
    '1-3'
    """

    app: str | None = None
    robot: str | None = None
    world: str | None = None
    backend: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    """Settings of the app. They override the project's settings of the same name."""
    options: Mapping[str, str] = field(default_factory=dict)
    """Options of the backend. They override the project's options of the same name."""
    rate_hz: float | None = None
    seeds: str | None = None
    """The seeds of the simulation check, such as ``1-3`` or ``1,5,9-12``."""
    require: tuple[str, ...] | None = None
    """The bounds on the results of the simulation check, such as ``verified>=1``."""
    record: bool | None = None
    """Whether each run on the robot is recorded."""
    record_last: str | None = None
    """The time before the end of a run that its recording keeps, such as ``10min``; ``all`` for the whole run."""
    is_real_time: bool = False
    """Whether the ticks of the app have real-time priority, also if the project does not say so."""
    has_view: bool = False
    """Whether the app has a live page, also if the project names no port for it."""
    folder: Path | None = None
    """The project's folder; None for the current folder."""


@dataclass(frozen=True)
class Project:
    """A project to deploy: an app, a robot, and how the app runs there.

    >>> from pathlib import Path
    >>> from robotcore.deploy.project import DeployOptions, build_project
    >>> project = build_project(DeployOptions(app="green-search", robot="rover"), Path("/"))
    >>> project.name, project.load_description().name, project.folder is None
    ('green-search', 'rover', True)
    """

    folder: Path | None
    """The absolute path of the user's folder; None if app, robot and world are installed, so that no file is sent."""
    name: str
    app: str
    """The app's name, or its file relative to the folder."""
    robot: str
    """The robot's name, or its file relative to the folder."""
    world: str | None = None
    """The world's name, or its file relative to the folder. Only simulators use it."""
    deploy: DeployTable = field(default_factory=DeployTable)
    """How the app runs, and how it is checked before."""
    is_package: bool = False
    """Whether pip can build and install the folder."""
    metadata: ProjectTable = field(default_factory=ProjectTable)

    @property
    def files(self) -> tuple[str, ...]:
        """The files of the app, the robot and the world with its picture, relative to the project's folder.

        Files of installed packages are left out. Raises the errors of `load_world`.
        """
        app = (self.app.partition(":")[0],) if is_app_file(self.app) else ()
        names = [name for name in (self.robot, self.world) if name and is_own(name)]
        picture = find_floor_image(self.resolve(self.world)) if self.world in names else None
        return (*app, *names, *((os.path.relpath(picture, self.folder),) if picture else ()))

    def load_description(self) -> RobotDescription:
        """Return the robot's description. Raises the errors of `load_robot`."""
        return load_robot(self.resolve(self.robot))

    def resolve(self, name: str) -> str:
        """Return the absolute path of a file of the project. Return an installed name unchanged."""
        return str(self.folder / name) if self.folder and _is_file(name) else name


def build_project(options: DeployOptions, here: Path | None = None) -> Project:
    """Return the project of a folder, with the options of the user applied.

    The folder is ``options.folder``, or else ``here``. If ``here`` has no ``pyproject.toml`` with a table
    ``[tool.robotcore]`` and the options name no file, the project has no folder. Its app, robot and world are then
    installed ones.

    >>> from pathlib import Path
    >>> from robotcore.deploy.project import DeployOptions
    >>> build_project(DeployOptions(app="green-search", robot="rover"), Path("/")).deploy.backend
    'raspberrypi'

    here: the folder to which file names in the options are relative; None for the current folder.
    Raises UsageError if a name is unknown or a file is outside of the folder. Raises DescriptionError if the
    ``pyproject.toml`` has mistakes.
    """
    here = (here or Path.cwd()).absolute()
    folder: Path | None = here / options.folder if options.folder else here
    assert folder
    if not folder.is_dir():
        raise UsageError(
            f"--project {options.folder}: there is no such folder. Name the folder of your {FILE}",
            kind="no-such-folder",
            folder=str(options.folder),
        )
    tables = read_tables(folder)
    table = tables.robotcore or RobotcoreTable()
    given = {kind: getattr(options, kind) for kind in ("app", "robot", "world")}
    if not (options.folder or tables.robotcore or any(name and _is_file(name) for name in given.values())):
        folder, tables = None, Tables()
    elif Path.home().resolve().is_relative_to(folder := folder.resolve()):
        raise UsageError(
            f"{escape(str(folder))} contains your home folder, and a push sends the whole folder. Make a folder for "
            "the project and put its files there: robotcore new",
            kind="home-folder",
        )
    names = {kind: name or getattr(table, kind) for kind, name in given.items()}
    for kind, name in names.items():
        if not name and kind != "world":
            raise UsageError(
                f'no {kind} is named. Name it with --{kind}, or in {FILE}: [tool.robotcore] {kind} = "…"',
                kind="missing-option",
                option=kind,
            )
        if name and folder and _is_file(name):
            names[kind] = resolve_file(folder, here if given[kind] else folder, name, kind)
    project = Project(
        folder=folder,
        name=tables.project.name or (folder.name if folder else app_name(names["app"])),
        **names,
        deploy=_apply_options(options, table.deploy),
        is_package=tables.is_package,
        metadata=tables.project,
    )
    _require_valid(project)
    return project


def _is_file(name: str) -> bool:
    return is_app_file(name) or is_own(name)


def _apply_options(options: DeployOptions, table: DeployTable) -> DeployTable:
    chosen = {key: getattr(options, key) for key in ("backend", "rate_hz", "seeds", "require", "record", "record_last")}
    changes: dict[str, Any] = {key: value for key, value in chosen.items() if value is not None}
    changes["settings"] = {**table.settings, **options.settings}
    changes["options"] = {**table.options, **options.options}
    if options.is_real_time:
        changes["rt"] = True
    if options.has_view and table.view is None:
        changes["view"] = DEFAULT_VIEW_PORT
    return table.model_copy(update=changes)


def _require_valid(project: Project) -> None:
    deploy = project.deploy
    require_rate(deploy.rate_hz)
    if deploy.rt:
        require_no_lockstep(load_backend(deploy.backend))
    load_backend(deploy.backend)
    if not is_app_file(project.app):  # a user's file is not imported here, so its settings are not checked
        if app_name(project.app) not in app_names():
            raise UnknownNameError("app", project.app, app_names())
        configure(load_app(project.app), deploy.settings)
    if not is_own(project.robot):
        load_robot(project.robot)
    if project.world and not is_own(project.world):
        load_world(project.world)
    parse_seeds(deploy.seeds)
    for bound in deploy.require:
        Requirement.parse(bound)
    try:
        _require_duration(deploy.record_last)
    except ValueError as error:
        text = f"--record-last {escape(deploy.record_last)}: {error.__cause__}, or {WHOLE_RUN}"
        raise UsageError(text, kind="record-last", record_last=deploy.record_last) from error
    known = {*(metadata("robotcore").get_all("Provides-Extra") or ()), *project.metadata.optional}
    for extra in deploy.extras:
        if extra not in known:
            raise UnknownNameError("extra", extra, sorted(known))
