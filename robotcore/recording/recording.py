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
"""The file format that this version writes. This version also reads files of earlier formats."""


@dataclass(frozen=True)
class Metadata:
    """The description of a run. It is enough to run or replay the run, unless the app is a user's file."""

    request: RunRequest
    description: RobotDescription
    """The robot of the run, after the seed drew and randomised its values."""
    is_stepped: bool
    """Whether the clock waits for the app."""
    world: WorldDescription | None = None
    """The world of the run, after the seed drew and randomised its values."""
    devices: tuple[str, ...] = ()
    """The names of the devices that the run opened."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """All settings of the app, with their values in the run."""
    milestones: tuple[str, ...] = ()
    """The milestones of the app."""
    platform: Mapping[str, str] = field(default_factory=dict)
    """The machine and the versions of the libraries. The digests of a run depend on them."""
    source: str | None = None
    """The source text of an app from a user's file."""
    started: str = ""
    """The time of day at the start, ISO 8601."""
    format: int = FORMAT


@dataclass(frozen=True)
class Recording:
    """A recorded run."""

    metadata: Metadata
    ticks: Sequence[Tick]
    samples: Mapping[SampleKey, RecordedSample]
    """The samples of each device by key. Each picture on a display is a Frame.

    A sample equals that of the run, unless it is a compressed picture. Reading a picture may raise RecordingError.
    """
    result: RunResult | None = None
    """The result of the run; None if the file ends or is damaged before the result."""
    truth: Sequence[GroundTruthSample] = ()
    """The ground truth; empty if no simulator provided it."""
    ended_early: str = ""
    """Why the recording ended before the run did, for example its size limit."""
    is_cut: bool = False
    """Whether the end of the file is missing, even if only the index is missing."""
    damage: str = ""
    """The place and the kind of the first damage, in one line. The file was not read beyond it."""
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
        """Whether the recording has every input of the app up to its last tick."""
        return not self.why_not


def build_metadata(run: Run) -> Metadata:
    """Return the metadata of a run. It must be called before the first tick."""
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
    """Return the machine, the system and the versions of the libraries. The exact numbers of a run depend on them."""
    machine = {"machine": platform.machine(), "system": platform.system(), "libc": " ".join(platform.libc_ver())}
    return {"robotcore": version("robotcore"), **machine, **libraries([backend])}


def read_app_source(app: str) -> str | None:
    """Return the current text of an app's file; None if the app is not a file, or if the file is missing."""
    if is_app_file(app):
        with suppress(OSError, UnicodeDecodeError):
            return app_path(app).read_text(encoding="utf-8")
    return None
