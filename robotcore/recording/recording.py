"""A recording read back, whatever it was read from."""

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
"""Of the files that this version writes; it reads those up to it."""


@dataclass(frozen=True)
class Metadata:
    """What was run, on what: enough to run or replay it without any file of the user's but the app's.

    ``request`` is what was asked for; ``settings`` all settings of the app as they were, ``milestones`` its own.
    ``description`` and ``world`` are as the run had them, drawn and randomised. ``devices`` are the names of those that
    were open. ``platform`` tells versions and machine, on which digests depend. ``source`` is the text of an app that
    was a user's own file; ``started`` the time of day, ISO 8601.
    """

    request: RunRequest
    description: RobotDescription
    is_stepped: bool
    world: WorldDescription | None = None
    devices: tuple[str, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    milestones: tuple[str, ...] = ()
    platform: Mapping[str, str] = field(default_factory=dict)
    source: str | None = None
    started: str = ""
    format: int = FORMAT


@dataclass(frozen=True)
class Recording:
    """A run as it was recorded.

    ``samples`` has what each device gave, a Frame too for what was shown on a display: as the run had it, but for
    pictures that were compressed. It may read them when asked, and then raises RecordingError where the file fails.
    ``truth`` is empty where no simulator vouched for it. ``result`` is None where the file ends before the run did,
    or is damaged before that; ``is_cut`` is so too where only its index is missing. ``ended_early`` says why it ends
    before the run did all the same, for example at its size limit. ``damage`` says where it is damaged and how, in a
    line. What comes after that was not read.
    """

    metadata: Metadata
    ticks: Sequence[Tick]
    samples: Mapping[SampleKey, RecordedSample]
    result: RunResult | None = None
    truth: Sequence[GroundTruthSample] = ()
    ended_early: str = ""
    is_cut: bool = False
    damage: str = ""
    why_not: str = ""

    @property
    def is_damaged(self) -> bool:
        return bool(self.damage)

    @property
    def is_replayable(self) -> bool:
        """Whether it holds all that steered the run, up to its last tick; ``why_not`` says what is missing."""
        return not self.why_not


def build_metadata(run: Run) -> Metadata:
    """Return what is told of a run before its first tick."""
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
    """Return all that the bits of a run depend on: machine, system, libraries."""
    machine = {"machine": platform.machine(), "system": platform.system(), "libc": " ".join(platform.libc_ver())}
    return {"robotcore": version("robotcore"), **machine, **libraries([backend])}


def read_app_source(app: str) -> str | None:
    """Return the text of an app that is a user's own file, as it is now; None where it is none, or is not there."""
    if is_app_file(app):
        with suppress(OSError, UnicodeDecodeError):
            return app_path(app).read_text(encoding="utf-8")
    return None
