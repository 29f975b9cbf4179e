"""The answers of a robot: a model for each action, and the functions that parse and validate a line.

The desk does not trust a robot: it may be broken into, or another machine may use its name. Each answer is validated
here, and every string in it is escaped, before any other code of the desk uses it.
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
"""A folder below the robot's own: a shell sees a plain name in it, and it leads nowhere else."""

MOST_ITEMS = 100_000
"""The most items of a list that a robot sends."""

AnswerT = TypeVar("AnswerT", bound="Answer")


def _require_remote_folder(path: str) -> str:
    if not REMOTE_FOLDER.fullmatch(path):
        raise ValueError("is not a folder of the robot")
    return path


def _reject_broken(kind: str) -> str:
    if kind == BROKEN:
        raise ValueError("is a kind that only the desk gives")
    return kind


ReleaseName = Annotated[str, AfterValidator(require_name)]
RemoteFolder = Annotated[str, AfterValidator(_require_remote_folder)]
Count = Annotated[int, Field(ge=0, lt=1 << 63)]
Texts = Annotated[list[str], Field(max_length=MOST_ITEMS)]
Version = Annotated[str, StringConstraints(pattern=r"^\d{1,2}\.\d{1,3}\.\d{1,3}(?:(?:a|b|rc)\d{1,3})?\+?$")]
LibcVersion = Annotated[str, StringConstraints(pattern=r"^(?:\d{1,3}(?:\.\d{1,3}){1,3})?$")]
Machine = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_.-]{0,40}$")]


class Answer(BaseModel):
    """A message of a robot. A key that is unknown here is ignored."""

    model_config = ConfigDict(strict=True, frozen=True, extra="ignore", allow_inf_nan=False)


class Notice(Answer):
    """Words on how far an action is; ``release`` names the one that the robot chose."""

    say: str
    release: ReleaseName | None = None


class Refusal(Answer):
    """Why an action was not done, what to do, and a word for the desk."""

    fault: str
    remedy: str
    kind: Annotated[str, AfterValidator(_reject_broken)] = ""


class EmptyAnswer(Answer):
    """The answer of an action that has nothing to return."""


class ProbeAnswer(Answer):
    """The answer of ``probe``: what the desk has to know of a robot before it sends a release."""

    host: str
    machine: Machine
    system: str
    python: Version
    libc: str
    libc_version: LibcVersion
    free_bytes: Count
    has_environment: bool


class BeginAnswer(Answer):
    """The answer of ``begin``: the name of the release, the folder to send to, and the folder to copy from."""

    release: ReleaseName
    to: RemoteFolder
    copy_from: RemoteFolder | None


class Finding(Answer):
    """What the doctor of a robot found."""

    level: str
    what: str
    said: str
    remedy: str


class InstallAnswer(Answer):
    """The answer of ``install``: whether the environment was kept or made, and what the doctor found."""

    environment: str
    findings: Annotated[list[Finding], Field(max_length=MOST_ITEMS)]


class HealthResult(Answer):
    """The answer of ``activate`` and ``rollback``: how a release did on trial, and what runs now."""

    release: ReleaseName
    outcome: str
    reason: str
    lines: Texts
    current: ReleaseName | None
    is_running: bool
    is_standing: bool


class LastRelease(Answer):
    """The newest release that was tried, if no release is in place."""

    name: ReleaseName
    outcome: str
    reason: str


class RecordingsSummary(Answer):
    """How many recordings are on a robot, and their size."""

    files: Count
    bytes: Count


class State(Answer):
    """The answer of ``status``, ``start`` and ``stop``: which release runs, and how."""

    release: ReleaseName | None
    verdict: str | None
    on_trial: ReleaseName | None
    last: LastRelease | None
    state: str
    for_s: Annotated[float, Field(ge=0, le=1e10)] | None
    restarts: Count
    words: str
    reason: str
    lines: Texts
    starts_with_robot: bool
    lingers: bool
    recordings: RecordingsSummary
    free_bytes: Count


class UnreadableRelease(Answer):
    """A release whose file cannot be read, and why."""

    name: ReleaseName
    unreadable: str
    verdict: str | None
    reason: str


class ListedRelease(Answer):
    """A release as its file describes it, with the verdict of its last trial."""

    name: ReleaseName
    project: str
    app: str
    robot: str
    backend: str
    run: Texts
    stop: Texts
    requirements: Texts
    gates: Texts
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
    """The answer of ``remove``: whether recordings are still on the robot."""

    kept: bool


class RemoteFile(Answer):
    """A file, a link or a folder among the recordings of a robot. The desk decides whether it is a recording."""

    name: str
    bytes: Count
    is_file: bool
    is_being_written: bool


class Recordings(Answer):
    """The answer of ``recordings``: what is in the robot's folder of recordings."""

    recordings: Annotated[list[RemoteFile], Field(max_length=MOST_ITEMS)]


class EraseAnswer(Answer):
    """The answer of ``erase``: the recordings that it deleted, and those that have other content on the robot."""

    erased: Texts
    different: Texts


def parse(line: bytes) -> dict[str, Any]:
    """Return the JSON object in a line of a robot, with every string in it escaped; raises MalformedError."""
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
    """Return the model of a robot's data; raises MalformedError with the first problem and its key."""
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
