"""The answers of a robot: a model for each action, and functions that parse and validate an answer.

The client does not trust a robot: an attacker may control it, or another machine may use its name. Each answer is
validated here, and every string in it is escaped, before any other code of the client uses it.
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

MOST_ITEMS = 100_000
"""The most items that a list in a robot's answer may have."""

AnswerT = TypeVar("AnswerT", bound="Answer")


def _require_remote_folder(path: str) -> str:
    if not REMOTE_FOLDER.fullmatch(path):
        raise ValueError("is not a folder of the robot")
    return path


def _reject_broken(kind: str) -> str:
    if kind == BROKEN:
        raise ValueError("is a kind that only the client gives")
    return kind


ReleaseName = Annotated[str, AfterValidator(require_name)]
RemoteFolder = Annotated[str, AfterValidator(_require_remote_folder)]
Count = Annotated[int, Field(ge=0, lt=1 << 63)]
Texts = Annotated[list[str], Field(max_length=MOST_ITEMS)]
Version = Annotated[str, StringConstraints(pattern=r"^\d{1,2}\.\d{1,3}\.\d{1,3}(?:(?:a|b|rc)\d{1,3})?\+?$")]
LibcVersion = Annotated[str, StringConstraints(pattern=r"^(?:\d{1,3}(?:\.\d{1,3}){1,3})?$")]
Machine = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_.-]{0,40}$")]


class Answer(BaseModel):
    """The base class of the messages of a robot. Keys that the model does not have are ignored."""

    model_config = ConfigDict(strict=True, frozen=True, extra="ignore", allow_inf_nan=False)


class Notice(Answer):
    """The progress of an action."""

    say: str
    """A text on what the action is doing now."""
    release: ReleaseName | None = None
    """The release that the robot chose, if it chose one."""


class Refusal(Answer):
    """A robot's answer if it did not do an action."""

    fault: str
    """What happened, without a full stop."""
    remedy: str
    """What to do about it, without a full stop."""
    kind: Annotated[str, AfterValidator(_reject_broken)] = ""
    """The kind of the DeployError that the client raises."""


class EmptyAnswer(Answer):
    """The answer of an action that has nothing to return."""


class ProbeAnswer(Answer):
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


class BeginAnswer(Answer):
    """The answer of ``begin``: the place of the upload. Folders are relative to ``~/robotcore``."""

    release: ReleaseName
    """The name that the robot gave the release."""
    to: RemoteFolder
    """The folder that receives the upload."""
    copy_from: RemoteFolder | None
    """The folder of an earlier release. Files that are equal to those in it are copied on the robot instead of sent."""


class Finding(Answer):
    """A finding of the doctor on a robot."""

    level: str
    """``ok``, ``warning`` or ``error``."""
    what: str
    """The part of the robot that the doctor examined."""
    said: str
    """What the doctor found."""
    remedy: str
    """What to do about it; empty if there is nothing to do."""


class InstallAnswer(Answer):
    """The answer of ``install``."""

    environment: str
    """``kept`` if an environment with these requirements existed, else ``made``."""
    findings: Annotated[list[Finding], Field(max_length=MOST_ITEMS)]
    """The findings of the doctor."""


class HealthResult(Answer):
    """The answer of ``activate`` and ``rollback``: the result of a health check, and the state after it."""

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
    is_standing: bool
    """Whether the current release is stopped, as it was before the check."""


class LastRelease(Answer):
    """The newest release that was checked. The answer has it only if no release is current."""

    name: ReleaseName
    outcome: str
    reason: str


class RecordingsSummary(Answer):
    """The number of recordings on a robot, and their size."""

    files: Count
    bytes: Count


class State(Answer):
    """The answer of ``status``, ``start`` and ``stop``: the state of the app and of the robot."""

    release: ReleaseName | None
    """The current release."""
    verdict: str | None
    """The outcome of the last health check of the current release."""
    on_trial: ReleaseName | None
    """The release whose health check is not complete."""
    last: LastRelease | None
    state: str
    """``running``, ``starting``, ``stopping``, ``restarting``, ``ended``, ``failed`` or ``stopped``."""
    for_s: Annotated[float, Field(ge=0, le=1e10)] | None
    """How long the app has been running, in s; None if it does not run."""
    restarts: Count
    """The number of times that systemd has restarted the app after a failure."""
    words: str
    """The last status text of the app."""
    reason: str
    """The failure after which the app ended or was restarted; empty if there was none."""
    lines: Texts
    """The last lines of the app's output before that failure."""
    starts_with_robot: bool
    lingers: bool
    """Whether the user's services run without a login."""
    recordings: RecordingsSummary
    free_bytes: Count


class UnreadableRelease(Answer):
    """A release whose manifest cannot be read."""

    name: ReleaseName
    unreadable: str
    """Why the manifest cannot be read."""
    verdict: str | None
    reason: str


class ListedRelease(Answer):
    """A release: the fields of its manifest, see `agent.releases.Release`, and the result of its last health check."""

    name: ReleaseName
    project: str
    app: str
    robot: str
    backend: str
    run: Texts
    stop: Texts
    requirements: Texts
    gates: Texts
    """A line on the result of each check before the push."""
    robotcore: str
    revision: str
    sender: str
    is_recorded: bool
    verdict: str | None
    reason: str


class Releases(Answer):
    """The answer of ``releases``: the releases on the robot, the newest first."""

    releases: Annotated[list[UnreadableRelease | ListedRelease], Field(max_length=MOST_ITEMS)]
    current: ReleaseName | None
    on_trial: ReleaseName | None


class RemoveAnswer(Answer):
    """The answer of ``remove``."""

    kept: bool
    """Whether recordings are still on the robot."""


class RemoteFile(Answer):
    """A file, a link or a folder among the recordings of a robot. The client decides whether it is a recording."""

    name: str
    bytes: Count
    is_file: bool
    is_being_written: bool


class Recordings(Answer):
    """The answer of ``recordings``: the entries of the robot's folder of recordings."""

    recordings: Annotated[list[RemoteFile], Field(max_length=MOST_ITEMS)]


class EraseAnswer(Answer):
    """The answer of ``erase``."""

    erased: Texts
    """The recordings that the robot deleted."""
    different: Texts
    """The recordings whose content on the robot differs from that of the client's copy."""


def parse(line: bytes) -> dict[str, Any]:
    """Return the JSON object in a line that a robot sent. Control characters in its strings are escaped.

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
    """Return data of a robot as an object of a model, after validation.

    where: the name of the data. In an error message, the key of the wrong value begins with it.
    Raises MalformedError, whose message has the first wrong key and what is wrong with it.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        problem = error.errors(include_url=False, include_context=False, include_input=False)[0]
        key = ".".join(map(str, (where, *problem["loc"])))
        raise MalformedError(f"has an error at {key}: {problem['msg']}") from error


def _escape_strings(value: Any) -> Any:
    if isinstance(value, str):
        return escape(value)
    if isinstance(value, list):
        return [_escape_strings(each) for each in value]
    if isinstance(value, dict):
        return {key: _escape_strings(each) for key, each in value.items()}
    return value
