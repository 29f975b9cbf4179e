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
from robotcore.deploy.checks import SIMULATION, Check, CheckResult, command_line, process_error, run_python
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
"""The simulator with the robot's own drivers, and the one without further requirements."""

SECTION = "raspberrypi"
ROBOTCORE, RESULTS = "robotcore", "results.jsonl"

HANG_MARGIN_S = 60.0
"""A run hangs if it takes this much longer than its time-out, by the wall clock."""


def simulate(bundle: Bundle, say: Say) -> CheckResult:
    """Run the app in simulation; raises UnprovenError with a command that repeats the failing run.

    The runs use the files of the bundle only. If bounds are required, they decide. Else every run must pass: see
    `is_pass`.
    """
    project = bundle.project
    backend, notes = choose_simulator(project)
    world = project.world or DEFAULT_WORLD
    if "," in world:
        raise UsageError(
            f"simulation: {escape(world)}: a sweep parts worlds at commas. Take the comma out of the name",
            kind="comma-in-world",
            world=world,
        )
    where = f"{backend}, {escape(world)}, seeds {project.seeds}"
    say(where)
    with TemporaryDirectory(prefix="robotcore-") as scratch:
        results = Path(scratch, "results")
        answer = _run_sweep(
            bundle,
            sweep_arguments(project, backend, world),
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
    """Return the backend of the simulation, and notes on it.

    If the project's backend is a simulator, it is used. Else it is the simulated Pi if the robot has a section for the
    Pi and gpiozero is installed.
    """
    robot = project.load_description()
    if load_backend(project.backend).builds_world(robot):
        return project.backend, ()
    if SECTION not in robot.backends:
        return PLAIN_SIMULATOR, ()
    if find_spec("gpiozero") is None:
        return PLAIN_SIMULATOR, (f"its own drivers were not tried: {PINS_SIMULATOR} needs pip install gpiozero",)
    return PINS_SIMULATOR, ()


def is_pass(record: Record) -> bool:
    """Return whether a run passes where nothing is required: see `simulate`."""
    result = record.result
    goes_on = result.outcome is Outcome.TIMEOUT and result.verified is None and not result.contacts
    return goes_on or not record.is_failure


def sweep_arguments(project: Project, backend: str, world: str) -> list[str]:
    """Return the sweep, word by word; the options are those of the robot's own backend, and no other's."""
    options = project.options if backend == project.backend else {}
    request = RunRequest(
        project.app, robot=project.robot, rate_hz=project.rate_hz, settings=project.settings, options=options
    )
    bounds = [word for bound in project.require for word in ("--require", bound)]
    where = ["--backend", backend, "--world", world, "--seeds", project.seeds]
    return ["sweep", project.app, *where, *format_options(request), *bounds]


def _run_sweep(
    bundle: Bundle, words: Sequence[str], scratch: Path, results: Path, tell: Callable[[int, int], object]
) -> dict[str, Any]:
    """Return the answer of ``robotcore sweep``; raises UnprovenError where it came to no end.

    It runs in a copy: what an app writes beside itself is not to be sent, nor what Python compiles. How many runs are
    done, and of how many, is told.
    """
    copy = shutil.copytree(bundle.folder, scratch / "sent", symlinks=True)
    runs, patience_s = len(parse_seeds(bundle.project.seeds)), HANG_MARGIN_S + RunRequest.timeout_s
    line = [*service.ROBOTCORE_ARGUMENTS, *words, "--wall-timeout", f"{patience_s:g}", "--out", str(results), "--json"]
    try:
        asked = run_python(
            copy / PROJECT,
            line,
            _environment(copy / SITE),
            limit_s=HANG_MARGIN_S + runs * patience_s,
            look=lambda: tell(_count_results(results / RESULTS), runs),
        )
        answer: dict[str, Any] = json.loads(asked.stdout)
    except TimeoutError as error:
        answer = {"error": f"{error}. Does the app's file do something without end?"}
    except ValueError:
        answer = {"error": process_error(asked)}
    if "error" in answer:
        again = _format_repeat(bundle.project, shlex.join([ROBOTCORE, *words]))
        raise UnprovenError(f"simulation: {answer['error']}{again}", kind="simulation-not-run")
    return answer


def _count_results(file: Path) -> int:
    return file.read_bytes().count(b"\n") if file.exists() else 0


def _format_repeat(project: Project, line: str) -> str:
    """Return what repeats it, in the user's own folder: there is more in that than is sent."""
    more = "\nIf it passes then, it lacks a file that is not sent: git ignores it, or it may hold a secret"
    return f"\nRepeat it: {command_line(project, line)}{more if project.folder else ''}"


def _environment(site: Path) -> dict[str, str]:
    """Return where Python looks for modules, as on the robot: in ``site`` first."""
    paths = [str(site), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {"PYTHONPATH": os.pathsep.join(paths)}


def _require_pass(project: Project, missed: Sequence[str], failing: Sequence[Record]) -> None:
    """Raise UnprovenError where a required bound is missed or, where none is required, where a run does not pass."""
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
