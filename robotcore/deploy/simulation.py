"""The check that runs the app in simulation, from the files that will be sent."""

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
from robotcore.deploy.checks import SIMULATION, Check, CheckResult, format_command, read_process_error, run_python
from robotcore.deploy.progress import Say
from robotcore.deploy.project import Project
from robotcore.errors import UnprovenError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.runtime.result import Outcome
from robotcore.sweep.record import Record, format_failure
from robotcore.sweep.spec import format_options, parse_seeds
from robotcore.text import escape

PINS_SIMULATOR, PLAIN_SIMULATOR = "virtualpi", "kinematic"
"""The backend that simulates the Pi below the robot's own drivers, and the one that needs no further packages."""

SECTION = "raspberrypi"
"""The name of the section of a robot's file that describes the pins of a Raspberry Pi."""

ROBOTCORE, RESULTS = "robotcore", "results.jsonl"
"""The command in the hint for repeating a run, and the name of the file with the results of the sweep."""

HANG_MARGIN_S = 60.0
"""A run counts as hanging if it takes longer than its time-out plus this margin, in s of the wall clock."""


def simulate(bundle: Bundle, say: Say) -> CheckResult:
    """Run the app in simulation, with only those files that are in the bundle.

    If the project requires bounds, the results must reach them. Otherwise every run must pass, see `is_pass`.

    Raises UnprovenError with a command that repeats the failing run.
    """
    project = bundle.project
    backend, notes = choose_simulator(project)
    world = project.world or DEFAULT_WORLD
    if "," in world:
        raise UsageError(
            f"simulation: the world's name {escape(world)} has a comma, which separates worlds in a sweep. Rename it",
            kind="comma-in-world",
            world=world,
        )
    where = f"{backend}, {escape(world)}, seeds {project.seeds}"
    say(where)
    with TemporaryDirectory(prefix="robotcore-") as scratch:
        results = Path(scratch, "results")
        answer = _run_sweep(
            bundle,
            build_sweep_arguments(project, backend, world),
            Path(scratch),
            results,
            lambda done, runs: say(f"{where}: {done} of {runs} runs"),
        )
        records = [Record.from_json(line) for line in (results / RESULTS).read_bytes().splitlines()]
    _require_pass(project, answer["missed"], [record for record in records if not is_pass(record)])
    is_judged = any(record.result.verified is not None for record in records)
    passed = sum(map(is_pass, records))
    return CheckResult(f"{where}: {passed} of {len(records)} {'verified' if is_judged else 'without a contact'}", notes)


def choose_simulator(project: Project) -> tuple[str, tuple[str, ...]]:
    """Return the name of the backend for the simulation, and notes on the choice.

    It is the project's backend if that is a simulator. Otherwise it is the simulated Pi if the robot has a section for
    the Pi and gpiozero is installed. Otherwise it is the kinematic simulator.
    """
    robot = project.load_description()
    if load_backend(project.backend).builds_world(robot):
        return project.backend, ()
    if SECTION not in robot.backends:
        return PLAIN_SIMULATOR, ()
    if find_spec("gpiozero") is None:
        return PLAIN_SIMULATOR, (f"the robot's own drivers did not run: {PINS_SIMULATOR} needs pip install gpiozero",)
    return PINS_SIMULATOR, ()


def is_pass(record: Record) -> bool:
    """Return whether a run passes if no bounds are required.

    A run passes if it ends with success. An app that never ends and whose result nothing verifies passes if the run
    reaches its time-out without a contact.
    """
    result = record.result
    is_endless = result.outcome is Outcome.TIMEOUT and result.verified is None and not result.contacts
    return is_endless or not record.is_failure


def build_sweep_arguments(project: Project, backend: str, world: str) -> list[str]:
    """Return the arguments of ``robotcore`` that run the sweep.

    The options of the project's backend are left out if the simulation uses another backend.
    """
    options = project.options if backend == project.backend else {}
    request = RunRequest(
        project.app, robot=project.robot, rate_hz=project.rate_hz, settings=project.settings, options=options
    )
    bounds = [word for bound in project.require for word in ("--require", bound)]
    where = ["--backend", backend, "--world", world, "--seeds", project.seeds]
    return ["sweep", project.app, *where, *format_options(request), *bounds]


def _run_sweep(
    bundle: Bundle, words: Sequence[str], scratch: Path, results: Path, report: Callable[[int, int], object]
) -> dict[str, Any]:
    """Run ``robotcore sweep`` and return its answer; raises UnprovenError if the sweep did not end.

    The sweep runs in a copy of the bundle. So files that the app writes or that Python compiles are not sent.

    words: the arguments of the sweep.
    scratch: a folder for the copy.
    results: the folder for the results.
    report: this function is called with the number of runs that are done, and the number of all runs.
    """
    copy = shutil.copytree(bundle.folder, scratch / "sent", symlinks=True)
    runs, limit_s = len(parse_seeds(bundle.project.seeds)), HANG_MARGIN_S + RunRequest.timeout_s
    line = [*service.ROBOTCORE_ARGUMENTS, *words, "--wall-timeout", f"{limit_s:g}", "--out", str(results), "--json"]
    try:
        process = run_python(
            copy / PROJECT,
            line,
            _build_environment(copy / SITE),
            limit_s=HANG_MARGIN_S + runs * limit_s,
            on_poll=lambda: report(_count_results(results / RESULTS), runs),
        )
        answer: dict[str, Any] = json.loads(process.stdout)
    except TimeoutError as error:
        answer = {"error": f"it {error}. Check that the import of the app's file ends"}
    except ValueError:
        answer = {"error": read_process_error(process)}
    if "error" in answer:
        again = _format_repeat(bundle.project, shlex.join([ROBOTCORE, *words]))
        raise UnprovenError(f"simulation: {answer['error']}{again}", kind="simulation-not-run")
    return answer


def _count_results(file: Path) -> int:
    return file.read_bytes().count(b"\n") if file.exists() else 0


def _format_repeat(project: Project, line: str) -> str:
    """Return lines with the command that repeats a run in the user's folder.

    That folder has more files than the bundle, so the lines say what it means if the repeated run passes.
    """
    more = "\nIf that run passes, the app needs a file that is not sent: git ignores it, or it may hold a secret"
    return f"\nTo repeat it: {format_command(project, line)}{more if project.folder else ''}"


def _build_environment(site: Path) -> dict[str, str]:
    """Return the environment variables that make Python search modules in ``site`` first, as on the robot."""
    paths = [str(site), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {"PYTHONPATH": os.pathsep.join(paths)}


def _require_pass(project: Project, missed: Sequence[str], failing: Sequence[Record]) -> None:
    """Raise UnprovenError if a required bound is missed or, without required bounds, if a run does not pass."""
    if not (missed if project.require else failing):
        return
    first = failing[0] if failing else None
    why = "; ".join(missed) or f"{len(failing)} of the runs fail"
    which = f". Seed {first.result.seed}: {format_failure(first)}" if first else ""
    again = _format_repeat(project, first.command) if first else ""
    kind = "bound-missed" if project.require else "run-failed"
    seed = first.result.seed if first else None
    raise UnprovenError(f"simulation: {why}{which}{again}", kind=kind, missed=tuple(missed), seed=seed)


CHECKS_OF_BUNDLE = (Check[Bundle](SIMULATION, simulate),)
"""The checks that run in the bundle, after it is built."""
