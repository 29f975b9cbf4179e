"""``robotcore sweep`` runs one app in many worlds, on every core or on a cluster."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.cli.options import FolderType, parse_count, parse_names, parse_seconds, run_options
from robotcore.cli.output import redirect_prints, write_line
from robotcore.cli.output_files import (
    require_distinct_outputs,
    require_junit_file,
    write_error_suite,
    write_error_suite_on_failure,
    write_junit,
)
from robotcore.cli.sweep_output import show_resumed, show_sweep
from robotcore.errors import BackendError, Interrupted, RobotcoreError, UsageError
from robotcore.files import require_writable, save_output

if TYPE_CHECKING:
    from robotcore.runtime.plan import RunRequest
    from robotcore.sweep import Results
    from robotcore.sweep.engine import Engine
    from robotcore.sweep.statistics import Requirement


FOLDER = FolderType()

BADGE = "--badge"
"""The option that names the file of a badge."""

MAX_JOBS = 1024
"""The greatest number of parallel runs. Each has a thread and a process, whose number the operating system limits."""


class _SweepCommand(AnsweringCommand):
    """A command that stores its own command line, which the report shows."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.obj = shlex.join([*ctx.command_path.split(), *args])
        return super().parse_args(ctx, args)


@click.command("sweep", cls=_SweepCommand)
@click.argument("app")
@click.option(
    "--backend",
    "backends",
    type=parse_names,
    metavar="NAMES",
    default="kinematic",
    show_default=True,
    help="The backends, separated by commas.",
)
@click.option(
    "--world",
    "worlds",
    type=parse_names,
    metavar="NAMES",
    default="arena",
    show_default=True,
    help="The worlds, separated by commas.",
)
@click.option(
    "--seeds", default="1-20", show_default=True, help="The seeds of the worlds' random variations: 1-200, or 1,5,9-12."
)
@run_options
@click.option(
    "--jobs",
    metavar="N",
    type=parse_count,
    help="The number of parallel runs. Default: one per core, or 1 if the backend serves one run at a time.",
)
@click.option(
    "--wall-timeout",
    "wall_timeout_s",
    metavar="SECONDS",
    type=parse_seconds,
    help="A run that takes longer in real time has hung. Default: ten times --timeout, plus 60 seconds.",
)
@click.option("--cluster", metavar="ADDRESS", help="The address of a Dask scheduler, such as tcp://lab:8786.")
@click.option("--out", metavar="DIR", type=FOLDER, help="The folder for the results. Default: sweeps/APP-…")
@click.option("--fresh", is_flag=True, help="Delete the existing results, and run everything again.")
@click.option("--report", metavar="DIR", type=FOLDER, help="Write a report for a browser into this folder.")
@click.option(
    "--junit",
    metavar="FILE.xml",
    type=click.Path(path_type=Path),
    help="Write each run and each requirement as a test case in JUnit XML, which CI servers read.",
)
@click.option(
    "--badge",
    metavar="FILE.svg",
    type=click.Path(path_type=Path),
    help="Draw the success rate, with the colour of the bounds, as a picture for a web page.",
)
@click.option(
    "--require",
    "requirements",
    metavar="BOUND",
    multiple=True,
    help='A bound that the results must meet, such as "verified>=0.97".',
)
@click.option("--json", "as_json", is_flag=True, help="Print one line of JSON at the end, and nothing else.")
@click.pass_obj
def command(
    line: str,
    /,
    backends: tuple[str, ...],
    worlds: tuple[str, ...],
    seeds: str,
    jobs: int | None,
    wall_timeout_s: float | None,
    cluster: str | None,
    out: Path | None,
    report: Path | None,
    junit: Path | None,
    badge: Path | None,
    requirements: tuple[str, ...],
    *,
    fresh: bool,
    as_json: bool,
    **values: Any,
) -> int:
    """Run APP in many worlds, and print how often it succeeds.

    Runs every backend in every world with every seed. Each result is stored at once, so the same command continues an
    interrupted sweep. --report, --junit and --badge are written at the end, also from the results of finished runs.

    Exit status: 0 all runs are done, 1 the results do not meet a bound of --require, 2 wrong usage or a folder that
    cannot be used, 3 a backend or the cluster failed or is missing, 5 the app's file or settings raised an error,
    128 + the signal's number when interrupted.
    """
    from robotcore.sweep import Results, Sweep
    from robotcore.sweep.preflight import preflight
    from robotcore.sweep.spec import parse_seeds
    from robotcore.sweep.statistics import Requirement

    bounds = [Requirement.parse(text) for text in requirements]
    _require_writable_outputs(out, report, junit, badge)
    sweep = Sweep(_make_request(**values), backends, worlds, parse_seeds(seeds))
    engine = _make_engine(cluster, jobs, wall_timeout_s, backends)
    results = Results(sweep, out, deletes_old_results=fresh)
    app = str(values["app"])
    with (
        _write_error_badge_on_failure(badge, app),
        write_error_suite_on_failure(junit, "sweep", app, line),
        redirect_prints(as_json=as_json),
    ):
        has_verify = preflight(sweep)
        ended_by: Interrupted | RobotcoreError | None = _execute_missing_runs(results, engine, is_quiet=as_json)
    written: list[str] = []
    if isinstance(ended_by, RobotcoreError):
        write_error_suite(junit, "sweep", app, line, ended_by)
        _write_error_badge(badge, app)
    elif not ended_by:
        try:
            for output in _write_outputs(results, line, bounds, report, junit, badge):
                written.append(output)  # noqa: PERF402  an error keeps the outputs before it
        except UsageError as error:  # the summary comes first
            ended_by = error
    status = show_sweep(results, bounds, ended_by, as_json=as_json, has_verify=has_verify)
    for output in written:
        write_line(output, is_error=as_json)
    return status


