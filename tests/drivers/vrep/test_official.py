"""The official binding in a user's folder: loaded where it is whole, else told what is missing."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from drivers.vrep import simx
from drivers.vrep.official_binding import LIBRARIES, load_binding
from robotcore.errors import BackendMissingError
from robotcore.runtime.result import Outcome, RunResult
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import relay_scene
from tests.drivers.vrep.test_apps import arena, run_on

LIBRARY = LIBRARIES.get(sys.platform, "remoteApi.so")
CONSTANTS = "simx_opmode_blocking = 0x010000\n"
MODULE = "from {constants} import *\nprint('The remoteApi library could not be loaded')\ndef simxStart(*_): return 7\n"


@pytest.fixture
def library() -> Path:
    """Any library of this system that can be loaded."""
    import _ctypes

    return Path(_ctypes.__file__)


def folder_with(folder: Path, library: Path, module: str = "sim", text: str = MODULE) -> Path:
    constants = {"sim": "simConst", "vrep": "vrepConst"}[module]
    folder.mkdir(exist_ok=True)
    (folder / f"{module}.py").write_text(text.format(constants=constants))
    (folder / f"{constants}.py").write_text(CONSTANTS)
    shutil.copy(library, folder / LIBRARY)
    return folder


@pytest.mark.parametrize("module", ["sim", "vrep"])
def test_a_whole_binding_is_loaded_from_its_folder_or_file(
    module: str, tmp_path: Path, library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = folder_with(tmp_path, library, module)
    for path in (folder, folder / f"{module}.py", str(folder / LIBRARY)):
        binding = load_binding(path)
        assert (binding.simxStart(), binding.simx_opmode_blocking) == (7, 0x010000)
    assert capsys.readouterr().out == ""
    assert str(folder) not in sys.path
    assert f"{module}Const" not in sys.modules


def test_the_constants_are_those_of_the_same_folder(tmp_path: Path, library: Path) -> None:
    load_binding(folder_with(tmp_path / "one", library))
    other = folder_with(tmp_path / "other", library)
    (other / "simConst.py").write_text("simx_opmode_blocking = 5\n")
    assert load_binding(other).simx_opmode_blocking == 5


@pytest.mark.parametrize(
    "missing, words",
    [("sim.py", r"no sim\.py or vrep\.py"), ("simConst.py", r"needs simConst\.py"), (LIBRARY, LIBRARY)],
)
def test_what_is_missing_is_named(missing: str, words: str, tmp_path: Path, library: Path) -> None:
    (folder_with(tmp_path, library) / missing).unlink()
    with pytest.raises(BackendMissingError, match=f"binding: .*{words}.*takes the folder"):
        load_binding(tmp_path)


def test_a_library_of_another_system_is_reported(tmp_path: Path, library: Path) -> None:
    (folder_with(tmp_path, library) / LIBRARY).write_bytes(b"MZ not for here")
    with pytest.raises(BackendMissingError, match=r"cannot be loaded.*for this system and processor"):
        load_binding(tmp_path)


@pytest.mark.parametrize("text, words", [("print 'Python 2'\n", "cannot be imported"), ("x = 1\n", "no simxStart")])
def test_a_module_that_is_no_binding_is_reported(text: str, words: str, tmp_path: Path, library: Path) -> None:
    with pytest.raises(BackendMissingError, match=words):
        load_binding(folder_with(tmp_path, library, text=text))


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.vrep.official_binding.load_binding", lambda _path: simx)


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


def test_port_on_which_nobody_listens_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simx, "simxStart", lambda *_: -1)
    result = run_over_it(arena("rover", 3), "avoid-obstacles")
    assert (result.exit_status, "nobody answers at 127.0.0.1" in result.reason) == (3, True)


def test_folder_without_a_binding_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    result = run_over_it(arena("rover", 3), "avoid-obstacles")
    assert (result.exit_status, "there is no sim.py or vrep.py in" in result.reason) == (3, True)
