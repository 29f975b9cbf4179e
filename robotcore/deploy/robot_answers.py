"""The answers of a robot: a model for each action, and functions that parse and validate an answer.

An attacker may control a robot. So this module escapes every string of an answer and
validates the answer before other code of the client uses it.
"""

from __future__ import annotations

import json
import re
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from robotcore.deploy.agent.releases import require_name
from robotcore.deploy.errors import BROKEN
from robotcore.deploy.process_output import MalformedError
from robotcore.text import escape

REMOTE_FOLDER = re.compile(r"\w[\w.-]*(?:/\w[\w.-]*)*", re.ASCII)
"""The pattern of a folder below ``~/robotcore``, without characters that a shell interprets and without ``..``."""

MAX_ITEMS = 100_000
"""The greatest number of items of a list in a robot's answer."""

MAX_PROBLEM_LENGTH = 200
"""The greatest length of a problem in an error message. A problem may quote a value of any length."""

AnswerT = TypeVar("AnswerT", bound="RobotMessage")


def require_remote_folder(path: str) -> str:
    """Return the path of a folder below ``~/robotcore`` if it matches `REMOTE_FOLDER`, else raise ValueError."""
    if not REMOTE_FOLDER.fullmatch(path):
        raise ValueError(f"{path!r} is not a folder of the robot")
    return path


def _reject_broken(kind: str) -> str:
    if kind == BROKEN:
        raise ValueError("is a kind that only the client gives")
    return kind


ReleaseName = Annotated[str, AfterValidator(require_name)]
RemoteFolder = Annotated[str, AfterValidator(require_remote_folder)]
Count = Annotated[int, Field(ge=0, lt=1 << 63)]
Port = Annotated[int, Field(gt=0, lt=1 << 16)]
Texts = Annotated[list[str], Field(max_length=MAX_ITEMS)]
Version = Annotated[str, StringConstraints(pattern=r"^\d{1,2}\.\d{1,3}\.\d{1,3}(?:(?:a|b|rc)\d{1,3})?\+?$")]
LibcVersion = Annotated[str, StringConstraints(pattern=r"^(?:\d{1,3}(?:\.\d{1,3}){1,3})?$")]
Machine = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_.-]{0,40}$")]


class RobotMessage(BaseModel):
    """The base class of a robot's messages. Keys without a field are ignored."""

    model_config = ConfigDict(strict=True, frozen=True, extra="ignore", allow_inf_nan=False)


class ProgressMessage(RobotMessage):
    """The progress of an action on the robot."""

    text: str
    """What the action is doing now, in words."""
    release: ReleaseName | None = None
    """The name that the robot gave the release; None if this message does not have it."""


class Refusal(RobotMessage):
    """The answer of a robot that cannot do an action."""

    problem: str
    """The cause, without a full stop."""
    remedy: str
    """What the user can do, without a full stop."""
    kind: Annotated[str, AfterValidator(_reject_broken)] = ""
    """The kind of the DeployError that the client raises."""


class EmptyAnswer(RobotMessage):
    """The answer of an action that returns nothing."""


class ProbeAnswer(RobotMessage):
    """The answer of ``probe``: the facts about a robot that decide whether a release can run on it."""

    host: str
    """The robot's own host name."""
    machine: Machine
    """The processor, such as ``aarch64``."""
    system: str
    """The operating system, such as ``Debian GNU/Linux 12 (bookworm)``."""
    python: Version
    libc: str
    """The C library, such as ``glibc``."""
    libc_version: LibcVersion
    free_bytes: Count
    has_environment: bool
    """Whether an environment with the release's requirements exists already."""


class BeginAnswer(RobotMessage):
    """The answer of ``begin``: the folder of the upload. Folders are relative to ``~/robotcore``."""

    release: ReleaseName
    """The name that the robot gave the release."""
    to: RemoteFolder
    """The folder that receives the upload."""
    copy_from: RemoteFolder | None
    """The folder of an earlier release. A file that is equal to one in it is copied on the robot instead of sent."""


class FindingMessage(RobotMessage):
    """A finding of ``robotcore doctor`` on a robot."""

    level: str
    """``ok``, ``warning`` or ``error``."""
    subject: str
    """The examined part of the robot, such as ``disk``."""
    message: str
    """The state of that part, in words."""
    remedy: str
    """What the user can do; empty if the level is ``ok``."""


class InstallAnswer(RobotMessage):
    """The answer of ``install``."""

    environment: str
    """``kept`` if the robot had an environment with the release's requirements, else ``made``."""
    findings: Annotated[list[FindingMessage], Field(max_length=MAX_ITEMS)]


class HealthAnswer(RobotMessage):
    """The answer of ``activate`` and ``rollback``: the result of a health check, and the robot's state after it."""

    release: ReleaseName
    """The release that was checked."""
    outcome: str
    """``healthy``, ``unhealthy`` or ``stopped``."""
    reason: str
    lines: Texts
    """The last lines of the app's output, if it failed."""
    current: ReleaseName | None
    """The current release after the check."""
    is_running: bool
    """Whether the current release runs."""
    is_stopped: bool
    """Whether the app is stopped after the check, without a failure."""


