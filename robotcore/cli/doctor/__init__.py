"""``robotcore doctor`` checks this machine, its backends and a robot, and prints a remedy for each problem."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import (
    backend_option,
    load_connected_robot,
    merge_options,
    parse_pair,
    port_option,
    refuse_beside,
    refuse_without,
)
from robotcore.cli.output import as_json, write_finding, write_json, write_line
from robotcore.errors import UsageError
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.check_finding import Finding

    AboutFinding = tuple[str, Finding]


MACHINE = "machine"


def parse_wire(value: str) -> tuple[int, int]:
    """Return the output and the input of a wire, such as ``20:21``."""
    if not (found := re.fullmatch(r"([0-9]{1,3}):([0-9]{1,3})", value)):
        raise click.BadParameter(f"{value[:20]!r} is not OUT:IN. Give two GPIOs, such as 20:21")
    return int(found[1]), int(found[2])


@click.command("doctor")
@click.option("--robot", help="Also check the devices of this robot: its name, or its .toml file.")
@click.option(
    "--backend", help="Check only this backend. Default: the backends of this board, or all on another machine."
)
@port_option
@backend_option
@click.option("--loopback", is_flag=True, help="Test a Raspberry Pi by two wires between its pins, and write a report.")
@click.option(
    "--wire",
    "wires",
    metavar="OUT:IN",
    type=parse_wire,
    multiple=True,
    help="The GPIOs of one wire, output and input. Give the option twice. Default: free pins of the robot.",
)
@click.option("--motor", metavar="NAME", help="Test this motor of the robot, off the ground. Default: the first one.")
@click.option("--rt", "is_real_time", is_flag=True, help="Also measure the ticks with real-time priority.")
@click.option(
    "--tick-test",
    "tick_test_s",
    metavar="SECONDS",
    type=click.FloatRange(1, 3600),
    help="The duration of each measurement of the ticks. Default: 10.",
)
@click.option(
    "--answer",
    "answers",
    metavar="TOPIC=ANSWER",
    type=parse_pair,
    multiple=True,
    help="Answer a question in advance, such as wires=ready. Repeatable.",
)
@click.option(
    "--report",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="The report's file. Default: a name with host and date.",
)
@click.option(
    "--row",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Print this report as a row for the table in drivers/raspberrypi/QUALITY.md, and exit.",
)
@as_json
def command(
    robot: str | None,
    backend: str | None,
    port: str | None,
    options: tuple[tuple[str, str], ...],
    *,
    loopback: bool,
    row: Path | None,
    as_json: bool,
    **loopback_options: Any,
) -> int:
    """Check whether this machine can run a robot.

    Prints each finding, with a remedy if something is wrong. The exit status is 1 if there is an error.

    With --loopback, you connect two pairs of pins of a Raspberry Pi by jumper wires. It measures the
    pins, the drivers, the ticks and the time of each kind of stop. With --robot, it also tests a motor off the
    ground. It writes a report without private data. The exit status is 1 if a rule failed.
    """
    given = {_LOOPBACK_OPTIONS[name]: bool(value) for name, value in loopback_options.items()}
    if row:
        others = {"robot": robot, "backend": backend, "port": port, "option": options, "json": as_json}
        refuse_beside("--row", **given, **{name: bool(value) for name, value in others.items()}, loopback=loopback)
        from robotcore.cli.doctor.loopback_report import format_row

        write_line(format_row(row))
        return 0
    if loopback:
        return _test_loopback(robot, backend, merge_options(options, port=port), loopback_options, as_json=as_json)
    refuse_without("--loopback", "Add --loopback", **given)
    if not (robot and backend):
        refuse_without("--robot and --backend", "Add both", port=port is not None, option=bool(options))
    found = _diagnose(robot, backend, merge_options(options, port=port))
    findings = list(found if as_json else _write_and_yield(found))
    levels = [finding.level.value for _, finding in findings]
    warnings, errors = levels.count("warning"), levels.count("error")
    status = 1 if errors else 0
    if as_json:
        write_json(_build_answer(findings, warnings, errors, status))
    else:
        write_line()
        write_line(f"{pluralize(errors, 'error')}, {pluralize(warnings, 'warning')}")
    return status


_LOOPBACK_OPTIONS = {
    "wires": "wire",
    "motor": "motor",
    "is_real_time": "rt",
    "tick_test_s": "tick_test",
    "answers": "answer",
    "report": "report",
}
"""The options of ``--loopback`` by their parameters."""


def _test_loopback(
    robot: str | None, backend: str | None, options: Mapping[str, str], values: dict[str, Any], *, as_json: bool
) -> int:
    from robotcore.cli.doctor.loopback import run_loopback
    from robotcore.description import load_robot
    from robotcore.hal.loopback import LoopbackRequest

    for option in options:
        text = f"--option {option} has no effect with --loopback. Leave it out"
        raise UsageError(text, kind="option-without-effect", option=option)
    request = LoopbackRequest(
        robot=None if robot is None else load_robot(robot),
        robot_reference=robot or "",
        wires=values["wires"],
        motor=values["motor"],
        is_real_time=values["is_real_time"],
        tick_test_s=values["tick_test_s"] or LoopbackRequest.tick_test_s,
    )
    return run_loopback(backend, request, values["answers"], values["report"], as_json=as_json)


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


def _build_answer(findings: Iterable[AboutFinding], warnings: int, errors: int, status: int) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore doctor``.

    The JSON keys:

    findings: list of objects; the results of the checks.
    findings[].about: text; the name of the backend, or ``machine``.
    findings[].*: robotcore.hal.check_finding.Finding
    warnings: whole number; the number of warnings.
    errors: whole number; the number of errors.
    exit_status: whole number; the exit status.
    """
    rows = [_row(about, finding) for about, finding in findings]
    return {"findings": rows, "warnings": warnings, "errors": errors, "exit_status": status}


def _row(about: str, finding: Finding) -> dict[str, Any]:
    return {
        "about": about,
        "level": finding.level.value,
        "kind": finding.kind,
        "subject": finding.subject,
        "message": finding.message,
        "remedy": finding.remedy,
    }
