"""``robotcore doctor``: what is right and what is wrong with this machine, and what to do.

``--json`` prints ``{"findings": [{"about", "level", "what", "said", "remedy"}, …], "warnings": n, "errors": n,
"exit_status": n}``: ``about`` is the backend's name or ``machine``, ``level`` one of ok, warning, error, ``remedy``
empty where there is none to give.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import connection_options, load_connected_robot, merge_options
from robotcore.cli.output import as_json, write_finding, write_json, write_line
from robotcore.errors import UsageError
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.finding import Finding

    AboutFinding = tuple[str, Finding]


MACHINE = "machine"


@click.command("doctor")
@click.option("--robot", help="A robot by its name or its file, whose devices are looked at too.")
@click.option("--backend", help="Look at this one only; by default this board's, or all that are no board's.")
@connection_options
@as_json
def command(
    robot: str | None, backend: str | None, port: str | None, options: tuple[tuple[str, str], ...], *, as_json: bool
) -> int:
    """Look whether this machine can run a robot.

    Says what is right, what is wrong and what to do about it; the exit status is 1 where there is an error.
    """
    if (chosen_options := merge_options(port, options)) and not (robot and backend):
        raise UsageError(
            f"option {next(iter(chosen_options))}: of which robot, on which backend? Add --robot and --backend"
        )
    found = _find(robot, backend, chosen_options)
    findings = list(found if as_json else _shown(found))
    levels = [finding.level.value for _, finding in findings]
    warnings, errors = levels.count("warning"), levels.count("error")
    status = 1 if errors else 0
    if as_json:
        rows = [_row(about, finding) for about, finding in findings]
        write_json({"findings": rows, "warnings": warnings, "errors": errors, "exit_status": status})
    else:
        write_line()
        write_line(f"{pluralize(errors, 'error')}, {pluralize(warnings, 'warning')}")
    return status


def _find(robot: str | None, backend: str | None, options: Mapping[str, str]) -> Iterator[AboutFinding]:
    """Yield what is found, as it is found; what robots are made of is imported after the machine was looked at."""
    from robotcore.cli.doctor.machine import machine_checks
    from robotcore.hal.finding import findings_of

    found = list(findings_of(machine_checks()))
    yield from ((MACHINE, finding) for finding in found)
    if any(finding.level.value == "error" and finding.what == "NumPy" for finding in found):
        return  # nothing else can be imported
    described = None if robot is None else _described(robot, backend, options)
    for name in (backend,) if backend else _chosen():
        yield from ((name, finding) for finding in _examined(name, described, is_asked=backend is not None))


def _described(robot: str, backend: str | None, options: Mapping[str, str]) -> RobotDescription:
    from robotcore.description import load_robot
    from robotcore.hal.backend import load_backend

    return load_connected_robot(load_backend(backend), robot, options) if backend and options else load_robot(robot)


def _chosen() -> list[str]:
    """Return the backends of this board; all of them, where this is no board of theirs."""
    from contextlib import suppress

    from robotcore.hal.backend import load_backend
    from robotcore.plugins import backend_names

    at_home = []
    for name in backend_names():
        with suppress(Exception):  # `_examined` reports what it raises
            at_home += [name] if load_backend(name).is_native_host else []
    return at_home or backend_names()


def _examined(name: str, robot: RobotDescription | None, *, is_asked: bool) -> Iterator[Finding]:
    from dataclasses import replace

    from robotcore.cli.doctor.smoke_test import diagnose
    from robotcore.errors import BackendMissingError
    from robotcore.hal.backend import load_backend
    from robotcore.hal.finding import Finding, Level, findings_of

    try:
        backend = load_backend(name)
    except BackendMissingError as error:
        if is_asked:
            raise
        yield Finding.error(name, *_halves(str(error)))
        return
    is_wanting = is_asked and not backend.is_installed
    for finding in findings_of([(name, lambda: diagnose(backend, robot))]):
        yield replace(finding, level=Level.ERROR) if is_wanting and finding.what == name else finding


def _halves(message: str) -> tuple[str, str]:
    fault, _, remedy = message.rpartition(". ")
    return fault, remedy


def _shown(found: Iterable[AboutFinding]) -> Iterator[AboutFinding]:
    """Write each finding as it comes."""
    for about, finding in found:
        write_finding(finding)
        yield about, finding


def _row(about: str, finding: Finding) -> dict[str, Any]:
    return {
        "about": about,
        "level": finding.level.value,
        "what": finding.what,
        "said": finding.said,
        "remedy": finding.remedy,
    }
