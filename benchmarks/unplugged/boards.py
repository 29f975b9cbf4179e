"""The boards of `benchmarks.serial_unplugged`: their doubles, and the files of their robots."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from tests.doubles.serial.board import BoardDouble, Wheels
from tests.doubles.serial.hoverboard import Hoverboard
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.doubles.serial.sabertooth import Sabertooths
from tests.doubles.serial.waveshare import WaveshareBoard

FULL_RAD_S = 16.0
PATIENCE_S = 30.0

Section = Mapping[str, Any]


@dataclass(frozen=True)
class BoardModel:
    """A model of a board: its double, and the sections of its devices in a robot's file."""

    make: Callable[[], BoardDouble]
    wheels_of: Callable[[Any], Wheels]
    motor: Section
    encoder: Section | None


def _wheels(board: Any) -> Wheels:
    wheels: Wheels = board.wheels
    return wheels


def _wheels_of_the_first(board: Sabertooths) -> Wheels:
    return board.boards[128].wheels


_MODEL = {"model": {"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}}

BOARDS = {
    "our firmware": BoardModel(
        RobotcoreBridgeDouble, _wheels, {"driver": "ros-arduino-motor"}, {"driver": "ros-arduino-encoder"}
    ),
    "ROSArduinoBridge": BoardModel(
        RosArduinoBridgeDouble, _wheels, {"driver": "ros-arduino-motor"}, {"driver": "ros-arduino-encoder"}
    ),
    "Waveshare UGV": BoardModel(
        lambda: WaveshareBoard(2 * 0.0325), _wheels, {"driver": "waveshare-motor"}, {"driver": "waveshare-encoder"}
    ),
    "hoverboard": BoardModel(
        lambda: Hoverboard(Wheels()),
        _wheels,
        {"driver": "hoverboard-motor", "mode": "speed"},
        {"driver": "hoverboard-encoder"},
    ),
    "Sabertooth": BoardModel(
        lambda: Sabertooths(full_rad_s=FULL_RAD_S),
        _wheels_of_the_first,
        {"driver": "sabertooth-motor", **_MODEL},
        None,
    ),
}


def build_robot_file(kind: BoardModel, port: Path) -> str:
    """Return the description of a rover whose board is at a port, as TOML. The rover waits if the port is lost."""
    rover = (resources.files("robotcore.description") / "robots" / "rover.toml").read_text(encoding="utf-8")
    body = rover.partition("[[devices]]")[0].replace("[safety]", f"[safety]\noutage_s = {PATIENCE_S}")
    if kind.encoder is None:
        body = "".join(line for line in body.splitlines(keepends=True) if "_encoder =" not in line)
    return body + "".join(_build_device(kind, side, number, port) for number, side in enumerate(("left", "right"), 1))


def _build_device(kind: BoardModel, side: str, number: int, port: Path) -> str:
    place = {"motor": number} if kind.encoder is None else {"side": side}
    text = f'[[devices]]\nkind = "motor"\nname = "{side}_motor"\nmax_velocity_rad_s = 12.0\n'
    text += _section(f"{side}_motor", {**kind.motor, **place, "port": str(port)})
    if kind.encoder:
        text += f'[[devices]]\nkind = "encoder"\nname = "{side}_encoder"\ncounts_per_turn = 960\n'
        text += _section(f"{side}_encoder", {**kind.encoder, **place, "port": str(port)})
    return text


def _section(name: str, table: Section) -> str:
    lines = (f"{key} = {_value(value)}\n" for key, value in table.items())
    return f"[serial.{name}]\n{''.join(lines)}"


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_value(each)}' for key, each in value.items())} }}"
    return json.dumps(value)
