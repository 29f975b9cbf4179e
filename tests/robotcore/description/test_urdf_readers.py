"""The URDF of robots and worlds in the readers of MuJoCo and Bullet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotcore.description import WorldDescription, load_robot, load_world
from robotcore.description.urdf import build_robot_urdf

ROVER, ARENA = load_robot("rover"), load_world("arena")
WHEELS = {"left_motor": 0.0775, "right_motor": -0.0775}
BOX_INERTIA = [1.07 / 12 * (b * b + c * c) for b, c in ((0.185, 0.11), (0.21, 0.11), (0.21, 0.185))]
FUSED = 1e-4
"""The tolerance of masses. MuJoCo adds the small mass of a fixed link to the link to which it is fixed."""


def file(folder: Path, world: WorldDescription | None = None) -> str:
    written = folder / "rover.urdf"
    written.write_text(build_robot_urdf(ROVER, world))
    return str(written)


class TestMujoco:
    @pytest.fixture
    def mujoco(self) -> Any:
        return pytest.importorskip("mujoco")

    def test_wheels_have_the_described_mass_and_axis(self, mujoco: Any, tmp_path: Path) -> None:
        model = mujoco.MjModel.from_xml_path(file(tmp_path, ARENA))
        for motor, y in WHEELS.items():
            joint, wheel = model.joint(f"{motor}_joint"), model.body(f"{motor}_wheel")
            assert joint.type[0] == mujoco.mjtJoint.mjJNT_HINGE
            assert joint.axis.tolist() == [0, 1, 0]
            assert wheel.pos.tolist() == [0, y, 0.0325]
            assert wheel.mass[0] == 0.06
            assert wheel.inertia.max() == pytest.approx(0.06 * 0.0325**2 / 2)

    def test_only_the_robot_can_move_and_is_at_its_start(self, mujoco: Any, tmp_path: Path) -> None:
        model = mujoco.MjModel.from_xml_path(file(tmp_path, ARENA))
        base = model.body("base_link")
        assert base.pos.tolist() == [ARENA.start.x_m, ARENA.start.y_m, 0]
        assert base.mass[0] == pytest.approx(1.07, rel=FUSED)
        assert sorted(base.inertia) == pytest.approx(sorted(BOX_INERTIA), rel=FUSED)
        assert model.joint("base_link_place").type[0] == mujoco.mjtJoint.mjJNT_FREE
        assert model.njnt == 3

    def test_every_body_is_at_its_position(self, mujoco: Any, tmp_path: Path) -> None:
        model = mujoco.MjModel.from_xml_path(file(tmp_path, ARENA))
        places = model.geom_pos[model.geom_bodyid == 0]
        for prism in ARENA.prisms:
            place = (prism.x_m, prism.y_m, prism.height_m / 2)
            assert np.linalg.norm(places - place, axis=1).min() < 1e-8


class TestBullet:
    @pytest.fixture
    def bullet(self) -> Iterator[Any]:
        pybullet = pytest.importorskip("pybullet")
        client = pytest.importorskip("pybullet_utils.bullet_client").BulletClient(pybullet.DIRECT)
        yield client
        client.disconnect()

    @staticmethod
    def loaded(bullet: Any, urdf: str) -> tuple[int, dict[str, int]]:
        """Load a file. Return Bullet's number for the body, and a mapping from the names of links to their numbers."""
        robot = bullet.loadURDF(urdf, flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        numbers = range(bullet.getNumJoints(robot))
        return robot, {bullet.getJointInfo(robot, number)[12].decode(): number for number in numbers}

    def test_robot_has_the_described_mass_and_axes(self, bullet: Any, tmp_path: Path) -> None:
        robot, links = self.loaded(bullet, file(tmp_path))
        mass, _, inertia, centre, *_ = bullet.getDynamicsInfo(robot, -1)
        assert mass == 1.07
        assert list(inertia) == pytest.approx(BOX_INERTIA)
        assert centre == pytest.approx((0.035, 0, 0.073))
        for motor in WHEELS:
            joint = bullet.getJointInfo(robot, links[f"{motor}_wheel"])
            assert joint[2] == bullet.JOINT_REVOLUTE
            assert (joint[10], joint[11], joint[13]) == (0.08, 12.0, (0, 1, 0))
            assert bullet.getDynamicsInfo(robot, links[f"{motor}_wheel"])[0] == 0.06

    def test_takes_sensors_and_things_where_they_are(self, bullet: Any, tmp_path: Path) -> None:
        robot, links = self.loaded(bullet, file(tmp_path, ARENA))
        places = {name: bullet.getLinkState(robot, number)[4] for name, number in links.items()}
        for prism in ARENA.prisms:
            assert places[f"{prism.name}_thing"] == pytest.approx((prism.x_m, prism.y_m, 0), abs=1e-6)
        eye = ARENA.start.pose.to_world(0.14, 0.0)
        assert places["eye_frame"] == pytest.approx((*eye, 0.1), abs=1e-6)
