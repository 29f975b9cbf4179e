"""What a run was: told by the run itself, kept in its recording."""

from __future__ import annotations

import platform
from contextlib import suppress
from dataclasses import fields, is_dataclass
from datetime import datetime, timezone
from importlib.metadata import version
from typing import Any

from robotcore.recording.recording import Metadata
from robotcore.runtime.apps import app_path, is_app_file
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.session import Run
from robotcore.runtime.versions import libraries


def metadata_of(run: Run) -> Metadata:
    """Return what is told of a run before its first tick."""
    request = run.request
    return Metadata(
        request=request,
        description=run.description,
        is_stepped=run.robot.clock.is_lockstep,
        world=run.world,
        devices=tuple(run.robot.devices),
        settings=_settings(run.behaviour),
        milestones=tuple(run.behaviour.milestones),
        platform=platform_of(request.backend),
        source=source_of(request.app),
        started=datetime.now(timezone.utc).isoformat(timespec="seconds"),
    )


def _settings(behaviour: Behaviour) -> dict[str, Any]:
    if not is_dataclass(behaviour):
        return {}
    return {field.name: getattr(behaviour, field.name, None) for field in fields(behaviour) if field.init}


def platform_of(backend: str) -> dict[str, str]:
    """Return all that the bits of a run depend on: machine, system, libraries."""
    machine = {"machine": platform.machine(), "system": platform.system(), "libc": " ".join(platform.libc_ver())}
    return {"robotcore": version("robotcore"), **machine, **libraries([backend])}


def source_of(app: str) -> str | None:
    """Return the text of an app that is a user's own file, as it is now; None where it is none, or is not there."""
    if is_app_file(app):
        with suppress(OSError, UnicodeDecodeError):
            return app_path(app).read_text(encoding="utf-8")
    return None
