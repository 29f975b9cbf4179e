"""A recording in memory, and the metadata of the run."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import datetime, timezone
from importlib.metadata import version
from typing import Any

from robotcore.description import RobotDescription, WorldDescription
from robotcore.recording.events import GroundTruthSample, RecordedSample, SampleKey, Tick
from robotcore.runtime.apps import app_path, is_app_file
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.versions import libraries

FORMAT = 1
"""The format of the files that this version writes. It reads this format and earlier ones."""


@dataclass(frozen=True)
class Metadata:
    """The description of a run: everything that running or replaying it needs, except an app from a user's file."""

    request: RunRequest
    description: RobotDescription
    """The robot as the run had it, drawn and randomised."""
    is_stepped: bool
    """Whether the clock waits for the app."""
    world: WorldDescription | None = None
    """The world as the run had it, drawn and randomised."""
    devices: tuple[str, ...] = ()
    """The names of the open devices."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """All settings of the app, with their values in the run."""
    milestones: tuple[str, ...] = ()
    """The milestones of the app."""
    platform: Mapping[str, str] = field(default_factory=dict)
    """The machine and the versions of the libraries, on which digests depend."""
    source: str | None = None
    """The text of an app from a user's file."""
    started: str = ""
    """The time of day at the start, ISO 8601."""
    format: int = FORMAT


@dataclass(frozen=True)
class Recording:
    """A recorded run."""

    metadata: Metadata
    ticks: Sequence[Tick]
    samples: Mapping[SampleKey, RecordedSample]
    """The samples of each device, and a Frame for each picture on a display.

    A sample equals that of the run, except for a compressed picture. Reading one may raise RecordingError.
    """
    result: RunResult | None = None
    """The result of the run; None if the file ends before the run did, or is damaged before the result."""
    truth: Sequence[GroundTruthSample] = ()
    """The ground truth; empty if no simulator provided it."""
    ended_early: str = ""
    """Why the recording ended before the run did, for example its size limit."""
    is_cut: bool = False
    """Whether the end of the file is missing, if only its index."""
    damage: str = ""
    """The place and the kind of the first damage, in a line. Nothing after it was read."""
    why_not: str = ""
    """Why the recording cannot be replayed; empty if it can."""

    def __repr__(self) -> str:
        request, outcome = self.metadata.request, self.result.outcome.value if self.result else "no result"
        return f"<Recording of {request.app} on {request.backend}: {len(self.ticks)} ticks, {outcome}>"

    @property
    def is_damaged(self) -> bool:
        return bool(self.damage)

    @property
    def is_replayable(self) -> bool:
        """Whether it has every input of the app up to its last tick."""
        return not self.why_not


def build_metadata(run: Run) -> Metadata:
    """Return the metadata of a run before its first tick."""
    request = run.request
    return Metadata(
        request=request,
        description=run.description,
        is_stepped=run.robot.clock.is_lockstep,
        world=run.world,
        devices=tuple(run.robot.devices),
        settings=_read_settings(run.behaviour),
        milestones=tuple(run.behaviour.milestones),
        platform=read_platform(request.backend),
        source=read_app_source(request.app),
        started=datetime.now(timezone.utc).isoformat(timespec="seconds"),
    )


def _read_settings(behaviour: Behaviour) -> dict[str, Any]:
    if not is_dataclass(behaviour):
        return {}
    return {field.name: getattr(behaviour, field.name, None) for field in fields(behaviour) if field.init}


def read_platform(backend: str) -> dict[str, str]:
    """Return the machine, the system and the libraries: everything that the bits of a run depend on."""
    machine = {"machine": platform.machine(), "system": platform.system(), "libc": " ".join(platform.libc_ver())}
    return {"robotcore": version("robotcore"), **machine, **libraries([backend])}


def read_app_source(app: str) -> str | None:
    """Return the current text of an app's file; None if the app is no file, or the file is missing."""
    if is_app_file(app):
        with suppress(OSError, UnicodeDecodeError):
            return app_path(app).read_text(encoding="utf-8")
    return None
