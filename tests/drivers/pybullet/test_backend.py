from __future__ import annotations

import subprocess
import sys

import pytest

from drivers.pybullet import simulation
from drivers.pybullet.backend import PyBulletBackend
from drivers.pybullet.bullet import Bullet
from robotcore.errors import (
    BackendError,
    DeviceClosedError,
    DeviceError,
    DeviceGroupError,
    UnknownNameError,
    UsageError,
)
from robotcore.kinds.encoder import Encoder
from tests.drivers.physics.worlds import ROVER, get_truth, setup, world
from tests.texts import Raises


@pytest.fixture
def connections(monkeypatch: pytest.MonkeyPatch) -> list[Bullet]:
    """Return a list to which each connection is added."""
    made: list[Bullet] = []
    connect = Bullet.connect

    def connect_noted(*, gui: bool) -> Bullet:
        made.append(connect(gui=gui))
        return made[-1]

    monkeypatch.setattr(Bullet, "connect", connect_noted)
    return made


def test_closing_the_robot_twice_ends_its_server_once(connections: list[Bullet]) -> None:
    robot = PyBulletBackend().open(setup(world()))
    assert connections[0].isConnected()
    robot.close()
    robot.close()
    assert not connections[0].isConnected()
    with pytest.raises(DeviceClosedError):
        robot.camera.read()


def test_a_connection_is_closed_if_opening_fails(
    connections: list[Bullet], monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def broken(*_: object, **_options: object) -> None:
        raise BackendError("no world today")

    monkeypatch.setattr(simulation, "BulletScene", broken)
    with raises(BackendError):
        PyBulletBackend().open(setup(world()))
    assert not connections[0].isConnected()


def test_every_encoder_without_a_wheel_is_named_and_all_is_closed(connections: list[Bullet], raises: Raises) -> None:
    spare = [device.model_copy(update={"name": f"spare_{device.name}"}) for device in ROVER.devices[2:4]]
    robot = ROVER.model_copy(update={"devices": (*ROVER.devices, *spare)})
    with raises(DeviceGroupError):
        PyBulletBackend().open(setup(world(), robot=robot))
    assert not connections[0].isConnected()


def test_an_error_about_a_dead_server_names_the_device(connections: list[Bullet], raises: Raises) -> None:
    with PyBulletBackend().open(setup(world())) as robot:
        encoder = robot["left_encoder"]
        assert isinstance(encoder, Encoder)
        connections[0].close()
        with raises(DeviceError):
            robot.camera.read()
        with raises(DeviceError):
            encoder.read()
        with raises(BackendError):
            robot.range.read()
        with raises(BackendError):
            robot.clock.sleep_until(1.0)
        with pytest.raises(BackendError):
            get_truth(robot).pose()


def test_an_unknown_option_is_refused_with_the_nearest_name(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-option"):
        PyBulletBackend().open(setup(world(), options={"solver_iteration": 10}))


def test_the_solver_gets_the_number_of_iterations(connections: list[Bullet]) -> None:
    with PyBulletBackend().open(setup(world(), options={"solver_iterations": "7"})):
        assert connections[0].getPhysicsEngineParameters()["numSolverIterations"] == 7


def test_the_physics_step_is_the_step_of_the_clock(connections: list[Bullet]) -> None:
    with PyBulletBackend().open(setup(world(), rate_hz=50.0)):
        assert connections[0].getPhysicsEngineParameters()["fixedTimeStep"] == pytest.approx(1 / 250)


def test_missing_world_is_refused(raises: Raises) -> None:
    with raises(UsageError, "world-missing"):
        PyBulletBackend().open(setup(None))


@pytest.mark.linux("only X11 has the variable DISPLAY")
def test_a_window_without_a_screen_is_refused_before_bullet_ends_the_process(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    with raises(BackendError, "no-screen"):
        PyBulletBackend().open(setup(world(), gui=True))


@pytest.mark.slow
def test_prints_of_bullet_do_not_reach_the_output() -> None:
    program = (
        "from tests.drivers.physics.worlds import drive, setup, world\n"
        "from drivers.pybullet.backend import PyBulletBackend\n"
        "with PyBulletBackend().open(setup(world())) as robot:\n"
        "    drive(robot, 3.0, 3.0, 0.1)\n"
        "    print(robot.camera.read().image.shape)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "(240, 320, 3)\n"
    assert done.stderr == ""
