"""A check before a push: run the app in simulation, from the files that will be sent."""

from __future__ import annotations

import json
import os
import shlex
import shutil
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robotcore.deploy.agent import service
from robotcore.deploy.agent.releases import PROJECT, SITE
from robotcore.deploy.bundle import Bundle
from robotcore.deploy.checks import CheckResult, format_command, read_process_error, run_python
from robotcore.deploy.progress import OnText
from robotcore.deploy.project import Project
from robotcore.errors import ReleaseCheckError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.runtime.result import Outcome
from robotcore.sweep.record import Record, format_failure
from robotcore.sweep.spec import format_options, parse_seeds
from robotcore.text import escape

PINS_SIMULATOR, PLAIN_SIMULATOR = "virtualpi", "kinematic"
"""Two simulator backends.

The first simulates the pins of a Raspberry Pi, so that the robot's own drivers run. The second needs no further
package.
"""

SECTION = "raspberrypi"
"""The name of the section in a robot's file that describes the pins of a Raspberry Pi."""

RESULTS = "results.jsonl"
"""The name of a sweep's file of results."""

HANG_MARGIN_S = 60.0
"""The wall-clock time after a run's time-out, in s, after which the run counts as hanging."""


def simulate(bundle: Bundle, report: OnText) -> CheckResult:
    """Run the app in simulation with the files of the bundle only.

    The results must reach the project's bounds (`Project.require`). Without bounds, every run must pass, see `is_pass`.

    Raises ReleaseCheckError with a command that repeats the failing run.
    """
    project = bundle.project
    backend, warnings = choose_simulator(project)
    world = project.world or DEFAULT_WORLD
    if "," in world:
        raise UsageError(
            f"simulation: the world's name {escape(world)} has a comma, which separates worlds in a sweep. Rename it",
            kind="comma-in-world",
            world=world,
        )
    where = f"{backend}, {escape(world)}, seeds {project.deploy.seeds}"
    report(where)
    with TemporaryDirectory(prefix="robotcore-") as scratch:
        results = Path(scratch, "results")
        answer = _run_sweep(
            bundle,
            build_sweep_arguments(project, backend, world),
            Path(scratch),
            results,
            lambda done, runs: report(f"{where}: {done} of {runs} runs"),
        )
        records = [Record.from_json(line) for line in (results / RESULTS).read_bytes().splitlines()]
    _require_pass(project, answer["missed"], [record for record in records if not is_pass(record)])
    is_judged = any(record.result.verified is not None for record in records)
    passed = sum(map(is_pass, records))
    return CheckResult(
        f"{where}: {passed} of {len(records)} {'verified' if is_judged else 'without a contact'}", warnings
    )


def choose_simulator(project: Project) -> tuple[str, tuple[str, ...]]:
    """Return the name of the backend for the simulation, and warnings.

    The choice is the first possible one of

    1. the project's backend if it is a simulator,
    2. `PINS_SIMULATOR` if the robot has a section for the Raspberry Pi and gpiozero is installed,
    3. `PLAIN_SIMULATOR`.
    """
    robot = project.load_description()
    if load_backend(project.deploy.backend).builds_world(robot):
        return project.deploy.backend, ()
    if SECTION not in robot.backends:
        return PLAIN_SIMULATOR, ()
    if find_spec("gpiozero") is None:
        return PLAIN_SIMULATOR, (f"the robot's own drivers did not run: {PINS_SIMULATOR} needs pip install gpiozero",)
    return PINS_SIMULATOR, ()


def is_pass(record: Record) -> bool:
    """Return whether a run passes in a project without bounds.

    A run passes if it ends with success. A run without a verified result also passes if it reaches its time-out without
    a contact, because its app may never end.
    """
    result = record.result
    is_endless = result.outcome is Outcome.TIMEOUT and result.verified is None and not result.contacts
    return is_endless or not record.is_failure


def build_sweep_arguments(project: Project, backend: str, world: str) -> list[str]:
    """Return the arguments of ``robotcore`` that run the sweep.

    They have the options of the project's backend only if the simulation uses this backend.
    """
    options = project.deploy.options if backend == project.deploy.backend else {}
    request = RunRequest(
        project.app,
        robot=project.robot,
        rate_hz=project.deploy.rate_hz,
        settings=project.deploy.settings,
        options=options,
    )
    bounds = [word for bound in project.deploy.require for word in ("--require", bound)]
    where = ["--backend", backend, "--world", world, "--seeds", project.deploy.seeds]
    return ["sweep", project.app, *where, *format_options(request), *bounds]


def _run_sweep(
    bundle: Bundle, arguments: Sequence[str], scratch: Path, results: Path, report: Callable[[int, int], object]
) -> dict[str, Any]:
    """Run ``robotcore sweep`` in a copy of the bundle, and return its answer to ``--json``.

    The copy keeps files that the app writes or that Python compiles out of the bundle.

    report: this function is called with the number of completed runs and the number of all runs.
    """
    copy = shutil.copytree(bundle.folder, scratch / "sent", symlinks=True)
    runs, limit_s = len(parse_seeds(bundle.project.deploy.seeds)), HANG_MARGIN_S + RunRequest.timeout_s
    line = [*service.ROBOTCORE_ARGUMENTS, *arguments, "--wall-timeout", f"{limit_s:g}", "--out", str(results), "--json"]
    try:
        process = run_python(
            copy / PROJECT,
            line,
            {"PYTHONPATH": os.pathsep.join([str(copy / SITE), *filter(None, [os.environ.get("PYTHONPATH")])])},
            limit_s=HANG_MARGIN_S + runs * limit_s,
            on_poll=lambda: report(_count_lines(results / RESULTS), runs),
        )
        answer: dict[str, Any] = json.loads(process.stdout)
    except TimeoutError as error:
        answer = {"error": f"it {error}. Check that the import of the app's file ends"}
    except ValueError:
        answer = {"error": read_process_error(process)}
    if "error" in answer:
        again = _format_repeat(bundle.project, shlex.join(["robotcore", *arguments]))
        raise ReleaseCheckError(f"simulation: {answer['error']}{again}", kind="simulation-not-run")
    return answer


def _count_lines(file: Path) -> int:
    return file.read_bytes().count(b"\n") if file.exists() else 0


def _format_repeat(project: Project, line: str) -> str:
    more = "\nIf that run passes, the app needs a file that is not sent: git ignores it, or it may hold a secret"
    return f"\nTo repeat it: {format_command(project, line)}{more if project.folder else ''}"


def _require_pass(project: Project, missed: Sequence[str], failing: Sequence[Record]) -> None:
    if not (missed if project.deploy.require else failing):
        return
    first = failing[0] if failing else None
    why = "; ".join(missed) or f"{len(failing)} of the runs fail"
    which = f". Seed {first.result.seed}: {format_failure(first)}" if first else ""
    again = _format_repeat(project, first.command) if first else ""
    kind = "bound-missed" if project.deploy.require else "run-failed"
    seed = first.result.seed if first else None
    raise ReleaseCheckError(f"simulation: {why}{which}{again}", kind=kind, missed=tuple(missed), seed=seed)
