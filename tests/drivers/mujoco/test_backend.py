from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path
from zlib import crc32

import mujoco
import pytest

from drivers.mujoco.backend import MIN_VERSION, MujocoBackend
from drivers.mujoco.simulation import Simulation
from robotcore.errors import (
    BackendError,
    BackendMissingError,
    DeviceClosedError,
    DeviceGroupError,
    UsageError,
)
from tests.drivers.physics.worlds import ROVER, ball, box, drive, get_truth, setup, world
from tests.texts import Raises

BLIND = ("left_motor", "right_motor", "left_encoder", "right_encoder", "nose")


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> list[Simulation]:
    """Return a list to which each closed simulation is added."""
    seen: list[Simulation] = []
    close = Simulation.close

    def close_noted(simulation: Simulation) -> None:
        seen.append(simulation)
        close(simulation)

    monkeypatch.setattr(Simulation, "close", close_noted)
    return seen


@pytest.mark.slow
def test_closing_the_robot_twice_closes_its_simulation_once(closed: list[Simulation]) -> None:
    robot = MujocoBackend().open(setup(world()))
    robot.camera.read()
    assert not closed
    robot.close()
    robot.close()
    assert len(closed) == 1
    with pytest.raises(DeviceClosedError):
        robot.camera.read()


def test_a_simulation_is_closed_if_a_device_fails_to_open(
    closed: list[Simulation], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise BackendError("no devices today")

    monkeypatch.setattr(Simulation, "open", broken)
    with pytest.raises(BackendError):
        MujocoBackend().open(setup(world()))
    assert closed


@pytest.mark.slow
def test_every_encoder_without_a_wheel_is_named(closed: list[Simulation], raises: Raises) -> None:
    spare = [device.model_copy(update={"name": f"spare_{device.name}"}) for device in ROVER.devices[2:4]]
    robot = ROVER.model_copy(update={"devices": (*ROVER.devices, *spare)})
    with raises(DeviceGroupError):
        MujocoBackend().open(setup(world(), robot=robot))
    assert closed


def test_missing_world_is_refused(raises: Raises) -> None:
    with raises(UsageError, "world-missing"):
        MujocoBackend().open(setup(None))


def test_robot_that_mujoco_cannot_model_is_refused() -> None:
    assert ROVER.drive
    robot = ROVER.model_copy(update={"drive": ROVER.drive.model_copy(update={"wheel_mass_kg": 1e-15})})
    with pytest.raises(BackendError, match="left_motor_wheel"):
        MujocoBackend().open(setup(world(), robot=robot))
    with pytest.raises(BackendError, match="left_motor_wheel"):
        MujocoBackend().export("mjcf", robot, None, None)


@pytest.mark.parametrize("rate_hz, step_s", [(20.0, 1 / 240), (50.0, 1 / 250)])
def test_the_physics_step_is_the_step_of_the_clock(rate_hz: float, step_s: float) -> None:
    simulation = Simulation(setup(world(), rate_hz=rate_hz), world())
    assert simulation.model.opt.timestep == simulation.clock.step == pytest.approx(step_s)


def test_a_reset_of_mujocos_state_is_an_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log file there
    simulation = Simulation(setup(world()), world())
    simulation.data.qvel[0] = 1e12
    with pytest.raises(BackendError) as raised:
        simulation.clock.sleep_until(0.05)
    assert raised.value.kind == "state-lost"
    with pytest.raises(BackendError):
        simulation.pose()


def run_program() -> str:
    """Drive a robot into things for two seconds. Return its samples and its true state as a text."""
    with MujocoBackend().open(setup(world(box(0.5, yaw=0.4), ball(0.3, 0.5)))) as robot:
        drive(robot, 5.0, 7.3, 2.0)
        truth, image = get_truth(robot), robot.camera.read().image
        return f"{truth.pose()} {truth.twist()} {truth.contacts()} {robot.range.read()} {crc32(image.tobytes())}"


@pytest.mark.slow
def test_another_process_gets_equal_samples_and_prints_nothing_else() -> None:
    program = f"from {__name__} import run_program; print(run_program())"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == f"{run_program()}\n"
    assert done.stderr == ""


@pytest.mark.parametrize("name", ["floor", "body", "ground", "sky", "wall-north"])
def test_a_thing_may_have_any_name(name: str) -> None:
    thing = box(1.0).model_copy(update={"name": name})
    with MujocoBackend().open(setup(world(thing), devices=["nose"])) as robot:
        assert robot.range.read().distance < 1.0


@pytest.mark.slow
def test_an_opengl_that_mujoco_does_not_support_is_reported_in_a_line() -> None:
    environment = {**os.environ, "MUJOCO_GL": "crayon"}
    done = subprocess.run(
        [sys.executable, "-m", "robotcore", "export", "rover", "--format", "mjcf"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == (
        "error: MuJoCo cannot be imported: invalid value for environment variable MUJOCO_GL: crayon. "
        "Unset MUJOCO_GL, which is 'crayon'. robotcore then chooses a renderer that works\n"
    )


@pytest.mark.parametrize("version", ["3.4.0", "2.10.1"])
def test_library_that_is_too_old_is_reported(monkeypatch: pytest.MonkeyPatch, raises: Raises, version: str) -> None:
    monkeypatch.setattr(mujoco, "__version__", version)
    with raises(BackendMissingError, "library-too-old"):
        MujocoBackend().require_installed()


def test_the_oldest_supported_version_is_the_one_in_the_requirements() -> None:
    assert any(line.startswith("mujoco>={}.{};".format(*MIN_VERSION)) for line in requires("robotcore") or ())
