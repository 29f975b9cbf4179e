from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore import plugins as registry
from robotcore.description import RobotDescription
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.robot import Robot
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText


class FindingBackend(Backend):
    """A backend with the findings that a test sets."""

    name = "ward"
    summary = "for tests"
    found: tuple[Finding, ...] = ()
    error: Exception | None = None
    is_here = False
    is_smoke_tested = False

    def open(self, setup: Setup) -> Robot:
        raise NotImplementedError

    @property
    def is_native_host(self) -> bool:
        return self.is_here

    def examine(self, robot: RobotDescription | None) -> Iterator[Finding]:
        yield from self.found
        if robot:
            yield Finding.ok("robot", robot.name, kind="robot")
        if self.error:
            raise self.error


POLE = 'name = "pole"\n[body]\nlength_m = 0.1\nwidth_m = 0.1\nheight_m = 0.5\nclearance_m = 0.0\nmass_kg = 1.0\n'
FINE = Finding.ok("board", "number 1", kind="board")
POOR = Finding.warning("power", "the voltage was low", "Take a stronger supply", kind="low-voltage")
BAD = Finding.error("pins", "another program holds GPIO 17", "End that program", kind="pin-held")


@pytest.fixture
def ward(monkeypatch: pytest.MonkeyPatch) -> type[FindingBackend]:
    """Install only the backend ``ward`` and a broken one."""
    from importlib.metadata import EntryPoint

    values = {"ward": f"{__name__}:FindingBackend", "broken": "no_such_package:Thing"}
    points = {registry.BACKENDS: {name: EntryPoint(name, value, "") for name, value in values.items()}}
    monkeypatch.setattr("robotcore.plugins._points", lambda group: points.get(group, {}))
    monkeypatch.setattr("robotcore.cli.doctor.machine.IS_LINUX", True)
    for name in ("found", "error", "is_here"):
        monkeypatch.setattr(FindingBackend, name, getattr(FindingBackend, name))
    return FindingBackend


def test_each_finding_is_a_line_with_its_remedy_below_and_an_error_has_exit_status_1(
    cli: Cli, ward: type[FindingBackend], tmp_path: Path, check_text: CheckText
) -> None:
    pole = tmp_path / "pole.toml"
    pole.write_text(POLE, encoding="utf-8")
    ward.found = (FINE, POOR)
    arguments = ("doctor", "--backend", "ward", "--robot", str(pole))
    assert cli(*arguments).status == 0
    ward.found = (FINE, POOR, BAD)
    answer = cli(*arguments)
    assert answer.status == 1
    check_text("\n".join(answer.out.splitlines()[3:]))


def test_json_is_one_line_with_all_findings(cli: Cli, ward: type[FindingBackend]) -> None:
    ward.found = (POOR, BAD)
    answer = cli("doctor", "--backend", "ward", "--json")
    assert (answer.status, answer.json["exit_status"]) == (1, 1)
    assert (answer.json["warnings"], answer.json["errors"]) == (1, 1)
    assert [each["about"] for each in answer.json["findings"]] == ["machine"] * 3 + ["ward"] * 2
    assert answer.json["findings"][-1] == {
        "about": "ward",
        "level": "error",
        "kind": BAD.kind,
        "subject": "pins",
        "message": BAD.message,
        "remedy": BAD.remedy,
    }


@pytest.mark.parametrize("arguments, status", [(("--backend", "ward"), 1), ((), 0)])
def test_a_chosen_backend_that_is_not_installed_is_an_error(
    cli: Cli,
    ward: type[FindingBackend],
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    status: int,
    check_text: CheckText,
) -> None:
    monkeypatch.setattr(ward, "modules", ("no_such_module",))
    ward.is_here, ward.found = (
        True,
        (Finding.warning("ward", "is not installed", "pip install ward", kind="not-installed"), POOR),
    )
    answer = cli("doctor", *arguments)
    assert answer.status == status
    check_text(answer.out.splitlines()[-1])


@pytest.mark.parametrize("arguments, level", [(("--backend", "ward"), "error"), ((), "warning")])
def test_a_server_that_does_not_run_is_an_error_only_for_a_chosen_backend(
    cli: Cli, ward: type[FindingBackend], arguments: tuple[str, ...], level: str
) -> None:
    ward.is_here = True
    ward.found = (Finding.warning("ward", "no server listens", "Start it", kind="connection-refused"),)
    assert cli("doctor", *arguments, "--json").json["findings"][-1]["level"] == level


def test_only_the_backend_of_this_board_is_checked(cli: Cli, ward: type[FindingBackend]) -> None:
    ward.is_here = True
    assert {each["about"] for each in cli("doctor", "--json").json["findings"]} == {"machine"}
    ward.found = (FINE,)
    assert [each["about"] for each in cli("doctor", "--json").json["findings"][3:]] == ["ward"]


def test_on_an_unknown_board_all_backends_are_checked_and_a_broken_one_is_an_error(
    cli: Cli, ward: type[FindingBackend], check_text: CheckText
) -> None:
    ward.found = (FINE,)
    answer = cli("doctor", "--json")
    broken, fine = answer.json["findings"][3:]
    assert (answer.status, broken["level"], fine["level"]) == (1, "error", "ok")
    check_text(f"{broken['message']}\n{broken['remedy']}")


def test_a_robot_without_a_section_is_reported_only_if_the_backend_is_chosen(
    cli: Cli, ward: type[FindingBackend]
) -> None:
    ward.found = (Finding.warning("robot", "it has no section", "Name another robot", kind="no-section"),)
    shown = [cli("doctor", *backend, "--json").json["findings"] for backend in ([], ["--backend", "ward"])]
    assert ["no-section" in [each["kind"] for each in findings] for findings in shown] == [False, True]


def test_an_exception_of_a_check_becomes_a_warning(cli: Cli, ward: type[FindingBackend], check_text: CheckText) -> None:
    ward.found, ward.error = (FINE,), RuntimeError("the board does not answer")
    answer = cli("doctor", "--backend", "ward")
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out.splitlines()[-3])


@pytest.mark.parametrize("option", [("--robot", "rovr"), ("--backend", "wrd")])
def test_an_unknown_name_is_wrong_usage(
    cli: Cli, ward: type[FindingBackend], option: tuple[str, str], check_text: CheckText
) -> None:
    answer = cli("doctor", *option)
    assert answer.status == 2
    check_text(answer.err)


def test_a_broken_numpy_is_reported_and_no_backend_is_checked(
    cli: Cli, ward: type[FindingBackend], monkeypatch: pytest.MonkeyPatch
) -> None:
    ward.found = (FINE,)
    broken = Finding.error("NumPy", "does not work", "pip install numpy", kind="library-broken")
    monkeypatch.setattr("robotcore.cli.doctor.machine.list_machine_checks", lambda: [("NumPy", lambda: [broken])])
    answer = cli("doctor", "--json")
    assert (answer.status, len(answer.json["findings"])) == (1, 1)


@pytest.mark.parametrize("arguments", [("--port", "7"), ("--port", "7", "--robot", "rover", "--backend", "mock")])
def test_an_option_needs_a_robot_and_a_backend_that_has_it(
    cli: Cli, arguments: tuple[str, ...], check_text: CheckText
) -> None:
    answer = cli("doctor", *arguments)
    assert answer.status == 2
    check_text(answer.err)
