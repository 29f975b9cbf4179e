"""Driving, seeing, ranging and textures in Bullet."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from drivers.pybullet.backend import PyBulletBackend
from robotcore.description import Texture
from tests.drivers.physics import drives, driving, ranging, seeing
from tests.drivers.physics.worlds import box, setup, world


class TestDriving(driving.Driving):
    backend = PyBulletBackend


class TestDrives(drives.Drives):
    backend = PyBulletBackend


class TestSeeing(seeing.Seeing):
    backend = PyBulletBackend


class TestPainting(seeing.Painting):
    backend = PyBulletBackend


class TestRenderingAhead(seeing.RenderingAhead):
    backend = PyBulletBackend


class TestRanging(ranging.Ranging):
    backend = PyBulletBackend


class TestTexturing(seeing.Texturing):
    backend = PyBulletBackend


def test_no_file_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    wooden = box(0.6).model_copy(update={"texture": Texture(pattern="planks")})
    with PyBulletBackend().open(setup(world(wooden))) as robot:
        assert list(tmp_path.iterdir()) == []
        assert np.ptp(robot.camera.read().image[100:140, 100:220, 2]) > 5
