from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import distributions, version
from pathlib import Path

import pytest

from robotcore.deploy.bundle import Bundle, build_bundle, build_package
from robotcore.deploy.project import DeployOptions, build_project
from robotcore.description import load_world
from robotcore.errors import DeployError, UsageError
from tests.doubles.packages import forget_packages
from tests.robotcore.deploy.projects import TABLE, git, write, write_project
from tests.robotcore.description.courses import write_course
from tests.texts import Raises

BUILT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
"""
PACKAGE = """
[project]
name = "my-rover"
version = "1.2"
dependencies = ["robotcore[tof]>=0.1", "lidar-x", "Some.Thing>=2; python_version > '3'"]
"""
DRIVER = """
[project]
name = "lidar-x"
version = "0.3"
dependencies = ["smbus2>=0.4"]
"""
LIDAR = """
from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic
class Lidar(Ultrasonic):
    name = "lidar-x"
"""
ROBOT = Path(__file__).parents[3] / "robotcore" / "description" / "robots" / "rover.toml"


@pytest.fixture
def bundle_folder(tmp_path: Path) -> Path:
    (tmp_path / "bundle").mkdir()
    return tmp_path / "bundle"


@pytest.fixture
def driver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A driver package of a user, installed by ``pip install -e``."""
    source = write(tmp_path / "lidar", {"pyproject.toml": BUILT + DRIVER, "lidar_x/__init__.py": LIDAR, ".env": "A=1"})
    metadata = {
        "METADATA": "Metadata-Version: 2.1\nName: lidar-x\nVersion: 0.3\n",
        "entry_points.txt": "[robotcore.devices]\nlidar-x = lidar_x:Lidar\n",
        "direct_url.json": json.dumps({"url": source.as_uri(), "dir_info": {"editable": True}}),
    }
    installed = {f"lidar_x-0.3.dist-info/{name}": text for name, text in metadata.items()}
    monkeypatch.syspath_prepend(write(tmp_path / "installed", installed))
    monkeypatch.syspath_prepend(source)
    forget_packages()
    yield
    forget_packages()


@pytest.fixture
def without_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Do not copy robotcore's own code, because requirements depend on its metadata only."""
    monkeypatch.setattr("robotcore.deploy.bundle.shutil.copytree", lambda *_args, **_more: None)


