from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotcore.description import RobotDescription, Texture, WorldDescription, load_robot, load_world
from robotcore.hal.backend import ModelExport
from robotcore.simulation.export import export_model, prepare_world
from tests.robotcore.description.courses import load_course

mujoco = pytest.importorskip("mujoco")

from drivers.mujoco.model import build  # noqa: E402

SIX_DIGITS = 1e-5


def load_model(model: ModelExport, folder: Path) -> Any:
    """Write a model and its pictures into a folder. Return the model as MuJoCo loads it."""
    for name, picture in model.pictures.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(picture)
    (folder / "model.xml").write_text(model.text)
    return mujoco.MjModel.from_xml_path(str(folder / "model.xml"))


def build_simulated(robot: RobotDescription, world: WorldDescription) -> Any:
    return build(robot, world, 1 / 240).compile()


def textured(name: str = "arena") -> WorldDescription:
    world = load_world(name)
    floor = world.floor.model_copy(update={"texture": Texture(pattern="planks")})
    assert world.walls
    walls = world.walls.model_copy(update={"texture": Texture(pattern="grass", contrast=0.5)})
    return world.model_copy(update={"floor": floor, "walls": walls})


@pytest.mark.parametrize("robot, seed", [("rover", 7), ("lookout", None), ("freenove-4wd", 1), ("picar", 2)])
def test_the_exported_model_equals_the_simulated_one(robot: str, seed: int | None, tmp_path: Path) -> None:
    described, world = prepare_world(load_robot(robot), "arena", seed)
    written, built = load_model(export_model("mjcf", described, world), tmp_path), build_simulated(described, world)
    of_bodies = (
        "body_mass",
        "body_inertia",
        "body_ipos",
        "body_pos",
        "jnt_axis",
        "jnt_range",
        "dof_armature",
        "eq_data",
    )
    of_motors = ("actuator_gainprm", "actuator_biasprm", "actuator_dynprm", "actuator_dyntype", "actuator_ctrlrange")
    of_contacts = ("geom_type", "geom_size", "geom_pos", "geom_friction", "geom_contype", "geom_conaffinity")
    of_stiffness = ("geom_solref", "geom_solimp", "geom_priority", "geom_condim", "geom_margin", "geom_gap")
    of_rendering = ("cam_fovy", "cam_pos", "cam_quat", "mat_rgba", "geom_group", "light_dir", "light_diffuse")
    for name in (*of_bodies, *of_motors, *of_contacts, *of_stiffness, *of_rendering):
        np.testing.assert_allclose(getattr(written, name), getattr(built, name), SIX_DIGITS, SIX_DIGITS, err_msg=name)
    for option in ("timestep", "integrator", "cone", "impratio"):
        assert getattr(written.opt, option) == pytest.approx(getattr(built.opt, option)), option


def test_the_control_of_a_steering_actuator_is_the_angle_of_its_wheel(tmp_path: Path) -> None:
    model = load_model(export_model("mjcf", load_robot("picar"), load_world("open")), tmp_path)
    data = mujoco.MjData(model)
    data.actuator("front_left_steering").ctrl, data.actuator("front_right_steering").ctrl = 0.3, 0.25
    mujoco.mj_step(model, data)
    angles = [float(data.joint(f"front_{side}_steering").qpos[0]) for side in ("left", "right")]
    assert angles == pytest.approx([0.3, 0.25], abs=1e-4)


def test_every_sensor_has_a_frame_with_its_direction(tmp_path: Path) -> None:
    model = load_model(export_model("mjcf", load_robot("lookout")), tmp_path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    eye, frame = data.camera("eye"), data.site("eye_frame")
    assert frame.xpos == pytest.approx((0.07, 0, 0.48), abs=1e-5)
    ahead = frame.xmat.reshape(3, 3)[:, 0]
    assert ahead == pytest.approx((math.cos(0.2), 0, -math.sin(0.2)), abs=1e-5)
    assert -eye.xmat.reshape(3, 3)[:, 2] == pytest.approx(ahead, abs=1e-5)


def test_textures_are_the_same_picture_to_the_pixel(tmp_path: Path) -> None:
    robot, world = load_robot("rover"), textured()
    model = export_model("mjcf", robot, world, "arena_textures")
    assert len(model.pictures) == 2
    assert all(name.startswith("arena_textures/") for name in model.pictures)
    assert model.notes == ()
    written, built = load_model(model, tmp_path), build_simulated(robot, world)
    for number in range(built.ntex):
        name = built.texture(number).name
        cuts = [slice(each.texture(name).adr[0], None) for each in (written, built)]
        if name != "sky":
            tile = 64 * 64 * 3
            pictures = [each.tex_data[cut][:tile] for each, cut in zip((written, built), cuts, strict=True)]
            np.testing.assert_array_equal(*pictures)
    assert written.mat_texid.tolist() == built.mat_texid.tolist()


@pytest.mark.slow
def test_sheet_with_the_picture_on_the_floor_is_exported(tmp_path: Path) -> None:
    robot, world = load_robot("rover"), load_course(tmp_path)
    model = export_model("mjcf", robot, world, "textures")
    assert list(model.pictures) == ["textures/Sheet.png"]
    written, built = load_model(model, tmp_path), build_simulated(robot, world)
    begin = built.texture("Sheet").adr[0], written.texture("Sheet").adr[0]
    size = 3 * built.texture("Sheet").width[0] * built.texture("Sheet").height[0]
    np.testing.assert_array_equal(built.tex_data[begin[0] :][:size], written.tex_data[begin[1] :][:size])
    assert written.geom("Sheet.seen").contype == written.geom("Sheet.seen").conaffinity == 0


def test_without_a_folder_textures_are_left_out_with_a_note(tmp_path: Path) -> None:
    model = export_model("mjcf", load_robot("rover"), textured())
    assert model.pictures == {}
    (note,) = model.notes
    assert note.startswith("2 textures left out")
    assert load_model(model, tmp_path).ntex == 1  # the sky


def test_wheels_have_the_lag_of_the_worlds_conditions(tmp_path: Path) -> None:
    world = tmp_path / "slow.toml"
    world.write_text('name = "slow"\n[floor]\nlength_m = 3.0\nwidth_m = 3.0\n[conditions]\nwheel_lag_s = 0.2\n')
    slow = load_model(export_model("mjcf", *prepare_world(load_robot("rover"), str(world), None)), tmp_path)
    own = load_model(export_model("mjcf", load_robot("rover")), tmp_path)
    gains = [model.actuator("left_motor").gainprm[0] for model in (slow, own)]
    parts = [-math.expm1(-1 / 240 / lag_s) for lag_s in (0.2, 0.05)]
    assert gains[0] / gains[1] == pytest.approx(parts[0] / parts[1], rel=1e-4)
