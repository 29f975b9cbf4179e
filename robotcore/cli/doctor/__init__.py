"""``robotcore doctor`` checks this machine, its backends and a robot, and prints a remedy for each problem.

``--json`` prints ``{"findings": [{"about", "level", "kind", "subject", "message", "remedy"}, …], "warnings": n,
"errors": n, "exit_status": n}``. ``about`` is the backend's name or ``machine``. ``level`` is ok, warning or error.
``kind`` identifies the finding. ``remedy`` may be empty.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import backend_option, load_connected_robot, merge_options, port_option, refuse_without
from robotcore.cli.output import as_json, write_finding, write_json, write_line
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.check_finding import Finding

    AboutFinding = tuple[str, Finding]


MACHINE = "machine"


@click.command("doctor")
@click.option("--robot", help="Also check the devices of this robot: its name, or its .toml file.")
@click.option(
    "--backend", help="Check only this backend. Default: the backends of this board, or all on another machine."
)
@port_option
@backend_option
@as_json
def command(
    robot: str | None, backend: str | None, port: str | None, options: tuple[tuple[str, str], ...], *, as_json: bool
) -> int:
    """Check whether this machine can run a robot.

    Prints each finding, with a remedy if something is wrong. The exit status is 1 if there is an error.
    """
    if not (robot and backend):
        refuse_without("--robot and --backend", "Add both", port=port is not None, option=bool(options))
    found = _diagnose(robot, backend, merge_options(options, port=port))
    findings = list(found if as_json else _write_and_yield(found))
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


def _diagnose(robot: str | None, backend: str | None, options: Mapping[str, str]) -> Iterator[AboutFinding]:
    """Yield each finding with the name of the backend that it is about, or ``machine``."""
    from robotcore.cli.doctor.machine import list_machine_checks
    from robotcore.hal.check_finding import findings_of

    found = list(findings_of(list_machine_checks()))
    yield from ((MACHINE, finding) for finding in found)
    if any(finding.level.value == "error" and finding.subject == "NumPy" for finding in found):
        return  # all other checks import NumPy
    description = None if robot is None else _load_robot(robot, backend, options)
    for name in (backend,) if backend else _choose_backends():
        yield from ((name, finding) for finding in _diagnose_backend(name, description, is_chosen=backend is not None))


def _load_robot(robot: str, backend: str | None, options: Mapping[str, str]) -> RobotDescription:
    from robotcore.description import load_robot
    from robotcore.hal.backend import load_backend

    return load_connected_robot(load_backend(backend), robot, options) if backend and options else load_robot(robot)


def _choose_backends() -> list[str]:
    """Return the backends of this board, or all backends if this machine is the board of none."""
    from contextlib import suppress

    from robotcore.hal.backend import load_backend
    from robotcore.plugins import backend_names

    native = []
    for name in backend_names():
        with suppress(Exception):  # `_diagnose_backend` reports the error
            native += [name] if load_backend(name).is_native_host else []
    return native or backend_names()


def _diagnose_backend(name: str, robot: RobotDescription | None, *, is_chosen: bool) -> Iterator[Finding]:
    from dataclasses import replace

    from robotcore.cli.doctor.smoke_test import diagnose, split_remedy
    from robotcore.errors import BackendMissingError
    from robotcore.hal.backend import load_backend
    from robotcore.hal.check_finding import Finding, Level, findings_of

    try:
        backend = load_backend(name)
    except BackendMissingError as error:
        if is_chosen:
            raise
        yield Finding.error(name, *split_remedy(str(error)), kind=error.kind)
        return
    for finding in findings_of([(name, lambda: diagnose(backend, robot))]):
        if finding.kind == "no-section" and not is_chosen:
            continue  # the robot is one for another backend
        is_unusable = finding.subject == name and finding.level is Level.WARNING and finding.kind != "unchecked"
        yield replace(finding, level=Level.ERROR) if is_chosen and is_unusable else finding


def _write_and_yield(found: Iterable[AboutFinding]) -> Iterator[AboutFinding]:
    for about, finding in found:
        write_finding(finding)
        yield about, finding


def _row(about: str, finding: Finding) -> dict[str, Any]:
    return {
        "about": about,
        "level": finding.level.value,
        "kind": finding.kind,
        "subject": finding.subject,
        "message": finding.message,
        "remedy": finding.remedy,
    }
