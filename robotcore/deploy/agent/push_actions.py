"""Actions of a push: probe the robot, begin an upload, install a release, discard an upload."""

from __future__ import annotations

import os
import time
from calendar import timegm
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from robotcore.deploy.agent import doctor, environments, files, health_check, releases, robot_facts, uploads
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.lock import hold_lock
from robotcore.deploy.agent.releases import (
    ENVIRONMENT,
    NAME_FORMAT,
    NAME_PATTERN,
    PROJECT,
    SITE,
    WHEELS,
    Release,
    require_name,
)
from robotcore.deploy.agent.robot_facts import collect_facts
from robotcore.deploy.agent.rpc import AgentError, report_progress
from robotcore.deploy.agent.uploads import discard


def probe(layout: Layout, *, requirements: Sequence[str] = (), is_push: bool = False) -> dict[str, Any]:
    """Return the facts, the current ``release``, and whether requirements have an environment (``has_environment``).

    For a push, a robot that cannot take one is refused, with what to do.
    """
    told = {**collect_facts(layout), "release": releases.read_current(layout)}
    told["has_environment"] = (
        environments.find_environment(layout, environments.EnvironmentSpec.of(requirements)) is not None
    )
    if is_push:
        robot_facts.require_push_needs(told, has_environment=told["has_environment"])
        told.update(is_lingering=True, has_user_manager=True)
    return told


SPARE_BYTES = 100_000_000
"""Bytes that stay free: with none the system itself stops working."""


def begin_upload(layout: Layout, *, release: str, size: int) -> dict[str, Any]:
    """Make room for so many bytes; return the ``release``'s name, where it goes (``to``), and the folder to copy from.

    It is named as the desk asks for, by the time there, or by the second after the newest that is here: no two pushes
    share a name, and names sort in the order of pushing, whatever a desk's clock tells. Both folders are below the
    robot's own folder; ``copy_from`` is None where there is none. Raises RefusalError where there is too little room,
    though what nobody needs was thrown away; then nothing is left of this push.
    """
    with hold_lock(layout, f"push of {require_name(release)}"):
        for room in (layout.incoming, layout.releases, layout.recordings):
            room.mkdir(parents=True, exist_ok=True)
        prune_releases(layout, keep=1 if _measure_missing(layout, size) else KEPT_HEALTHY)
        release = _choose_name(layout, release)
        folder = uploads.open_upload(layout, release)
        if short := _measure_missing(layout, size - files.measure_size(folder)):
            uploads.discard_upload(layout, release)
            raise _build_disk_error(layout, size, short)
        before = releases.read_current(layout) or next(iter(releases.list_names(layout)), None)
    return {"release": release, "to": f"incoming/{release}", "copy_from": f"releases/{before}" if before else None}


def _choose_name(layout: Layout, asked: str) -> str:
    there = [
        *releases.list_names(layout),
        *(path.name for path in layout.incoming.glob("*") if NAME_PATTERN.fullmatch(path.name)),
    ]
    newest = max(there, default="")
    return (
        asked
        if asked > newest
        else time.strftime(NAME_FORMAT, time.gmtime(timegm(time.strptime(newest, NAME_FORMAT)) + 1))
    )


def _measure_missing(layout: Layout, size: int) -> int:
    """Return how many bytes are missing."""
    return max(0, size + SPARE_BYTES - files.measure_free_space(layout.root))


def _build_disk_error(layout: Layout, size: int, short: int) -> AgentError:
    recorded = files.measure_size(layout.recordings)
    fault = (
        f"the robot's disk is full: {files.format_bytes(size)} are to be sent, {files.format_bytes(short)} are missing"
    )
    take = f"recordings take {files.format_bytes(recorded)}; robotcore deploy fetch --move takes them home"
    remedy = f"Make room there: {take if recorded else 'what takes it is told by df -h and du -xh ~ | sort -h'}"
    return AgentError(fault, remedy, "disk", size=size, missing=short, recorded=recorded)


KEPT_HEALTHY, KEPT_OTHERS = 5, 2
"""So many healthy releases stay, and so many others, to be looked at: what fails pushes out nothing that lives."""


def prune_releases(layout: Layout, keep: int = KEPT_HEALTHY) -> tuple[str, ...]:
    """Throw away all but the newest releases and those that are needed, and environments nobody uses; return which.

    The caller holds the lock.
    """
    healthy = [name for name in releases.list_names(layout) if releases.is_healthy(layout, name)]
    others = [name for name in releases.list_names(layout) if name not in healthy]
    stay = {*healthy[:keep], *others[: min(keep, KEPT_OTHERS)], *_list_needed(layout)}
    old = [name for name in releases.list_names(layout) if name not in stay]
    for name in old:
        discard(layout, layout.releases / name)
    environments.discard_unused(layout)
    return tuple(old)


def _list_needed(layout: Layout) -> Iterator[str | None]:
    """Yield the release that runs, the healthy one to go back to from it, and those that a trial is about."""
    yield releases.read_current(layout)
    yield releases.find_previous(layout)
    if tried := health_check.read_pending(layout):
        yield from (tried.release, tried.previous)


def install_release(layout: Layout, *, release: str, is_offline: bool = False) -> dict[str, Any]:
    """Give a release that was sent whole its environment, let its doctor look at the robot, and put it with the others.

    Returns whether the ``environment`` was ``kept`` or ``made``, and the doctor's ``findings``.
    """
    folder = layout.incoming / require_name(release)
    with hold_lock(layout, f"installation of {release}") as handle:
        told = _read_upload(folder, release)
        need = environments.PipInputs(folder / WHEELS if is_offline else None, folder / SITE, (handle,))
        environment, how = _provide_environment(layout, told, need)
        uploads.delete(folder / WHEELS)
        files.replace_link(folder / ENVIRONMENT, f"../../environments/{environment.name}")
        report_progress("doctor looks at the robot")
        findings = doctor.run_doctor(folder, told)
        os.sync()
        files.move_path(folder, layout.releases / release)
        uploads.discard_upload(layout, release)
    return {"release": release, "environment": how, "findings": findings}


def _read_upload(folder: Path, release: str) -> Release:
    try:
        told = Release.read(folder)
        is_whole = told.name == release and all(folder.joinpath(part).is_dir() for part in (PROJECT, SITE))
    except (OSError, ValueError, KeyError, TypeError):
        is_whole = False
    if not is_whole:
        raise AgentError(f"{release} was not sent whole", "Push again", "incomplete", release=release)
    return told


def _provide_environment(layout: Layout, release: Release, need: environments.PipInputs) -> tuple[Path, str]:
    recipe = environments.EnvironmentSpec.of(release.requirements)
    if there := environments.find_environment(layout, recipe):
        return there, "kept"
    report_progress("making an environment")
    return environments.make_environment(layout, recipe, release.name, need, report_progress), "made"


def discard_upload(layout: Layout, *, release: str) -> dict[str, Any]:
    """Throw away what was sent of a release that was not installed; return whether there was anything."""
    return {"discarded": uploads.discard_upload(layout, require_name(release))}
