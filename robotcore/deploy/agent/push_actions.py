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
    """Return the facts, the current ``release``, and whether the requirements have an environment.

    requirements: the release's requirements, as pip takes them.
    is_push: raise AgentError if this robot cannot receive a push.
    """
    answer = {**collect_facts(layout), "release": releases.read_current(layout)}
    answer["has_environment"] = (
        environments.find_environment(layout, environments.EnvironmentSpec.of(requirements)) is not None
    )
    if is_push:
        robot_facts.require_push_needs(answer, has_environment=answer["has_environment"])
        answer.update(is_lingering=True, has_user_manager=True)
    return answer


SPARE_BYTES = 100_000_000
"""Bytes that must stay free on the disk, because the system needs them."""


def begin_upload(layout: Layout, *, release: str, size: int) -> dict[str, Any]:
    """Make room for an upload; return the ``release``'s name, the upload's folder ``to``, and the folder ``copy_from``.

    The name is the desk's, or one second after the newest one on the robot if the desk's is not newer. So each push has
    its own name, and names sort in the order of the pushes. ``copy_from`` is None if the robot has no release. Both
    folders are relative to the robot's folder. If the disk is still full after old releases were deleted, AgentError is
    raised, and nothing is left of the upload.

    release: the name that the desk proposes.
    size: the bytes of the upload.
    """
    with hold_lock(layout, f"push of {require_name(release)}"):
        for folder in (layout.incoming, layout.releases, layout.recordings):
            folder.mkdir(parents=True, exist_ok=True)
        prune_releases(layout, keep=1 if _measure_missing(layout, size) else KEPT_HEALTHY)
        release = _choose_name(layout, release)
        folder = uploads.open_upload(layout, release)
        if missing := _measure_missing(layout, size - files.measure_size(folder)):
            uploads.discard_upload(layout, release)
            raise _build_disk_error(layout, size, missing)
        before = releases.read_current(layout) or next(iter(releases.list_names(layout)), None)
    return {"release": release, "to": f"incoming/{release}", "copy_from": f"releases/{before}" if before else None}


def _choose_name(layout: Layout, proposed: str) -> str:
    existing = [
        *releases.list_names(layout),
        *(path.name for path in layout.incoming.glob("*") if NAME_PATTERN.fullmatch(path.name)),
    ]
    newest = max(existing, default="")
    if proposed > newest:
        return proposed
    return time.strftime(NAME_FORMAT, time.gmtime(timegm(time.strptime(newest, NAME_FORMAT)) + 1))


def _measure_missing(layout: Layout, size: int) -> int:
    """Return how many bytes the disk lacks for an upload."""
    return max(0, size + SPARE_BYTES - files.measure_free_space(layout.root))


def _build_disk_error(layout: Layout, size: int, missing: int) -> AgentError:
    recorded = files.measure_size(layout.recordings)
    sizes = f"{files.format_bytes(size)} are to be sent, {files.format_bytes(missing)} are missing"
    fetch = f"recordings take {files.format_bytes(recorded)}; robotcore deploy fetch --move takes them home"
    remedy = f"Make room there: {fetch if recorded else 'df -h and du -xh ~ | sort -h show what takes it'}"
    return AgentError(
        f"the robot's disk is full: {sizes}", remedy, "disk", size=size, missing=missing, recorded=recorded
    )


KEPT_HEALTHY, KEPT_OTHERS = 5, 2
"""How many healthy releases are kept, and how many others; failed releases displace no healthy ones."""


def prune_releases(layout: Layout, keep: int = KEPT_HEALTHY) -> tuple[str, ...]:
    """Delete old releases that are not needed, and unused environments. The caller holds the lock.

    keep: how many healthy releases to keep.
    Returns the names of the deleted releases.
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
    """Yield the current release, the one that a rollback would choose, and those of a pending health check."""
    yield releases.read_current(layout)
    yield releases.find_previous(layout)
    if pending := health_check.read_pending(layout):
        yield from (pending.release, pending.previous)


def install_release(layout: Layout, *, release: str, is_offline: bool = False) -> dict[str, Any]:
    """Turn a complete upload into a release: provide its environment, run its doctor, move it to the releases.

    is_offline: install the uploaded wheels, without the network.
    Returns whether the ``environment`` was ``kept`` or ``made``, and the doctor's ``findings``.
    """
    folder = layout.incoming / require_name(release)
    with hold_lock(layout, f"installation of {release}") as handle:
        manifest = _read_upload(folder, release)
        inputs = environments.PipInputs(folder / WHEELS if is_offline else None, folder / SITE, (handle,))
        environment, how = _provide_environment(layout, manifest, inputs)
        uploads.delete(folder / WHEELS)
        files.replace_link(folder / ENVIRONMENT, f"../../environments/{environment.name}")
        report_progress("doctor looks at the robot")
        findings = doctor.run_doctor(folder, manifest)
        os.sync()
        files.move_path(folder, layout.releases / release)
        uploads.discard_upload(layout, release)
    return {"release": release, "environment": how, "findings": findings}


def _read_upload(folder: Path, release: str) -> Release:
    try:
        manifest = Release.read(folder)
        is_complete = manifest.name == release and all(folder.joinpath(part).is_dir() for part in (PROJECT, SITE))
    except (OSError, ValueError, KeyError, TypeError):
        is_complete = False
    if not is_complete:
        raise AgentError(f"the upload of {release} is not complete", "Push again", "incomplete", release=release)
    return manifest


def _provide_environment(layout: Layout, release: Release, inputs: environments.PipInputs) -> tuple[Path, str]:
    spec = environments.EnvironmentSpec.of(release.requirements)
    if existing := environments.find_environment(layout, spec):
        return existing, "kept"
    report_progress("making an environment")
    return environments.make_environment(layout, spec, release.name, inputs, report_progress), "made"


def discard_upload(layout: Layout, *, release: str) -> dict[str, Any]:
    """Delete the upload of a release; return whether there was one."""
    return {"discarded": uploads.discard_upload(layout, require_name(release))}
