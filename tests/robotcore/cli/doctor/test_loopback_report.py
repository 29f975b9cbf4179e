from __future__ import annotations

import getpass
import json
import os
import platform
from pathlib import Path
from typing import Any

import pytest

from robotcore.cli.doctor.loopback_report import COMPLETE, UNFINISHED, LoopbackReport, format_row, hide_private
from robotcore.errors import UsageError
from robotcore.hal.loopback import LoopbackRequest, RuleResult
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText, Raises

PASSED = RuleResult.from_measurement("ticks-20hz", "p50 1 ms", "p99 25 ms", is_met=True, worst_ms=31.5)
FAILED = RuleResult.from_measurement(
    "stop-sigkill", "worst 400 ms", "at most 300 ms", is_met=False, reason="No", worst_ms=400.0
)


def build(*results: RuleResult) -> LoopbackReport:
    board = {"model": "Raspberry Pi 4 Model B Rev 1.4", "lgpio": "0.2.2.0"}
    report = LoopbackReport(LoopbackRequest(), [(20, 21)], board, ["ticks-20hz", "stop-sigkill", "motor-stop"])
    report.results += results
    return report


def test_a_report_that_was_not_ended_says_so() -> None:
    assert build(PASSED).to_dict()["ended"] == UNFINISHED


def test_rules_that_were_not_reached_are_skipped_with_the_reason() -> None:
    report = build(PASSED)
    report.end("interrupted by SIGINT")
    found = report.to_dict()
    assert [(rule["rule"], rule["verdict"]) for rule in found["rules"]][1:] == [
        ("stop-sigkill", "skipped"),
        ("motor-stop", "skipped"),
    ]
    assert found["rules"][2]["reason"] == "not reached: interrupted by SIGINT"
    assert (found["passed"], found["skipped"], found["exit_status"]) == (1, 2, 1)


@pytest.mark.parametrize("results, status", [((PASSED,), 0), ((PASSED, FAILED), 1)])
def test_the_exit_status_is_1_if_a_rule_failed(results: tuple[RuleResult, ...], status: int) -> None:
    report = build(*results)
    report.end(COMPLETE)
    assert report.exit_status == status


def test_the_report_has_versions_and_the_model() -> None:
    found = build().to_dict()
    assert found["board"]["model"].startswith("Raspberry Pi 4")
    assert {"robotcore", "python", "kernel", "machine", "os", "processors"} <= found.keys()


@pytest.mark.parametrize(
    "text, hidden",
    [
        (f"{Path.home()}/my/robot.toml: wrong", "…: wrong"),
        ("my_robot.toml: wrong, at ../secret_app.py:12", "…: wrong, at …:12"),
        ("held by process 812 (secret_app)", "held by another program"),
        ("no permission for /dev/gpiochip0", "no permission for /dev/gpiochip0"),
        ("at 1000 edges/s, 3 / 4", "at 1000 edges/s, 3 / 4"),
        ("the board /dev/serial/by-id/usb-Arduino_7503030373535140A1-if00", "the board …"),
        ("serial 00000000a1b2c3d4 at 192.168.1.20, lgpio 0.2.2.0", "serial … at …, lgpio 0.2.2.0"),
        ("/proc/812/fd and ~alice/robot", "… and …"),
        ("from fe80::dea6:32ff:fe01:203, dc:a6:32:01:02:03", "from …, …"),
        ("off by 0.333333333333 s at GPIO 20:21", "off by 0.333333333333 s at GPIO 20:21"),
        ("held by process 8 (a (b) c)", "held by another program"),
        (f"on {platform.node()} for {getpass.getuser()}!", "on … for …!"),
    ],
)
def test_private_parts_of_a_text_are_hidden(text: str, hidden: str) -> None:
    assert hide_private(text) == hidden


def test_a_row_has_the_columns_of_the_table(tmp_path: Path) -> None:
    report = build(PASSED, FAILED)
    report.end(COMPLETE)
    report.save(tmp_path / "pi.json")
    saved = json.loads((tmp_path / "pi.json").read_text())
    row = format_row(tmp_path / "pi.json")
    quality = Path(__file__).parents[4] / "drivers" / "raspberrypi" / "QUALITY.md"
    header = next(line for line in quality.read_text().splitlines() if line.startswith("| Model |"))
    assert row.count("|") == header.count("|")
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert cells[0] == "Raspberry Pi 4 Model B Rev 1.4"
    assert cells[2:] == [
        saved["robotcore"],
        "1 / 1 / 1",
        "31.5 / –",
        "– / – / – / 400.0 / –",
        "[report](reports/pi.json)",
    ]


def test_the_row_of_a_partial_report_says_so(tmp_path: Path) -> None:
    build(PASSED).save(tmp_path / "pi.json")
    assert "1 / 0 / 0, not complete" in format_row(tmp_path / "pi.json")


def test_a_file_that_is_no_report_is_an_error(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "other.json").write_text('{"format": 7}')
    with raises(UsageError, "no-report", file=str(tmp_path / "other.json")):
        format_row(tmp_path / "other.json")


