"""Actions of a push: probe the robot, begin an upload, install a release, discard an upload."""

from __future__ import annotations

import json
import os
import re
import subprocess
import time
from calendar import timegm
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robotcore.deploy.agent import environments, files, health_check, releases, robot_facts, uploads
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, hold_lock
from robotcore.deploy.agent.releases import (
    ENVIRONMENT,
    HEALTHY,
    NAME_FORMAT,
    NAME_PATTERN,
    PROJECT,
    SITE,
    WHEELS,
    Release,
    require_name,
)
from robotcore.deploy.agent.rpc import report_progress
from robotcore.deploy.agent.service import build_launch
from robotcore.deploy.agent.systemd_units import SERVICE


def probe(layout: Layout, *, requirements: Sequence[str]) -> dict[str, Any]:
    """Return the facts about the robot, see `robot_answers.ProbeAnswer`.

    requirements: the new release's requirements, in pip's format.
    Raises AgentError if this robot cannot receive a push.
    """
    spec = environments.EnvironmentSpec.from_requirements(requirements)
    has_environment = environments.find_environment(layout, spec) is not None
    robot_facts.require_push_needs(has_environment=has_environment)
    return {**robot_facts.collect_facts(layout), "has_environment": has_environment}


SPARE_BYTES = 100_000_000
"""The space in bytes that a push leaves free on the disk for the operating system."""


def begin_upload(layout: Layout, *, release: str, size: int) -> dict[str, Any]:
    """Make room on the disk, and create the folder of an upload. Return the fields of `robot_answers.BeginAnswer`.

    The release gets the proposed name if that is later than all names on the robot. Otherwise it gets the latest of
    these names plus one second. So names sort in the order of the pushes.

    release: the name that the client proposes.
    size: the size of the upload in bytes.
    Raises AgentError if the disk has too little room even without the old releases.
    """
    with hold_lock(layout, f"push of {require_name(release)}"):
        for folder in (layout.incoming, layout.releases, layout.recordings):
            folder.mkdir(parents=True, exist_ok=True)
        prune_releases(layout, keep=1 if _measure_missing_bytes(layout, size) else KEPT_HEALTHY)
        release = _choose_name(layout, release)
        folder = uploads.open_upload(layout, release)
        if missing := _measure_missing_bytes(layout, size - files.measure_size(folder)):
            uploads.discard_upload(layout, release)
            raise _build_disk_error(layout, size, missing)
        before = releases.read_current(layout) or next(iter(releases.list_names(layout)), None)
    return {"release": release, "to": f"incoming/{release}", "copy_from": f"releases/{before}" if before else None}


def _choose_name(layout: Layout, proposed: str) -> str:
    uploaded = [path.name for path in layout.incoming.glob("*") if NAME_PATTERN.fullmatch(path.name)]
    newest = max([*releases.list_names(layout), *uploaded], default="")
    if proposed > newest:
        return proposed
    return time.strftime(NAME_FORMAT, time.gmtime(timegm(time.strptime(newest, NAME_FORMAT)) + 1))


def _measure_missing_bytes(layout: Layout, size: int) -> int:
    return max(0, size + SPARE_BYTES - files.measure_free_space(layout.root))


def _build_disk_error(layout: Layout, size: int, missing: int) -> AgentError:
    recorded = files.measure_size(layout.recordings)
    sizes = f"the upload needs {files.format_bytes(size)}, and {files.format_bytes(missing)} are missing"
    fetch = f"fetch its recordings, {files.format_bytes(recorded)}: robotcore deploy fetch --move"
    remedy = f"Make room on the robot: {fetch if recorded else 'df -h and du -xh ~ | sort -h show what fills the disk'}"
    return AgentError(
        f"the robot's disk is full: {sizes}", remedy, "disk", size=size, missing=missing, recorded=recorded
    )


KEPT_HEALTHY, KEPT_OTHERS = 5, 2
"""The number of healthy releases and the number of other releases that the robot keeps.

The numbers are separate so that failed releases do not displace healthy ones.
"""


def prune_releases(layout: Layout, keep: int = KEPT_HEALTHY) -> tuple[str, ...]:
    """Delete old releases and unused environments, and return the names of the deleted releases.

    The caller must hold the lock.

    keep: the number of healthy releases to keep.
    """
    names = releases.list_names(layout)
    healthy = [name for name in names if releases.read_outcome(layout, name) == HEALTHY]
    others = [name for name in names if name not in healthy]
    stay = {*healthy[:keep], *others[: min(keep, KEPT_OTHERS)]}
    stay |= {releases.read_current(layout) or "", releases.find_previous(layout) or ""}
    if pending := health_check.read_pending(layout):
        stay |= {pending.release, pending.previous or ""}
    old = tuple(name for name in names if name not in stay)
    for name in old:
        uploads.discard(layout, layout.releases / name)
    environments.discard_unused(layout)
    return old


