"""The command on lines that wires connect, in a process of its own: its pins after each end, and its report."""

from __future__ import annotations

import getpass
import json
import os
import platform
import pty
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.loopback import stops
from drivers.raspberrypi.loopback.processes import LoopbackProgram
from robotcore.errors import BackendError, BackendMissingError
from robotcore.hal.loopback import LoopbackRequest
from tests.drivers.raspberrypi.lines import END_S, ROOT, Lines
from tests.drivers.raspberrypi.loopback.conftest import CONNECTED, WIRES
from tests.robotcore.cli.json_keys import list_disagreements
from tests.texts import CheckText, Raises

PINS = [gpio for wire in WIRES for gpio in (wire.output, wire.input)]
COMMAND = [sys.executable, "-m", "tests.drivers.raspberrypi.loopback.cli_as_pi", "doctor", "--loopback"]
PLAIN = str(ROOT / "tests" / "system" / "guest" / "robots" / "plain.toml")
CONNECT = ("--answer", "wires=ready")

Program = subprocess.Popen[str]
Launch = Callable[..., Program]


@pytest.fixture
def launch(lines: Lines) -> Iterator[Launch]:
    """Start the command with its report in the folder of the lines; the process is killed after the test."""
    programs: list[Program] = []

    def launch(*options: str, **how: Any) -> Program:
        pipe = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        environment = {**lines.environment, "FAKE_WIRES": CONNECTED}
        programs.append(subprocess.Popen([*COMMAND, *options], cwd=ROOT, env=environment, text=True, **{**pipe, **how}))
        return programs[-1]

    yield launch
    for program in programs:
        program.kill()
        with suppress(ValueError):
            program.communicate(timeout=END_S)


def read(report: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(report.read_text())
    return found


def read_verdicts(report: dict[str, Any]) -> dict[str, str]:
    return {rule["rule"]: rule["verdict"] for rule in report["rules"]}


def wait_for_rule(report: Path, rule: str, program: Program) -> None:
    end = monotonic() + END_S
    while not (report.exists() and rule in read_verdicts(read(report))):
        assert program.poll() is None, program.communicate()
        assert monotonic() < end
        sleep(0.01)


def assert_released(lines: Lines) -> None:
    assert [lines.level(gpio) for gpio in PINS] == [0] * len(PINS)
    assert all(lines.is_pulled_down(gpio) for gpio in PINS)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["wire-2", "levels", "pwm-duty-25", "quadrature-1000", "echo-300cm"])
def test_ctrl_c_at_any_step_leaves_the_pins_low_and_a_partial_report(
    launch: Launch, lines: Lines, tmp_path: Path, rule: str
) -> None:
    program = launch(*CONNECT, "--report", str(tmp_path / "r.json"))
    wait_for_rule(tmp_path / "r.json", rule, program)
    program.send_signal(signal.SIGINT)
    _, err = program.communicate(timeout=END_S)
    report = read(tmp_path / "r.json")
    assert (program.returncode, report["ended"]) == (-signal.SIGINT, "interrupted by SIGINT"), err
    assert "Traceback" not in err, err
    assert read_verdicts(report)["stop-sigkill"] == "skipped"
    assert_released(lines)


@pytest.mark.slow
def test_a_closed_terminal_ends_the_test_with_low_pins_and_a_partial_report(
    launch: Launch, lines: Lines, tmp_path: Path
) -> None:
    master, slave = pty.openpty()
    ends = {"stdin": slave, "stdout": slave, "stderr": slave}
    command = launch("--report", str(tmp_path / "r.json"), start_new_session=True, preexec_fn=_take_terminal, **ends)
    os.close(slave)
    os.write(master, b"\n")  # the wires are connected
    wait_for_rule(tmp_path / "r.json", "levels", command)
    os.close(master)
    assert command.wait(END_S) == -signal.SIGHUP
    assert read(tmp_path / "r.json")["ended"] == "interrupted by SIGHUP"
    assert_released(lines)


def _take_terminal() -> None:
    import fcntl
    import termios

    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.mark.slow
def test_a_motor_off_the_ground_is_judged_by_the_person(launch: Launch, lines: Lines, tmp_path: Path) -> None:
    answers = ("wires=skip", "lift=ready", "direction=b", "stop=y", "deadman=s")
    options = [word for answer in answers for word in ("--answer", answer)]
    options += ["--robot", PLAIN, "--motor", "right_motor", "--report", str(tmp_path / "m.json"), "--json"]
    program = launch(*options)
    out, err = program.communicate(timeout=END_S)
    found = read_verdicts(read(tmp_path / "m.json"))
    assert program.returncode == 1, err
    motor = {rule: found[rule] for rule in ("motor-direction", "motor-stop", "motor-deadman")}
    assert motor == {"motor-direction": "failed", "motor-stop": "passed", "motor-deadman": "passed"}
    assert [lines.level(gpio) for gpio in (23, 24)] == [0, 0]
    assert list_disagreements("doctor with `--loopback`", json.loads(out)) == []


