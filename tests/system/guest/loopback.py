"""`robotcore doctor --loopback` on the lines of a kernel, which a program connects as wires do."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.system.guest.bench import start_process, wait_until
from tests.system.guest.chip import Chip
from tests.system.speed import scaled

WIRES = ((20, 21), (19, 26))
PINS = [gpio for wire in WIRES for gpio in wire]
STOPS = ("stop-command", "stop-deadman", "stop-sigterm", "stop-sigkill", "stop-guardian")
SURE = ("wire-1", "wire-2", "levels")
"""The rules that hold at any speed of the processor."""

WHOLE_S = 60
"""The time limit of a whole test, on the reference machine."""

COMMAND = [sys.executable, "-m", "tests.system.guest.scaled_loopback", "doctor", "--loopback", "--tick-test", "1"]


@pytest.fixture(autouse=True)
def _lines_keep_their_level(chip: Chip) -> None:
    chip.set_persistent(is_persistent=True)


@contextmanager
def connect(chip: Chip, *wires: tuple[int, int]) -> Iterator[subprocess.Popen[str]]:
    """Connect lines by wires during the block. Each wire has a first end, whose level the second end gets."""
    ends = [(chip.file(a, "value"), chip.file(b, "value"), chip.file(b, "pull")) for a, b in wires]
    command = [os.environ["WIRES_HELPER"], *(str(file) for files in ends for file in files)]
    with start_process(command) as bridge:
        assert bridge.stdout
        assert bridge.stdout.readline() == "ready\n"
        yield bridge


def command(report: Path, *options: str) -> list[str]:
    return [*COMMAND, "--report", str(report), "--answer", "wires=ready", *options]


def read_verdicts(report: dict[str, Any]) -> dict[str, str]:
    return {rule["rule"]: rule["verdict"] for rule in report["rules"]}


def read(report: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(report.read_text())
    return found


def wait_for_rule(report: Path, rule: str, program: subprocess.Popen[str]) -> None:
    """Wait until the report has a rule; the check's time limit ends a wait in vain."""
    while not (report.exists() and rule in read_verdicts(read(report))):
        assert program.poll() is None, program.communicate()
        time.sleep(0.05)


def has_free_low_pins(chip: Chip) -> bool:
    """Return whether all lines of the wires are low, have a pull-down, and can be claimed."""
    claim = f"import lgpio; c = lgpio.gpiochip_open(0); [lgpio.gpio_claim_input(c, gpio) for gpio in {PINS}]"
    is_free = not subprocess.run([sys.executable, "-c", claim], check=False, capture_output=True).returncode
    return is_free and wait_until(chip.high, []) == []


@pytest.mark.timeout(scaled(WHOLE_S))
def test_the_whole_test_measures_over_two_wires_and_every_stop_pulls_the_pin_low(chip: Chip, tmp_path: Path) -> None:
    """Times on an emulated processor are not those of a Pi. So only levels and counts are checked."""
    with connect(chip, *WIRES):
        run = subprocess.run(command(tmp_path / "r.json", "--rt"), capture_output=True, text=True, check=False)
    print(run.stdout, run.stderr)  # in the log of the guest
    report = read(tmp_path / "r.json")
    found = read_verdicts(report)
    assert (report["ended"], run.returncode) == ("complete", report["exit_status"]), run.stderr
    assert {rule: found[rule] for rule in SURE} == dict.fromkeys(SURE, "passed"), run.stdout
    values = {rule["rule"]: rule["values"] for rule in report["rules"]}
    assert values["pulses-200"]["lost"] < values["pulses-200"]["edges"]
    assert {stop: values[stop].get("still_high") for stop in STOPS} == dict.fromkeys(STOPS, 0)
    assert {stop: values[stop].get("edges_backward") for stop in STOPS} == dict.fromkeys(STOPS, 0)
    assert values["ticks-20hz-rt"]["priority"] == 20
    assert has_free_low_pins(chip)


def test_a_wire_on_another_pin_is_found_and_nothing_is_driven(chip: Chip, tmp_path: Path) -> None:
    with connect(chip, (20, 26), (19, 21)):
        run = subprocess.run(command(tmp_path / "r.json"), capture_output=True, text=True, check=False)
    rules = {rule["rule"]: rule for rule in read(tmp_path / "r.json")["rules"]}
    assert "is on GPIO 26" in rules["wire-1"]["reason"], run.stderr
    assert run.returncode == 1
    assert {verdict for rule, verdict in read_verdicts(read(tmp_path / "r.json")).items() if "wire" not in rule} == {
        "skipped"
    }
    assert has_free_low_pins(chip)


@pytest.mark.timeout(scaled(WHOLE_S))
def test_a_wire_that_is_lost_during_the_test_ends_the_measurements_and_every_pin_is_low(
    chip: Chip, tmp_path: Path
) -> None:
    report = tmp_path / "r.json"
    with connect(chip, *WIRES) as bridge, start_process(command(report)) as program:
        wait_for_rule(report, "output-latency", program)
        bridge.kill()
        program.wait(scaled(WHOLE_S))
    found = read_verdicts(read(report))
    assert found["levels"] == "passed"
    assert {found[stop] for stop in STOPS} == {"failed"}
    assert has_free_low_pins(chip)


@pytest.mark.parametrize("rule", ["levels", "stop-command"])
@pytest.mark.timeout(scaled(WHOLE_S))
def test_ctrl_c_leaves_every_pin_low_and_a_partial_report(chip: Chip, tmp_path: Path, rule: str) -> None:
    report = tmp_path / "r.json"
    with connect(chip, *WIRES), start_process(command(report)) as program:
        wait_for_rule(report, rule, program)
        program.send_signal(signal.SIGINT)
        assert program.wait(scaled(WHOLE_S)) == -signal.SIGINT
    assert read(report)["ended"] == "interrupted by SIGINT"
    assert has_free_low_pins(chip)