def test_a_rule_keeps_its_name_if_the_user_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("getpass.getuser", lambda: "stop")
    assert build(FAILED).to_dict()["rules"][0]["rule"] == "stop-sigkill"


def test_a_row_makes_neither_links_nor_mentions_of_a_strangers_texts(tmp_path: Path) -> None:
    saved = build(PASSED).to_dict()
    saved["board"]["model"], saved["os"] = "@someone #1 $x$ www.evil.example", "https://evil.example/x"
    (tmp_path / "pi.json").write_text(json.dumps(saved))
    row = format_row(tmp_path / "pi.json")
    assert r"@<!-- -->someone #<!-- -->1 \$x\$ www\.evil.example" in row
    assert r"https\://evil.example/x" in row


@pytest.mark.parametrize(
    "part",
    [
        {"format": True},
        {"rules": [{"rule": "ticks-20hz", "verdict": "passed", "values": {"worst_ms": -1.0}}]},
        {"rules": [{"rule": "ticks-20hz", "verdict": "passed"}] * 2},
    ],
    ids=["a boolean format", "a negative duration", "a rule twice"],
)
def test_a_report_with_an_impossible_value_is_refused(tmp_path: Path, part: dict[str, Any], raises: Raises) -> None:
    (tmp_path / "pi.json").write_text(json.dumps({**build(PASSED).to_dict(), **part}))
    with raises(UsageError, "no-report", file=str(tmp_path / "pi.json")):
        format_row(tmp_path / "pi.json")


def test_a_missing_file_is_an_error(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "unreadable-file"):
        format_row(tmp_path / "none.json")


@pytest.mark.parametrize("option", [("--wire", "20:21"), ("--motor", "m"), ("--rt",), ("--answer", "a=b")])
def test_an_option_of_the_loopback_test_needs_it(cli: Cli, option: tuple[str, ...], check_text: CheckText) -> None:
    answer = cli("doctor", *option)
    assert answer.status == 2
    check_text(answer.err)


@pytest.mark.parametrize("wire", ["20-21", "9" * 5000 + ":21"], ids=["another sign", "a huge number"])
def test_a_wire_is_two_gpios(cli: Cli, wire: str, check_text: CheckText) -> None:
    answer = cli("doctor", "--loopback", "--wire", wire)
    assert answer.status == 2
    check_text(answer.err)


@pytest.mark.parametrize(
    "options", [("--loopback",), ("--robot", "rover"), ("--wire", "20:21"), ("--rt",), ("--port", "7")], ids=" ".join
)
def test_an_option_beside_row_is_refused(cli: Cli, tmp_path: Path, options: tuple[str, ...]) -> None:
    answer = cli("doctor", "--row", str(tmp_path / "pi.json"), *options)
    assert answer.status == 2
    assert options[0] in answer.err


def test_the_texts_of_another_persons_report_are_escaped_in_a_row(tmp_path: Path) -> None:
    save_changed(tmp_path / "pi.json", os="<script>x</script> | [a](b)\n`c`", board={"model": "a|b"})
    row = format_row(tmp_path / "pi.json")
    assert "\n" not in row
    assert row.replace("\\|", "").count("|") == 8
    assert "\\<script\\>" in row


@pytest.mark.parametrize(
    "changes",
    [
        {"os": 7},
        {"os": "x" * 201},
        {"rules": [{"rule": "ticks-20hz", "verdict": "passed", "values": {"worst_ms": 1e300}}]},
        {"rules": [{"rule": "ticks-20hz", "verdict": "passed", "values": {"worst_ms": float("nan")}}]},
        {"rules": [{"rule": "ticks-20hz", "verdict": "perfect"}]},
    ],
    ids=str,
)
def test_odd_values_in_a_report_are_an_error(tmp_path: Path, changes: dict[str, Any], raises: Raises) -> None:
    save_changed(tmp_path / "pi.json", **changes)
    with raises(UsageError, "no-report", file=str(tmp_path / "pi.json")):
        format_row(tmp_path / "pi.json")


def test_the_counts_of_a_row_are_those_of_the_rules(tmp_path: Path) -> None:
    save_changed(tmp_path / "pi.json", passed=99, failed=0)
    assert "1 / 1 / 0" in format_row(tmp_path / "pi.json")


def save_changed(file: Path, **changes: Any) -> None:
    build(PASSED, FAILED).save(file)
    file.write_text(json.dumps({**json.loads(file.read_text()), **changes}))


@pytest.mark.parametrize(
    "name, kind", [("fifo", "no-regular-file"), ("zero", "no-regular-file"), ("huge", "file-too-large")]
)
def test_a_pipe_a_device_and_a_huge_file_are_refused_at_once(
    tmp_path: Path, name: str, kind: str, raises: Raises
) -> None:
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "zero").symlink_to("/dev/zero")
    with (tmp_path / "huge").open("wb") as huge:
        huge.truncate(1_000_000_001)
    with raises(UsageError, kind):
        format_row(tmp_path / name)