@pytest.mark.slow
def test_each_way_to_stop_pulls_the_pin_low(wired_pins: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wired_pins.close()  # each way opens its own pins
    monkeypatch.setattr(stops, "TRIALS", 1)
    monkeypatch.setattr(
        LoopbackProgram, "command", [sys.executable, "-m", "tests.drivers.raspberrypi.loopback.motor_program_as_pi"]
    )
    monkeypatch.chdir(ROOT)
    with monkeypatch.context() as patched:
        patched.setenv("PYTHONPATH", f"{ROOT / 'tests/drivers/raspberrypi/lines'}{os.pathsep}{ROOT}")
        found = {result.rule: result for result in stops.measure_stops(WIRES, tmp_path, str)}
    assert {rule: each.values.get("still_high") for rule, each in found.items()} == dict.fromkeys(stops.RULES, 0)
    deadman_ms = found["stop-deadman"].values["worst_ms"]
    assert 100 < deadman_ms < 400, "the lease is 125 ms"
    assert found["stop-guardian"].values["worst_ms"] > deadman_ms


@pytest.mark.slow
def test_the_report_names_neither_host_nor_user_nor_folders(launch: Launch, tmp_path: Path) -> None:
    private = tmp_path / "my_private_robot.toml"
    private.write_text(Path(PLAIN).read_text().replace("left_motor", "my_own_motor"))
    program = launch("--answer", "wires=skip", "--answer", "lift=skip", "--robot", str(private))
    out, err = program.communicate(timeout=END_S)
    assert program.returncode == 0, err
    report = Path(ROOT, out[out.index("The report: ") :].split()[2].rstrip("."))
    try:
        text = report.read_text()
    finally:
        report.unlink()
    assert platform.node().partition(".")[0] in report.name
    secrets = (platform.node(), getpass.getuser(), str(Path.home()), str(tmp_path), "my_private_robot", "my_own_motor")
    assert [secret for secret in secrets if secret in text] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--answer", "wires=perhaps"),
        ("--answer", "cables=ready"),
        (*CONNECT, "--report", "/proc/no/such/report.json"),
        (*CONNECT, "--wire", "20:20", "--wire", "19:26"),
        (*CONNECT, "--wire", "17:21", "--wire", "19:26", "--robot", PLAIN),
        (*CONNECT, "--motor", "left_motor"),
        (*CONNECT, "--motor", "left_moter", "--robot", PLAIN),
        (*CONNECT, "--backend", "virtualpi"),
        (*CONNECT, "--backend", "kinematic"),
        (*CONNECT, "--port", "7"),
    ],
    ids=lambda options: " ".join(word.rpartition("/")[2] for word in options) or "no terminal",
)
def test_wrong_use_is_an_error_before_a_pin_is_used(
    launch: Launch, lines: Lines, options: tuple[str, ...], check_text: CheckText
) -> None:
    program = launch(*options)
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, out) == (2, "")
    check_text(err)
    assert not any(lines.is_pulled_down(gpio) for gpio in PINS)


@pytest.mark.slow
def test_a_held_pin_is_reported_with_its_rule_and_the_others_are_released(
    launch: Launch, lines: Lines, tmp_path: Path
) -> None:
    from tests.drivers.raspberrypi.lines import hold_lines

    with hold_lines(lines, 26):
        program = launch(*CONNECT, "--report", str(tmp_path / "r.json"))
        _, err = program.communicate(timeout=END_S)
    report = read(tmp_path / "r.json")
    assert program.returncode == 1, err
    reasons = {rule["rule"]: rule["reason"] for rule in report["rules"]}
    assert "GPIO 26 is held by" in reasons["wire-2"]
    assert read_verdicts(report)["levels"] == "skipped"


def test_without_a_pi_nothing_is_asked(fake_lgpio: Lines, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    from gpiozero.exc import PinUnknownPi

    def find_no_revision() -> int:
        raise PinUnknownPi("no revision")

    monkeypatch.setattr("gpiozero.pins.local.get_pi_revision", find_no_revision)
    monkeypatch.setattr(RaspberryPiBackend, "modules", ("gpiozero",))
    with raises(BackendError, "no-raspberry-pi"):
        RaspberryPiBackend().plan_loopback(LoopbackRequest())


def test_without_the_libraries_the_error_names_them(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr(RaspberryPiBackend, "modules", ("gpiozero", "no_such_library"))
    with raises(BackendMissingError):
        RaspberryPiBackend().plan_loopback(LoopbackRequest())