def install_release(layout: Layout, *, release: str, is_offline: bool = False) -> dict[str, Any]:
    """Turn a complete upload into a release. Return the fields of `robot_answers.InstallAnswer`.

    The function links the upload to an environment, runs its doctor, and moves it to the releases.

    is_offline: whether pip installs uploaded wheels without the network.
    """
    folder = layout.incoming / require_name(release)
    with hold_lock(layout, f"installation of {release}") as handle:
        manifest = _read_upload(folder, release)
        inputs = environments.PipInputs(folder / WHEELS if is_offline else None, folder / SITE, (handle,))
        spec, how = environments.EnvironmentSpec.from_requirements(manifest.requirements), "kept"
        environment = environments.find_environment(layout, spec)
        if environment is None:
            report_progress("making an environment")
            environment, how = environments.create_environment(layout, spec, release, inputs), "made"
        uploads.delete(folder / WHEELS)
        files.replace_link(folder / ENVIRONMENT, f"../../environments/{environment.name}")
        report_progress("the doctor examines the robot")
        findings = run_doctor(folder, manifest)
        os.sync()
        files.move_path(folder, layout.releases / release)
        uploads.discard_upload(layout, release)
    return {"release": release, "environment": how, "findings": findings}


def _read_upload(folder: Path, release: str) -> Release:
    try:
        manifest = Release.read(folder)
        is_complete = manifest.name == release and all(folder.joinpath(part).is_dir() for part in (PROJECT, SITE))
    except (OSError, ValueError):
        is_complete = False
    if not is_complete:
        raise AgentError(f"the upload of {release} is not complete", "Push again", "incomplete", release=release)
    return manifest


def discard_upload(layout: Layout, *, release: str) -> dict[str, Any]:
    """Delete the upload of a release. Return whether the robot had such an upload."""
    with hold_lock(layout, f"deletion of the upload of {require_name(release)}"):
        return {"discarded": uploads.discard_upload(layout, release)}


DOCTOR_TIMEOUT_S = 180
"""The time limit of the doctor, in s. The first start of a release compiles modules, which is slow on an SD card."""

_PROC = Path("/proc")
_SERVICE_GROUP = f"/{SERVICE}"
"""The end of the control group's name in ``/proc/PID/cgroup`` of the app's processes. Source: cgroups(7)."""


def run_doctor(folder: Path, release: Release) -> list[dict[str, Any]]:
    """Run the doctor of a release on this robot, and return the findings in its output.

    If the doctor does not run, that is the only finding. A pin that the running release uses is not an error, because
    that release stops before the new one starts.
    """
    called = build_launch(folder, "doctor", "--json", f"--robot={release.robot}", f"--backend={release.backend}")
    try:
        with TemporaryDirectory() as scratch:  # the pin library lgpio writes into the folder LG_WD
            done = subprocess.run(  # noqa: S603  no shell
                called.command,
                cwd=called.folder,
                env={**called.environment, "LG_WD": scratch},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=DOCTOR_TIMEOUT_S,
                check=False,
            )
        return [_excuse_running_release(row) for row in json.loads(done.stdout)["findings"]]
    except subprocess.TimeoutExpired:
        said = f"has not ended within {DOCTOR_TIMEOUT_S} s"
    except (ValueError, KeyError, TypeError):
        last = [line for line in done.stderr.splitlines() if line.strip()][-1:]
        said = f"does not run: {last[0] if last else f'it ended with status {done.returncode}'}"
    remedy = "Run robotcore doctor on the robot, repair what it names, and push again"
    return [{"about": "machine", "level": "error", "subject": "doctor", "message": said, "remedy": remedy}]


def _excuse_running_release(row: dict[str, Any]) -> dict[str, Any]:
    holders = re.findall(r"process (\d+)", row["message"])
    if row["level"] != "error" or not holders or not all(map(_is_in_service, holders)):
        return row
    return {**row, "level": "ok", "message": f"{row['message']}: the running release, which stops first", "remedy": ""}


def _is_in_service(pid: str) -> bool:
    try:
        return _PROC.joinpath(pid, "cgroup").read_text().rstrip("\n").endswith(_SERVICE_GROUP)
    except OSError:
        return False