def _make_request(
    settings: tuple[tuple[str, str], ...], options: tuple[tuple[str, str], ...], **values: Any
) -> RunRequest:
    from robotcore.runtime.plan import RunRequest

    return RunRequest(**values, settings=dict(settings), options=dict(options))


def _make_engine(
    cluster: str | None, jobs: int | None, wall_timeout_s: float | None, backends: tuple[str, ...]
) -> Engine:
    if cluster is None:
        from robotcore.sweep.engine import LocalEngine, count_cores

        return LocalEngine(_limit_jobs(jobs, backends) or count_cores(), wall_timeout_s)
    if jobs is not None:
        raise UsageError(
            "--jobs has no effect on a cluster, which executes one run on each worker. Leave --jobs or --cluster out",
            kind="conflicting-options",
        )
    from robotcore.sweep.cluster import ClusterEngine

    return ClusterEngine(cluster, wall_timeout_s)


def _limit_jobs(jobs: int | None, backends: tuple[str, ...]) -> int | None:
    from robotcore.hal.backend import load_backend

    if jobs and jobs > MAX_JOBS:
        raise UsageError(f"--jobs is {jobs}; it must be at most {MAX_JOBS}", kind="too-many-jobs", jobs=jobs)
    alone = [name for name in backends if load_backend(name).is_exclusive]
    if alone and jobs and jobs > 1:
        raise UsageError(
            f"the backend {alone[0]!r} serves one run at a time. Leave --jobs out",
            kind="backend-serves-one",
            backend=alone[0],
        )
    return 1 if alone else jobs


def _execute_missing_runs(results: Results, engine: Engine, *, is_quiet: bool) -> Interrupted | RobotcoreError | None:
    from robotcore.runtime.signals import SignalGuard
    from robotcore.sweep.engine import execute
    from robotcore.sweep.summary import show_progress

    with SignalGuard() as interrupts:
        try:
            with results:
                failing = [record.is_failure for record in results.records()]
                if failing and not is_quiet:
                    show_resumed(results, len(failing))
                with show_progress(len(results.sweep), len(failing), sum(failing)) as advance:
                    execute(results, engine, advance)
        except (Interrupted, BackendError) as error:
            return error
        except UsageError as error:
            if error.kind != "results-not-written":
                raise
            return error  # the summary of the saved runs comes first
        finally:
            interrupts.mask()
    return None


@contextmanager
def _write_error_badge_on_failure(badge: Path | None, app: str) -> Iterator[None]:
    try:
        yield
    except RobotcoreError:
        _write_error_badge(badge, app)
        raise


def _write_error_badge(badge: Path | None, app: str) -> None:
    """Replace the badge of an earlier sweep, so that it does not show a success that this sweep has not repeated."""
    if badge:
        from robotcore.sweep.badge import build_error_text, draw_badge

        with suppress(UsageError):  # the caller reports the first error
            save_output(draw_badge(build_error_text(app)), badge, BADGE)


def _require_writable_outputs(out: Path | None, report: Path | None, junit: Path | None, badge: Path | None) -> None:
    """Raise UsageError, before a long sweep, if an output could not be written.

    The report may be in the folder of the results.
    """
    for folder in ({"out": out}, {"report": report}):
        require_distinct_outputs(**folder, junit=junit, badge=badge)
    require_junit_file(junit)
    if badge:
        require_writable(badge, BADGE, ".svg")
    if report:
        from robotcore.sweep import report as page

        page.require_writable(report)


def _write_outputs(
    results: Results, line: str, bounds: list[Requirement], report: Path | None, junit: Path | None, badge: Path | None
) -> Iterator[str]:
    """Write the files that the options name. Yield a line about each."""
    if report:
        yield f"The report: {_write_report(results, report, line, bounds)}"
    if junit:
        from robotcore.sweep.junit import build_suites

        write_junit(build_suites(results, bounds, line), junit)
        yield f"The JUnit file: {junit}"
    if badge:
        from robotcore.sweep.badge import build_badge_text, draw_badge
        from robotcore.sweep.statistics import group_records

        text = build_badge_text(results.sweep.request.app_reference, group_records(results.records()), bounds)
        save_output(draw_badge(text), badge, BADGE)
        yield f"The badge: {badge}"


def _write_report(results: Results, directory: Path, line: str, bounds: list[Requirement]) -> Path:
    from robotcore.description import is_own, load_world
    from robotcore.sweep.report import write_report

    return write_report(
        list(results.records()),
        directory,
        results.directory,
        command=line,
        worlds=[load_world(name) for name in results.sweep.worlds if is_own(name)],
        requirements=bounds,
    )
