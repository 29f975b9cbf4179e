from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable

import pytest

from drivers.mujoco import opengl as egl
from drivers.mujoco import opengl as osmesa
from drivers.mujoco.backend import MujocoBackend
from drivers.mujoco.opengl import EglContext, load_library, open_context
from robotcore import RunRequest, run
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.simulation.rigid_body import NoOpenGL
from tests.drivers.physics.worlds import ball, setup, world

NOWHERE = ("libNoSuchLibrary.so.1",)


def works(open_library: Callable[[], object]) -> bool:
    try:
        open_library().close()  # type: ignore[attr-defined]
    except NoOpenGL:
        return False
    return True


needs_egl = pytest.mark.skipif(not works(egl.EglContext), reason="no EGL; sudo apt install libegl1 libgl1-mesa-dri")
needs_osmesa = pytest.mark.skipif(not works(osmesa.OsmesaContext), reason="no OSMesa; sudo apt install libosmesa6")


@pytest.fixture(autouse=True)
def _no_library_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)


@pytest.fixture
def no_opengl(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without OpenGL."""
    monkeypatch.setattr(egl, "EGL_LIBRARIES", NOWHERE)
    monkeypatch.setattr(osmesa, "OSMESA_LIBRARIES", NOWHERE)


@pytest.mark.usefixtures("no_opengl")
def test_without_opengl_the_pictures_are_painted_and_a_note_names_the_packages_to_install() -> None:
    with MujocoBackend().open(setup(world(ball(0.6)))) as robot:
        painted = robot.camera.read().image
    (note,) = robot.notes
    assert {"painted", "libegl1", "libosmesa6"} <= set(re.findall(r"\w+", note))
    with MujocoBackend().open(setup(world(ball(0.6)), options={"camera": "painted"})) as robot:
        assert (robot.camera.read().image == painted).all()
    assert not robot.notes


def test_the_pictures_are_painted_if_the_variable_disables_opengl(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with MujocoBackend().open(setup(world(ball(0.6)))) as robot:
        robot.camera.read()
    (note,) = robot.notes
    assert {"painted", "MUJOCO_GL"} <= set(re.findall(r"\w+", note))


@pytest.mark.usefixtures("no_opengl")
def test_the_result_of_a_run_has_the_note_about_painted_pictures() -> None:
    result = run(RunRequest("green-search", "mujoco", world="open", seed=1, timeout_s=0.1))
    assert sum("painted" in note for note in result.notes) == 1


@pytest.mark.usefixtures("no_opengl")
@pytest.mark.parametrize("variable", [None, "egl"])
def test_a_rendered_camera_without_opengl_is_refused_with_two_remedies(
    variable: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    if variable:
        monkeypatch.setenv("MUJOCO_GL", variable)
    options = {} if variable else {"camera": "rendered"}
    with pytest.raises(DeviceGroupError) as raised:
        MujocoBackend().open(setup(world(), options=options))
    (failure,) = raised.value.failures
    assert isinstance(failure, DeviceError)
    assert (failure.device, failure.kind) == ("eye", "no-opengl")
    assert {"libegl1", "painted"} <= set(re.findall(r"\w+", str(failure)))


@pytest.mark.usefixtures("no_opengl")
def test_robot_without_an_open_camera_needs_no_opengl() -> None:
    with MujocoBackend().open(setup(world(), devices=["nose"])) as robot:
        assert robot.range.read()


@needs_osmesa
def test_osmesa_is_used_if_there_is_no_egl(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(egl, "EGL_LIBRARIES", NOWHERE)
    context = open_context()
    context.close()
    assert context.name == "osmesa"


@pytest.mark.usefixtures("no_opengl")
@pytest.mark.parametrize("way, packages", [("egl", "libegl1 libgl1-mesa-dri"), ("osmesa", "libosmesa6")])
def test_only_the_packages_of_the_named_library_are_suggested(
    way: str, packages: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", way)
    with pytest.raises(NoOpenGL, match=f"apt install {packages}$"):
        open_context()


def test_library_that_needs_a_screen_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "glfw")
    with pytest.raises(NoOpenGL, match=r"glfw.* egl .*osmesa"):
        open_context()


@needs_egl
def test_a_context_of_the_program_stays_current() -> None:
    own = EglContext()
    current = load_library(egl.EGL_LIBRARIES).eglGetCurrentContext
    with MujocoBackend().open(setup(world(), devices=["eye"])) as robot, own.current():
        before = current()
        robot.camera.read()
        assert current() == before
    own.close()


def test_any_thread_may_open_read_and_close() -> None:
    robot = MujocoBackend().open(setup(world(ball(0.6)), devices=["eye"]))
    pictures = [robot.camera.read().image]
    reading = threading.Thread(target=lambda: pictures.append(robot.camera.read().image))
    robot.clock.sleep_until(0.1)
    closing = threading.Thread(target=robot.close)
    for thread in (reading, closing):
        thread.start()
        thread.join()
    assert len(pictures) == 2


PROGRAM = """
import os, sys
from drivers.mujoco.backend import MujocoBackend
from tests.drivers.physics.worlds import ball, setup, world
robot = MujocoBackend().open(setup(world(ball(0.6)), devices=["eye"]))
print(robot.camera.read().image.sum())
"""


def run_program(more: str = "", **environment: str) -> str:
    """Return the output of a process that leaves its robot open. It prints no warning and no error."""
    command, environment_ = [sys.executable, "-W", "error", "-c", PROGRAM + more], {**os.environ, **environment}
    done = subprocess.run(command, capture_output=True, text=True, env=environment_, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@needs_egl
@needs_osmesa
def test_both_libraries_draw_the_same_picture() -> None:
    assert run_program(MUJOCO_GL="egl") == run_program(MUJOCO_GL="osmesa")


@pytest.mark.slow
def test_the_environment_and_pyopengl_are_unchanged() -> None:
    run_program("assert not {'MUJOCO_GL', 'PYOPENGL_PLATFORM'} & set(os.environ) and 'OpenGL' not in sys.modules")


OWN_RENDERER = """
import mujoco
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='.2'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 48, 64) as renderer:
    renderer.update_scene(data)
    shown = renderer.render()
    robot.clock.sleep_until(0.1)
    robot.camera.read()
    assert shown.any() and (renderer.render() == shown).all()
robot.clock.sleep_until(0.2)
robot.camera.read()
robot.close()
"""


@pytest.mark.slow
@needs_egl
def test_mujocos_renderer_works_together_with_the_drivers() -> None:
    run_program(OWN_RENDERER, MUJOCO_GL="egl")


AFTER_ANOTHER = """
from robotcore.errors import DeviceGroupError
robot.close()
os.environ["MUJOCO_GL"] = "osmesa"
try:
    MujocoBackend().open(setup(world(), devices=["eye"]))
except DeviceGroupError as refused:
    print(refused)
"""


@needs_egl
@needs_osmesa
def test_osmesa_with_another_opengl_suggests_the_variable_to_set() -> None:
    output = run_program(AFTER_ANOTHER, MUJOCO_GL="egl")
    assert "eye: MuJoCo cannot draw with osmesa: " in output
    assert output.endswith("If your program also opens a window or another renderer, set MUJOCO_GL=osmesa\n")
