"""The backend over a binding with the official names: ours stands in for the maker's, which nobody may ship."""

from __future__ import annotations

import pytest

from drivers.vrep import simx
from robotcore.runtime.result import Outcome, RunResult
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import relay_scene
from tests.drivers.vrep.test_apps import arena, run_on


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.vrep.official.binding.load_binding", lambda _path: simx)


def run_over_it(simulator: Simulator, app: str, *, stepped: bool = True, duration_s: float = 0.5) -> RunResult:
    options = {"binding": "/opt/vrep", "stepped": stepped}
    return run_on(simulator, app, settings={"duration_s": duration_s}, options=options)


@pytest.mark.parametrize("stepped", [True, False])
@pytest.mark.parametrize("app", ["avoid-obstacles", "mark-green"])
def test_apps_run_over_a_binding_and_leave_the_simulation_as_it_was(app: str, *, stepped: bool) -> None:
    simulator = relay_scene() if app == "mark-green" else arena("rover", 3)
    result = run_over_it(simulator, app, stepped=stepped)
    assert result.outcome is Outcome.SUCCESS, result.reason
    assert simulator.state is State.STOPPED


def test_step_over_a_binding_is_a_step() -> None:
    result = run_over_it(arena("rover", 3), "avoid-obstacles", duration_s=1.0)
    assert (result.ticks, result.sim_time_s) == (21, 1.0)


def test_port_on_which_nobody_listens_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simx, "simxStart", lambda *_: -1)
    result = run_over_it(arena("rover", 3), "avoid-obstacles")
    assert (result.exit_status, "nobody answers at 127.0.0.1" in result.reason) == (3, True)


def test_folder_without_a_binding_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    result = run_over_it(arena("rover", 3), "avoid-obstacles")
    assert (result.exit_status, "there is no sim.py or vrep.py in" in result.reason) == (3, True)