class LastRelease(RobotMessage):
    """The newest release with a completed health check."""

    name: ReleaseName
    """The name of the release."""
    outcome: str
    """The outcome of its health check: ``healthy``, ``unhealthy`` or ``stopped``."""
    reason: str
    """Why it is not healthy; empty if it is."""


class RecordingsSummary(RobotMessage):
    """The number of recordings on a robot, and their size."""

    files: Count
    """The number of files."""
    bytes: Count
    """Their size in bytes."""


class StatusAnswer(RobotMessage):
    """The answer of ``status``, ``start`` and ``stop``: the state of the app and of the robot."""

    release: ReleaseName | None
    """The current release."""
    outcome: str | None
    """The outcome of the current release's last health check."""
    pending: ReleaseName | None
    """The release whose health check is pending or running."""
    last: LastRelease | None
    """The newest release with a completed health check; None if a release is current, or without such a check."""
    state: str
    """``running``, ``starting``, ``stopping``, ``restarting``, ``ended``, ``failed`` or ``stopped``."""
    for_s: Annotated[float, Field(ge=0, le=1e10)] | None
    """How long the app has been running, in s; None if it does not run."""
    restarts: Count
    """The number of times that systemd has restarted the app after a failure."""
    status_text: str
    """The last status text of the app."""
    view_port: Port | None
    """The port of the robot's 127.0.0.1 at which the current release has its live page; None without a page."""
    reason: str
    """The cause of the app's last failure; empty without a failure."""
    lines: Texts
    """The last lines of the app's output before its last failure."""
    starts_with_robot: bool
    """Whether the app starts when the robot is switched on."""
    lingers: bool
    """Whether the user's services run without a login."""
    recordings: RecordingsSummary
    """The recordings on the robot."""
    free_bytes: Count
    """The free space of the robot's disk in bytes."""


class UnreadableRelease(RobotMessage):
    """A release whose manifest cannot be read."""

    name: ReleaseName
    unreadable: str
    """Why the manifest cannot be read. Only such a release has this key, and it lacks those of the manifest."""
    outcome: str | None
    """The outcome of the last health check: ``healthy``, ``unhealthy`` or ``stopped``; None before it."""
    reason: str
    """Why the release is not healthy; empty if it is."""


class ListedRelease(RobotMessage):
    """A release: the fields of its manifest (`agent.releases.Release`), and the result of its last health check."""

    name: ReleaseName
    project: str
    app: str
    robot: str
    backend: str
    run: Texts
    stop: Texts
    requirements: Texts
    checks: Texts
    """A line for each check before the push, with its result."""
    robotcore: str
    revision: str
    sender: str
    is_recorded: bool
    record_last: str
    view_port: Port | None = None
    outcome: str | None
    reason: str


class ReleasesAnswer(RobotMessage):
    """The answer of ``releases``: the releases on the robot, the newest first."""

    releases: Annotated[list[UnreadableRelease | ListedRelease], Field(max_length=MAX_ITEMS)]
    current: ReleaseName | None
    """The name of the current release."""
    pending: ReleaseName | None
    """The name of the release whose health check is pending or running."""


class RemoveAnswer(RobotMessage):
    """The answer of ``remove``."""

    has_recordings: bool
    """Whether recordings are still on the robot."""


class RemoteFile(RobotMessage):
    """A file, a link or a folder among the recordings of a robot. The client decides whether it is a recording."""

    name: str
    bytes: Count
    is_file: bool
    is_being_written: bool


class RecordingsAnswer(RobotMessage):
    """The answer of ``recordings``: the files, links and folders in the robot's folder of recordings."""

    recordings: Annotated[list[RemoteFile], Field(max_length=MAX_ITEMS)]


class EraseAnswer(RobotMessage):
    """The answer of ``erase``."""

    erased: Texts
    """The recordings that the robot deleted."""
    different: Texts
    """The recordings whose content on the robot differs from the client's copy."""


def parse(line: bytes) -> dict[str, Any]:
    """Return the JSON object in a line of a robot's output. Control characters in its strings are escaped.

    Raises MalformedError if the line is not a JSON object.
    """
    try:
        message = _escape_strings(json.loads(line.decode()))
    except RecursionError:
        raise MalformedError("is nested too deep") from None
    except ValueError as error:
        raise MalformedError("is not JSON") from error
    if not isinstance(message, dict):
        raise MalformedError("is not a JSON object")
    return message


def validate(model: type[AnswerT], data: Any, where: str) -> AnswerT:
    """Return the data of a robot as an object of a model, after validation.

    where: the key of the data in the message of the robot. The error message names it.
    Raises MalformedError for the first invalid value.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        problem = error.errors(include_url=False, include_context=False, include_input=False)[0]
        key = ".".join(map(str, (where, *problem["loc"])))
        raise MalformedError(f"has an error at {key}: {problem['msg'][:MAX_PROBLEM_LENGTH]}") from error


def _escape_strings(value: Any) -> Any:
    if isinstance(value, str):
        return escape(value)
    if isinstance(value, list):
        return [_escape_strings(each) for each in value]
    if isinstance(value, dict):
        return {key: _escape_strings(each) for key, each in value.items()}
    return value
