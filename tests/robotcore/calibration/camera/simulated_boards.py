"""Pictures of a chessboard on the floor by the project's own simulated camera, with a described lens and noise."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
import tomlkit

import robotcore
from robotcore.calibration.camera.board import Board
from robotcore.description import read_shipped
from robotcore.optics import Image, Intrinsics

BOARD = Board(9, 6, 0.03)
SIZE = (640, 480)
TEXEL_PX = 40
VIEWS = 24


def take_floor_pictures(random_: random.Random, views: int = VIEWS) -> tuple[Iterator[Image], Intrinsics, Board]:
    """Return grey pictures, the true intrinsics of the camera, and the board."""
    width, height = SIZE
    fov = random_.uniform(0.9, 1.2)
    centre = width / 2 + random_.uniform(-8, 8), height / 2 + random_.uniform(-8, 8)
    distortion = random_.uniform(-0.2, 0.05), random_.uniform(0.0, 0.05), 0.0, 0.0, 0.0
    camera: dict[str, Any] = {
        "width_px": width,
        "height_px": height,
        "horizontal_fov_rad": fov,
        "centre_px": list(centre),
        "distortion": list(distortion),
        "noise_levels": random_.uniform(0.5, 3.0),
    }
    truth = Intrinsics(*SIZE, fov, centre, distortion)
    return _take(camera, random_, views), truth, BOARD


def _take(camera: dict[str, Any], random_: random.Random, views: int) -> Iterator[Image]:
    with TemporaryDirectory() as name:
        folder = Path(name)
        _write_picture(folder / "board.png")
        robot = tomlkit.parse(read_shipped("lookout")).unwrap()
        for _ in range(views):
            _write_scene(folder, robot, camera, random_)
            with robotcore.open(str(folder / "robot.toml"), world=str(folder / "world.toml")) as live:
                yield live.camera.read().grey


def _write_picture(file: Path) -> None:
    cells = np.add.outer(np.arange(BOARD.rows + 1), np.arange(BOARD.columns + 1)) % 2
    squares = np.kron(np.where(cells, 235, 25), np.ones((TEXEL_PX, TEXEL_PX))).astype(np.uint8)
    cv2.imwrite(str(file), np.repeat(np.pad(squares, TEXEL_PX, constant_values=235)[..., None], 3, axis=2))


def _write_scene(folder: Path, robot: dict[str, Any], camera: dict[str, Any], random_: random.Random) -> None:
    pitch, yaw = random_.uniform(0.55, 1.35), random_.uniform(-math.pi, math.pi)
    width_m = (BOARD.columns + 1) * BOARD.square_m
    distance = width_m / random_.uniform(0.45, 0.8) / (2 * math.tan(camera["horizontal_fov_rad"] / 2))
    height, ahead = distance * math.sin(pitch), distance * math.cos(pitch)
    aside = [random_.uniform(-0.2, 0.2) * width_m for _ in range(2)]
    eye = {"kind": "camera", "name": "eye", "mount": {"z_m": height, "pitch_rad": pitch}, **camera}
    table = {key: value for key, value in robot.items() if not isinstance(value, dict) or key in ("body", "safety")}
    (folder / "robot.toml").write_text(tomlkit.dumps({**table, "devices": [eye]}))
    world = {
        "name": "board",
        "floor": {
            "length_m": 4.0,
            "width_m": 4.0,
            "colour": [110, 110, 110],
            "image": {"file": "board.png", "length_m": (BOARD.columns + 3) * BOARD.square_m},
        },
        "start": {
            "x_m": aside[0] - ahead * math.cos(yaw),
            "y_m": aside[1] - ahead * math.sin(yaw),
            "yaw_rad": yaw,
        },
        "light": {"ambient": 1.0, "diffuse": 0.0},
    }
    (folder / "world.toml").write_text(tomlkit.dumps(world))
