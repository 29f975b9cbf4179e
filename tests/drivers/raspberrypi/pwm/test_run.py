"""Runs of the command line with the guardian on a simulated bus. They are killed, suspended or hang."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.drivers.raspberrypi.i2c_dev import Bus
from tests.drivers.raspberrypi.lines import END_S, Lines
from tests.drivers.raspberrypi.pwm.runs import Program, start_app, start_program, wait_until
from tests.texts import CheckText

Launch = Callable[[str], Program]


@pytest.fixture
def bus(tmp_path: Path) -> Bus:
    return Bus(tmp_path / "bus")


@pytest.fixture
def launch(bus: Bus, lines: Lines) -> Iterator[Launch]:
    """Start a run of an app; the process is killed after the test."""
    programs: list[Program] = []

    def launch(app: str) -> Program:
        programs.append(program := start_app(bus, lines, app))
        return program

    yield launch
    for program in programs:
        program.kill()
        program.communicate(timeout=END_S)


@pytest.mark.slow
def test_every_channel_is_off_after_a_kill(launch: Launch, bus: Bus) -> None:
    program = launch("endless_drive")
    wait_until(bus, program, turning=True)
    program.kill()
    _, err = program.communicate(timeout=END_S)
    assert "Stopped: left_motor, right_motor" in err
    assert set(bus.duties()) == {0.0}
    last = list(bus.transfers())[-1]
    assert (last.register, last.values) == (0xFD, b"\x10")
    assert last.process != program.pid


@pytest.mark.slow
@pytest.mark.parametrize("number, status", [(signal.SIGTERM, -signal.SIGTERM), (signal.SIGINT, -signal.SIGINT)])
def test_every_channel_is_off_after_a_signal(launch: Launch, bus: Bus, number: int, status: int) -> None:
    program = launch("endless_drive")
    wait_until(bus, program, turning=True)
    program.send_signal(number)
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, json.loads(out)["outcome"]) == (status, "interrupted"), err
    assert set(bus.duties()) == {0.0}


@pytest.mark.slow
def test_motors_of_a_suspended_run_stop_and_turn_again_when_it_continues(launch: Launch, bus: Bus) -> None:
    program = launch("endless_drive")
    wait_until(bus, program, turning=True)
    program.send_signal(signal.SIGSTOP)
    wait_until(bus, program, turning=False)
    program.send_signal(signal.SIGCONT)
    wait_until(bus, program, turning=True)


@pytest.mark.slow
def test_run_that_hangs_is_not_killed_and_its_motors_stand(launch: Launch, bus: Bus) -> None:
    program = launch("process_failure")
    wait_until(bus, program, turning=True)
    wait_until(bus, program, turning=False)
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, err) == (0, "")
    assert json.loads(out)["outcome"] == "success"
    assert set(bus.duties()) == {0.0}


@pytest.mark.slow
def test_unplugged_chip_ends_the_run_with_its_name(launch: Launch, bus: Bus) -> None:
    program = launch("endless_drive")
    wait_until(bus, program, turning=True)
    bus.unplug()
    out, _ = program.communicate(timeout=END_S)
    assert program.returncode == 3
    assert "no answer at I2C 0x60 on bus 1" in json.loads(out)["reason"]


@pytest.mark.slow
def test_hung_bus_ends_the_run(launch: Launch, bus: Bus) -> None:
    program = launch("endless_drive")
    wait_until(bus, program, turning=True)
    bus.hang(0.1)
    out, _ = program.communicate(timeout=END_S)
    assert program.returncode == 3
    assert json.loads(out)["outcome"] == "error"


@pytest.mark.slow
def test_robotcore_stop_switches_every_channel_off(lines: Lines, bus: Bus) -> None:
    bus.switch_on()
    program = start_program(bus, lines, "stop")
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, out, err) == (0, "pwm_chip: stopped left_motor, right_motor\n", "")
    assert set(bus.duties()) == {0.0}


@pytest.mark.slow
def test_robotcore_stop_names_a_run_that_turns_its_motors_on_again(
    launch: Launch, lines: Lines, bus: Bus, check_text: CheckText
) -> None:
    run = launch("endless_drive")
    wait_until(bus, run, turning=True)
    program = start_program(bus, lines, "stop")
    out, err = program.communicate(timeout=END_S)
    assert (program.returncode, out) == (3, "")
    check_text(err)
    assert run.poll() is None
