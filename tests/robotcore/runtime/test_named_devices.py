"""An app asks for two cameras, a rear range sensor and a motor outside of the drive by their names, on each backend."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest
from robotcore.recording import Recording
from robotcore.recording.replay import replay
from robotcore.sweep import LocalEngine, Sweep
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import record_run

DEVICES = """
[[devices]]
kind = "camera"
name = "back"
mount = { x_m = -0.07, z_m = 0.10, yaw_rad = 3.14 }
width_px = 64
height_px = 48
horizontal_fov_rad = 1.085

[[devices]]
kind = "range_sensor"
name = "tail"
mount = { x_m = -0.07, z_m = 0.10, yaw_rad = 3.14 }
min_range_m = 0.02
max_range_m = 4.0
cone_rad = 0.3

[[devices]]
kind = "motor"
name = "brush"
max_velocity_rad_s = 20.0

[raspberrypi.back]
driver = "v4l2"

[raspberrypi.tail]
driver = "hc-sr04"
trigger = 4
echo = 12

[raspberrypi.brush]
driver = "h-bridge"
forward = 13
backward = 19
standby = 22
model = { dead_band = 0.10, forward_rad_s = 22.0, backward_rad_s = 22.0 }
"""

APP = """
from robotcore import Behaviour, Role, Status

class Sweeper(Behaviour):
    needs = {Role.DRIVE, "eye", "back", "tail", "brush"}

    def step(self, robot):
        eye, back = robot["eye"].read().image, robot["back"].read().image
        self.state = f"{eye.mean():.3f} {back.mean():.3f} {robot['tail'].read().distance:.3f}"
        robot.drive.set_velocity(0.2, 0.0)
        robot["brush"].set_velocity(6.0)
        self.reason = f"{eye.shape[1]} {back.shape[1]} {robot['tail'].read().distance:.2f}"
        return Status.SUCCESS if robot.clock.now() > 1.0 else Status.RUNNING
"""

BACKENDS = ["kinematic", "mujoco", "pybullet", "virtualpi", "mock"]


@pytest.fixture
def request_in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunRequest:
    """Write the app and the robot, and return a request. A replay runs only apps of the current folder."""
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("sweeper.py").write_text(APP)
    tmp_path.joinpath("robot.toml").write_text(ROVER.replace("max_age_s = 1.0", "max_age_s = 1.5") + DEVICES)
    return RunRequest(str(tmp_path / "sweeper.py"), robot=str(tmp_path / "robot.toml"), world="arena")


def record(request: RunRequest, backend: str, *faults: str) -> Recording:
    return record_run(
        request.app, robot=request.robot, world=request.world, backend=backend, seed=1, faults=faults, timeout_s=3.0
    )


@pytest.mark.slow
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("fault", ["", "tail noise=0.05", "tail drop=0.5"])
def test_run_with_named_devices_is_replayed_exactly(request_in_folder: RunRequest, backend: str, fault: str) -> None:
    recording = record(request_in_folder, backend, *filter(None, [fault]))
    assert recording.result
    assert recording.result.outcome is Outcome.SUCCESS
    assert recording.result.reason.startswith("320 64")
    replayed = replay(recording)
    assert replayed.is_equal
    assert replayed.is_exact


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
def test_fault_of_the_rear_sensor_changes_its_distance_alone(request_in_folder: RunRequest, backend: str) -> None:
    plain, faulty = (record(request_in_folder, backend, *faults).result for faults in ((), ("tail stuck=1.5",)))
    assert plain
    assert faulty
    assert not plain.reason.endswith("1.50")
    assert faulty.reason == "320 64 1.50"


@pytest.mark.slow
def test_sweep_runs_the_app_with_the_fault(request_in_folder: RunRequest) -> None:
    request = RunRequest(request_in_folder.app, robot=request_in_folder.robot, faults=("tail stuck=1.5",))
    sweep = Sweep(request, ("kinematic", "mujoco", "pybullet"), ("arena",), (1, 2))
    records = [record for record, _ in LocalEngine(2).perform(sweep, sweep.requests())]
    assert len(records) == 6
    assert {(each.result.outcome, each.result.reason) for each in records} == {(Outcome.SUCCESS, "320 64 1.50")}
