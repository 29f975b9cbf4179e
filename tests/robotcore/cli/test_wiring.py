from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.cli.wiring import FREE, USED, draw_connector
from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.hardware.device_drivers import EYE, NECK, register, robot_file
from tests.texts import CheckText

LONG = "a_device_with_a_name_that_nobody_would_want_to_write"


@pytest.fixture
def post(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    register(monkeypatch)
    file = tmp_path / "post.toml"
    file.write_text(robot_file(NECK + EYE))
    return str(file)


def test_each_wire_has_a_row_and_a_pad(cli: Cli, post: str) -> None:
    answer = cli("wiring", post, "--backend", "plugboard")
    assert (answer.status, answer.err) == (0, "")
    lines = answer.out.splitlines()
    assert [line.split() for line in lines if line.startswith(("neck", "eye"))] == [
        ["neck", "pin", "hole", "1", "1", "motor,", "motor-plug"],
        ["eye", "pin", "hole", "2", "2", "camera,", "plug"],
    ]
    (pads,) = (line for line in lines if "│" in line)
    shown = ["neck", "pin", "GPIO", "1", USED, "1", "2", USED, "ground", "eye", "pin"]
    assert pads.replace("│", " ").split() == shown


def test_a_table_without_a_connector_has_no_column_of_pads(cli: Cli) -> None:
    answer = cli("wiring", "rover", "--backend", "serial").out.splitlines()
    assert answer[0] == "rover on serial"
    assert answer[2].split() == ["device", "signal", "goes", "to", "description"]
    assert answer[4].split() == ["left_motor", "port", "serial", "/dev/ttyACM0", "motor,", "ros-arduino-motor"]


def test_the_default_is_the_robot_of_the_project(
    cli: Cli, post: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pyproject.toml").write_text('[tool.robotcore]\nrobot = "post.toml"\n')
    assert cli("wiring", "--backend", "plugboard", "--json").json["robot"] == "post.toml"


def test_a_note_is_printed_once_with_all_its_devices(cli: Cli, post: str) -> None:
    assert "- neck, eye: Push it in all the way.\n" in cli("wiring", post, "--backend", "plugboard").out


def test_json_has_wires_pads_and_notes(cli: Cli, post: str) -> None:
    answer = cli("wiring", post, "--backend", "plugboard", "--json").json
    assert (answer["robot"], answer["backend"]) == (post, "plugboard")
    assert answer["wires"][0] == {
        "device": "neck",
        "what": "motor, motor-plug",
        "signal": "pin",
        "where": "hole 1",
        "pads": [1],
    }
    assert answer["pads"][1] == {"number": 2, "name": "ground", "kind": "ground"}
    assert answer["notes"][0] == {"device": "neck", "note": "Push it in all the way."}


def row(*wires: Wire) -> str:
    pads = (Pad(1, "GPIO 2", PadKind.SIGNAL), Pad(2, "5 V", PadKind.POWER))
    return list(draw_connector(Wiring(pads, wires, ())))[1]


def test_devices_whose_names_are_too_long_for_a_row_are_counted() -> None:
    wires = (
        Wire(f"{side}_{kind}", "", "sends", "", (1,)) for side in ("left", "right") for kind in ("motor", "encoder")
    )
    assert "4 devices sends" in row(*wires)


def test_no_row_of_the_drawing_is_wider_than_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("click.style", lambda words, *_, **__: words)
    drawn = row(Wire(LONG, "", "forward", "", (1,)), Wire(LONG, "", "supply", "", (2, 4)))
    assert len(drawn) <= 100
    assert drawn.count("…") == 2
    assert drawn.count(USED) == 2


def test_devices_that_share_a_pad_are_reported_with_their_signal_once() -> None:
    shared = (Wire(name, "", "standby", "", (1,)) for name in ("left", "right"))
    assert "left + right standby" in row(*shared)


def test_a_wire_is_drawn_at_its_best_pad_only() -> None:
    drawn = row(Wire("nose", "", "supply", "", (4, 2)))
    assert USED not in drawn
    assert drawn.count(FREE) == 2


@pytest.mark.parametrize("options", [("kinematic",), ("plugboard", "--port", "7")], ids=["no wires", "unknown option"])
def test_a_wrong_backend_or_option_is_refused(
    cli: Cli, post: str, options: tuple[str, ...], check_text: CheckText
) -> None:
    answer = cli("wiring", post, "--backend", *options)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


@pytest.mark.parametrize("command", [("wiring", "rover"), ("doctor", "--robot", "rover"), ("stop",)])
def test_the_option_port_replaces_the_port_in_the_robots_file(cli: Cli, command: tuple[str, ...]) -> None:
    answer = cli(*command, "--backend", "serial", "--port", "/dev/elsewhere")
    assert "/dev/elsewhere" in answer.out + answer.err
    assert "/dev/ttyACM0" not in answer.out