@pytest.mark.slow
@pytest.mark.usefixtures("driver")
def test_bundle_runs_alone_and_names_nothing_of_this_machine(
    tmp_path: Path, bundle_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = BUILT + PACKAGE + TABLE.replace('"rover"', '"my robot.toml"').replace("kinematic", "raspberrypi")
    robot = ROBOT.read_text().replace('driver = "hc-sr04"', 'driver = "lidar-x"')
    source = write(tmp_path / "project", {"my robot.toml": robot, "my_rover/__init__.py": "", ".env": "A=1"})
    monkeypatch.chdir(write(source, {"apps/__init__.py": "", "apps/mine.py": ""}))
    monkeypatch.syspath_prepend("")
    monkeypatch.delitem(sys.modules, "apps", raising=False)
    bundle = build_bundle(write_project(source, table), bundle_folder)
    site = bundle_folder / "site"
    assert not (site / "apps" / "mine.py").exists()
    names = {dist.metadata["Name"] for dist in distributions(path=[str(site)])}
    assert names == {"robotcore", "my-rover", "lidar-x"}
    assert (site / "my_rover/__init__.py").exists()
    assert (site / "lidar_x/__init__.py").exists()
    assert not {*site.rglob("__pycache__"), *site.rglob("*.pyc"), *site.rglob("direct_url.json"), *site.rglob(".env")}
    assert {"smbus2>=0.4", 'some-thing>=2; python_version > "3"'} <= {
        each.lower().replace(".t", "-t") for each in bundle.requirements
    }
    assert not [each for each in bundle.requirements if each.startswith(("robotcore", "lidar", "my-rover"))]
    assert any(each.startswith("adafruit-circuitpython-vl53l0x") for each in bundle.requirements)
    assert bundle.warnings == ("left out because they may hold a secret: .env, lidar/.env",)
    assert _runs(bundle)


def _runs(bundle: Bundle) -> bool:
    """Return whether a Python with robotcore's requirements finds the robotcore in ``site``."""
    lines = "import robotcore, sys; from robotcore.plugins import app_names; print(robotcore.__file__, app_names())"
    answer = subprocess.run(
        [sys.executable, "-c", lines],
        cwd=bundle.folder / "project",
        env={"PYTHONPATH": str(bundle.folder / "site"), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    return str(bundle.folder) in answer.stdout and "green-search" in answer.stdout


def test_requirements_are_those_of_the_robot_and_keep_their_markers(tmp_path: Path, bundle_folder: Path) -> None:
    project = build_project(DeployOptions(app="green-search", robot="rover"), tmp_path)
    requirements = build_bundle(project, bundle_folder).requirements
    assert {"gpiozero>=2.0.1", "mcap>=1.3", "numpy>=1.24"} <= set(requirements)
    assert 'numpy<2; python_version == "3.11" and platform_machine == "aarch64"' in requirements
    assert not [each for each in requirements if "extra" in each or each.startswith(("pytest", "robotcore", "jinja"))]


@pytest.mark.usefixtures("without_code")
@pytest.mark.parametrize(
    "dependency, kind",
    [
        ("robotcore>=99", "requirement-version"),
        ("thing @ file:///home/me/thing", "requirement-from-file"),
        ("thing @ https://me:hunter2@host.example/thing.whl", "requirement-with-secret"),
        ("thing @ https://hunter2@host.example/thing.whl", "requirement-with-secret"),
        ("thing @ git+ssh://git:hunter2@host.example/thing", "requirement-with-secret"),
        ("thing @ https://me:my hunter2@host.example/thing.whl", "invalid-requirement"),
        ("thing @ https:/me:hunter2@host.example/a b", "invalid-requirement"),
    ],
)
def test_dependency_that_a_robot_cannot_install_is_refused(
    tmp_path: Path, bundle_folder: Path, dependency: str, kind: str, raises: Raises
) -> None:
    project = write_project(tmp_path / "project", f'[project]\ndependencies = ["{dependency}"]\n{TABLE}')
    with raises(UsageError, kind, hide=[version("robotcore")]) as raised:
        build_bundle(project, bundle_folder)
    assert "hunter2" not in str(raised.value)


@pytest.mark.usefixtures("without_code")
def test_address_of_a_repository_over_ssh_keeps_its_user(tmp_path: Path, bundle_folder: Path) -> None:
    place = "thing @ git+ssh://git@host.example/thing"
    project = write_project(tmp_path / "project", f'[project]\ndependencies = ["{place}"]\n{TABLE}')
    assert place in build_bundle(project, bundle_folder).requirements


@pytest.mark.usefixtures("without_code")
def test_project_that_names_an_ignored_file_is_refused(tmp_path: Path, bundle_folder: Path, raises: Raises) -> None:
    project = write_project(tmp_path / "project")
    git(tmp_path / "project", "init", "-q")
    write(tmp_path / "project", {".gitignore": "app.py\n"})
    with raises(UsageError, "file-not-sent", file="app.py"):
        build_bundle(project, bundle_folder)


@pytest.mark.usefixtures("without_code")
def test_picture_on_the_floor_of_the_world_is_sent(tmp_path: Path, bundle_folder: Path) -> None:
    (tmp_path / "project" / "rooms").mkdir(parents=True)
    write_course(tmp_path / "project" / "rooms")
    project = write_project(tmp_path / "project", TABLE.replace("robot =", 'world = "rooms/course.toml"\nrobot ='))
    assert project.files == ("app.py", "rooms/course.toml", "rooms/course.png")
    build_bundle(project, bundle_folder)
    assert load_world(str(bundle_folder / "project" / "rooms" / "course.toml")).floor.image


@pytest.mark.usefixtures("without_code")
@pytest.mark.parametrize(
    "ignored, kind", [("*.png", "file-not-sent"), (None, "link-leads-nowhere")], ids=["ignored", "link"]
)
def test_picture_that_is_not_sent_is_refused(
    tmp_path: Path, bundle_folder: Path, ignored: str | None, kind: str, raises: Raises
) -> None:
    table = TABLE.replace("robot =", 'world = "course.toml"\nrobot =')
    (tmp_path / "project").mkdir()
    write_course(tmp_path / "project")
    project = write_project(tmp_path / "project", table)
    git(tmp_path / "project", "init", "-q")
    if ignored:
        write(tmp_path / "project", {".gitignore": ignored})
    else:
        picture = (tmp_path / "project" / "course.png").rename(tmp_path / "elsewhere.png")
        (tmp_path / "project" / "course.png").symlink_to(picture)
    with raises(UsageError, kind):
        build_bundle(project, bundle_folder)


@pytest.mark.slow
def test_compiled_code_is_refused(tmp_path: Path, raises: Raises) -> None:
    source = write(
        tmp_path / "lidar", {"pyproject.toml": BUILT + DRIVER, "lidar_x/__init__.py": "", "lidar_x/fast.so": ""}
    )
    with raises(UsageError, "compiled-code", file="fast.so"):
        build_package(source, tmp_path / "site")
    assert not (tmp_path / "site").exists()


@pytest.mark.slow
def test_failed_build_is_reported_and_does_not_change_the_folder(tmp_path: Path) -> None:
    table = '[build-system]\nrequires = []\nbuild-backend = "own"\nbackend-path = ["."]\n'
    leaves_things = "def build_wheel(*_):\n    open('left', 'w').close()\n    raise OSError('no compiler')\n"
    source = write(tmp_path / "broken", {"pyproject.toml": table, "own.py": leaves_things})
    with pytest.raises(DeployError) as raised:
        build_package(source, tmp_path / "site")
    assert raised.value.kind == "package-not-built"
    assert {path.name for path in source.iterdir()} == {"pyproject.toml", "own.py"}
