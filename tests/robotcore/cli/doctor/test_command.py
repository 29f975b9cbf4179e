"""test_command."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore import plugins as registry
from robotcore.description import RobotDescription
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot
from tests.robotcore.cli.conftest import Cli


class Ward(Backend):
    """A board that has what a test gives it."""

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
            yield Finding.ok("robot", robot.name)
        if self.error:
            raise self.error


POLE = 'name = "pole"\n[body]\nlength_m = 0.1\nwidth_m = 0.1\nheight_m = 0.5\nclearance_m = 0.0\nmass_kg = 1.0\n'
FINE = Finding.ok("board", "number 1")
POOR = Finding.warning("power", "the voltage was low", "Take a stronger supply")
BAD = Finding.error("pins", "GPIO 17 is held by somebody", "End that program")


@pytest.fixture
def ward(monkeypatch: pytest.MonkeyPatch) -> type[Ward]:
    """The only backends are this one and one that is broken."""
    from importlib.metadata import EntryPoint

    values = {"ward": f"{__name__}:Ward", "broken": "no_such_package:Thing"}
    points = {registry.BACKENDS: {name: EntryPoint(name, value, "") for name, value in values.items()}}
    monkeypatch.setattr("robotcore.plugins._points", lambda group: points.get(group, {}))
    for name in ("found", "error", "is_here"):
        monkeypatch.setattr(Ward, name, getattr(Ward, name))
    return Ward


def test_an_error_is_exit_status_1(cli: Cli, ward: type[Ward]) -> None:
    ward.found = (FINE, POOR, BAD)
    answer = cli("doctor", "--backend", "ward")
    assert answer.status == 1
    assert answer.out.endswith("\n1 error, 1 warning\n")


def test_a_warning_alone_is_none(cli: Cli, ward: type[Ward]) -> None:
    ward.found = (FINE, POOR)
    assert cli("doctor", "--backend", "ward").status == 0


def test_each_finding_is_a_line_with_its_remedy_below(cli: Cli, ward: type[Ward]) -> None:
    ward.found = (FINE, BAD)
    lines = cli("doctor", "--backend", "ward").out.splitlines()
    assert [line.split() for line in lines[-5:-2]] == [
        ["ok", "board", "number", "1"],
        ["error", "pins", *BAD.said.split()],
        ["→", *BAD.remedy.split()],
    ]


def test_json_is_one_line_with_all_findings(cli: Cli, ward: type[Ward]) -> None:
    ward.found = (POOR, BAD)
    answer = cli("doctor", "--backend", "ward", "--json")
    assert (answer.status, answer.json["exit_status"]) == (1, 1)
    assert (answer.json["warnings"], answer.json["errors"]) == (1, 1)
    assert [each["about"] for each in answer.json["findings"]] == ["machine"] * 3 + ["ward"] * 2
    assert answer.json["findings"][-1] == {
        "about": "ward",
        "level": "error",
        "what": "pins",
        "said": BAD.said,
        "remedy": BAD.remedy,
    }


@pytest.mark.parametrize("asked, status", [(("--backend", "ward"), 1), ((), 0)])
def test_a_backend_that_is_asked_for_and_is_not_installed_is_an_error(
    cli: Cli, ward: type[Ward], monkeypatch: pytest.MonkeyPatch, asked: tuple[str, ...], status: int
) -> None:
    monkeypatch.setattr(ward, "modules", ("no_such_module",))
    ward.is_here, ward.found = True, (Finding.warning("ward", "is not installed", "pip install ward"), POOR)
    answer = cli("doctor", *asked)
    assert (answer.status, answer.out.splitlines()[-1]) == (
        status,
        f"{status} error{'' if status else 's'}, " + ("1 warning" if status else "2 warnings"),
    )


def test_on_its_own_board_a_backend_is_looked_at_alone(cli: Cli, ward: type[Ward]) -> None:
    ward.is_here = True
    assert {each["about"] for each in cli("doctor", "--json").json["findings"]} == {"machine"}
    ward.found = (FINE,)
    assert [each["about"] for each in cli("doctor", "--json").json["findings"][3:]] == ["ward"]


def test_elsewhere_all_are_looked_at_and_one_that_is_broken_is_an_error(cli: Cli, ward: type[Ward]) -> None:
    ward.found = (FINE,)
    answer = cli("doctor", "--json")
    broken, fine = answer.json["findings"][3:]
    assert (answer.status, broken["level"], fine["level"]) == (1, "error", "ok")
    assert "no_such_package" in broken["said"]
    assert broken["remedy"] == "Reinstall the package it comes from"


def test_what_a_backend_raises_is_no_traceback_and_no_ok(cli: Cli, ward: type[Ward]) -> None:
    ward.found, ward.error = (FINE,), RuntimeError("the board does not answer")
    answer = cli("doctor", "--backend", "ward")
    assert (answer.status, answer.err) == (0, "")
    assert "warning  ward          could not be checked: the board does not answer" in answer.out


def test_a_robot_is_looked_at_too(cli: Cli, ward: type[Ward], tmp_path: Path) -> None:
    pole = tmp_path / "pole.toml"
    pole.write_text(POLE, encoding="utf-8")
    found = cli("doctor", "--backend", "ward", "--robot", str(pole), "--json").json["findings"]
    assert found[-1]["said"] == "pole"


@pytest.mark.parametrize("option", [("--robot", "rovr"), ("--backend", "wrd")])
def test_an_unknown_name_is_wrong_usage(cli: Cli, ward: type[Ward], option: tuple[str, str]) -> None:
    answer = cli("doctor", *option)
    assert answer.status == 2
    assert "Did you mean" in answer.err


def test_a_broken_numpy_is_reported_and_nothing_that_needs_it_is_tried(
    cli: Cli, ward: type[Ward], monkeypatch: pytest.MonkeyPatch
) -> None:
    ward.found = (FINE,)
    broken = Finding.error("NumPy", "does not work", "pip install numpy")
    monkeypatch.setattr("robotcore.cli.doctor.machine.machine_checks", lambda: [("NumPy", lambda: [broken])])
    answer = cli("doctor", "--json")
    assert (answer.status, len(answer.json["findings"])) == (1, 1)


@pytest.mark.parametrize(
    "asked, fault",
    [
        (("--port", "7"), "option port: of which robot, on which backend? Add --robot and --backend"),
        (("--port", "7", "--robot", "rover", "--backend", "mock"), "unknown option 'port'. There are: none."),
    ],
)
def test_a_place_is_that_of_a_robot_on_a_backend_that_takes_one(cli: Cli, asked: tuple[str, ...], fault: str) -> None:
    answer = cli("doctor", *asked)
    assert answer.status == 2
    assert fault in answer.err
