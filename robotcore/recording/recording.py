"""A recording in memory, and the metadata of the run."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import datetime, timezone
from typing import Any

from robotcore.compatibility import PACKAGE, read_version
from robotcore.description import RobotDescription, WorldDescription
from robotcore.hal.device import Sample
from robotcore.hal.value_log import LoggedValue
from robotcore.recording.events import GroundTruthSample, SampleKey, Tick
from robotcore.runtime.apps import app_path, is_app_file
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext
from robotcore.runtime.versions import libraries

FORMAT = 1
"""The number of the file format that this version of robotcore writes."""


@dataclass(frozen=True)
class Metadata:
    """The request, robot, world and app of a recorded run.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> metadata = recording.metadata
    >>> metadata.request.app_reference, metadata.description.name, metadata.world.name, metadata.devices
    ('avoid-obstacles', 'rover', 'arena', ('left_motor', 'right_motor', 'left_encoder', 'right_encoder', 'nose'))
    """

    request: RunRequest
    description: RobotDescription
    """The robot of the run, with the values that were randomised by the seed."""
    is_stepped: bool
    """Whether the clock is stepped: it waits for the app, as a simulator's clock does."""
    world: WorldDescription | None = None
    """The world of the run, with the values that were randomised by the seed; None without a world."""
    devices: tuple[str, ...] = ()
    """The names of the devices that the run opened."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """The value of each setting of the app in the run, by name."""
    milestones: tuple[str, ...] = ()
    """The names of the app's milestones."""
    platform: Mapping[str, str] = field(default_factory=dict)
    """The machine, the system and the versions of libraries. The numbers of a run depend on them."""
    source: str | None = None
    """The source text of the app if it is a user's file, else None."""
    started: str = ""
    """The date and time of the start in UTC, as ISO 8601."""
    format: int = FORMAT


@dataclass(frozen=True)
class Recording:
    """A recorded run in memory. Pictures are read from the file when they are used.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> recording
    <Recording of avoid-obstacles on kinematic: 11 ticks, timeout>
    >>> recording.result.outcome.value, recording.ticks[-1].time, recording.is_replayable
    ('timeout', 0.5, True)
    >>> sorted({key.device for key in recording.samples})
    ['left_encoder', 'nose', 'right_encoder']
    """

    metadata: Metadata
    ticks: Sequence[Tick]
    samples: Mapping[SampleKey, Sample]
    """The recorded samples, and the pictures on displays as frames.

    A JPEG differs from the picture of the run. Getting a picture raises RecordingError if the file is damaged there.
    """
    result: RunResult | None = None
    """The result of the run; None if the file is cut or damaged before the result."""
    truth: Sequence[GroundTruthSample] = ()
    """The ground truth after each tick; empty if no simulator measured it."""
    logged: Mapping[int, Mapping[str, LoggedValue]] = field(default_factory=dict)
    """The values that the app logged, by the number of the tick and by name. A tick without a value has no entry."""
    printed: Mapping[int, Sequence[str]] = field(default_factory=dict)
    """The lines that the app printed, by the number of the tick. A tick without a line has no entry."""
    ended_early: str = ""
    """Why the recording ended before its run, such as its size limit; empty if it did not."""
    is_cut: bool = False
    """Whether the end of the file is missing: the result, or the index after it."""
    damage: str = ""
    """The first damage of the file, with its place; empty if there is none. Nothing after it was read."""
    missing_inputs: str = ""
    """Which inputs of the app are missing, so that the recording cannot be replayed; empty if none is missing."""

    def __repr__(self) -> str:
        request, outcome = self.metadata.request, self.result.outcome.value if self.result else "no result"
        return f"<Recording of {request.app_reference} on {request.backend}: {len(self.ticks)} ticks, {outcome}>"

    @property
    def is_damaged(self) -> bool:
        return bool(self.damage)

    @property
    def is_replayable(self) -> bool:
        """Whether the recording has every input of the app."""
        return not self.missing_inputs


def build_metadata(run: RunContext) -> Metadata:
    """Return the metadata of a run that has not begun its first tick."""
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
        source=read_app_source(request.app_reference),
        started=datetime.now(timezone.utc).isoformat(timespec="seconds"),
    )


def _read_settings(behaviour: Behaviour) -> dict[str, Any]:
    if not is_dataclass(behaviour):
        return {}
    return {field.name: getattr(behaviour, field.name, None) for field in fields(behaviour) if field.init}


def read_platform(backend: str) -> dict[str, str]:
    """Return the names of this machine and system, and the versions of the libraries of a backend."""
    machine = {"machine": platform.machine(), "system": platform.system(), "libc": " ".join(platform.libc_ver())}
    return {PACKAGE: read_version(), **machine, **libraries([backend])}


def read_app_source(app: str) -> str | None:
    """Return the text of an app's file; None if the app is not a file or the file cannot be read."""
    if is_app_file(app):
        with suppress(OSError, UnicodeDecodeError):
            return app_path(app).read_text(encoding="utf-8")
    return None
