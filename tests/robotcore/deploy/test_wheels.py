from __future__ import annotations

import tarfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import pytest

from robotcore.deploy.wheels import Target, fetch_wheels
from robotcore.errors import DeployError
from tests.robotcore.deploy.projects import project_in
from tests.texts import Raises

PI = Target("3.12.3", "aarch64", "glibc", "2.36")
Publish = Callable[..., None]


@pytest.fixture
def publish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Publish:
    """The only index that pip knows: wheels in a folder."""
    index = tmp_path / "index"
    index.mkdir()
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(index))

    def published(name: str, tag: str = "py3-none-any", requires: tuple[str, ...] = ()) -> None:
        lines = [f"Requires-Dist: {each}" for each in requires]
        metadata = "\n".join(["Metadata-Version: 2.1", f"Name: {name}", "Version: 1.0", *lines, ""])
        with ZipFile(index / f"{name}-1.0-{tag}.whl", "w") as wheel:
            wheel.writestr(f"{name}-1.0.dist-info/METADATA", metadata)
            wheel.writestr(f"{name}-1.0.dist-info/WHEEL", f"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: {tag}\n")
            wheel.writestr(f"{name}-1.0.dist-info/RECORD", "")

    return published


def fetched(tmp_path: Path, *requirements: str, target: Target = PI) -> list[str]:
    return sorted(path.name for path in fetch_wheels(requirements, target, str, tmp_path / "cache").iterdir())


def test_wheels_are_the_robots_with_what_holds_there_and_are_kept(
    tmp_path: Path, publish: Publish, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs = ("there; python_version == '3.12'", "on_pi; platform_machine == 'aarch64'")
    publish("fast", "cp312-cp312-manylinux_2_28_aarch64", needs)
    publish("fast", "cp312-cp312-manylinux_2_39_aarch64")
    publish("there")
    publish("on_pi", "py3-none-any", ("deep; extra == 'more'",))
    requirements = ("fast>=1", "elsewhere; python_version < '3.10'")
    first = fetched(tmp_path, *requirements)
    assert first == [
        "fast-1.0-cp312-cp312-manylinux_2_28_aarch64.whl",
        "on_pi-1.0-py3-none-any.whl",
        "there-1.0-py3-none-any.whl",
    ]
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "gone"))
    assert fetched(tmp_path, *requirements) == first


def test_what_has_no_wheel_for_the_robot_is_named_and_nothing_is_kept(
    tmp_path: Path, publish: Publish, raises: Raises
) -> None:
    publish("plain")
    publish("other", "cp312-cp312-manylinux_2_28_x86_64")
    with raises(DeployError, "no-wheel", requirement="other"):
        fetched(tmp_path, "plain", "other")
    assert list((tmp_path / "cache").iterdir()) == []


@pytest.mark.parametrize("address", ["git+https://host.example/thing@v1", "https://host.example/thing-1.0.whl"])
def test_what_pip_would_get_from_an_address_is_named_with_what_to_do(
    tmp_path: Path, address: str, raises: Raises
) -> None:
    with raises(DeployError, "requirement-from-address", requirement="thing"):
        fetched(tmp_path, f"thing @ {address}")


def test_pure_python_without_a_wheel_is_built_here(tmp_path: Path, publish: Publish) -> None:
    publish("source")
    wheel = tmp_path / "index" / "source-1.0-py3-none-any.whl"
    builder = f"""
import shutil

def build_wheel(folder, *_):
    shutil.copy("built", f"{{folder}}/{wheel.name}")
    return "{wheel.name}"
"""
    files = {
        "pyproject.toml": b'[build-system]\nrequires = []\nbuild-backend = "own"\nbackend-path = ["."]\n',
        "own.py": builder.encode(),
        "built": wheel.read_bytes(),
        "PKG-INFO": b"Metadata-Version: 2.1\nName: source\nVersion: 1.0\n",
    }
    wheel.unlink()
    with tarfile.open(tmp_path / "index" / "source-1.0.tar.gz", "w:gz") as archive:
        for name, content in files.items():
            member = tarfile.TarInfo(f"source-1.0/{name}")
            member.size = len(content)
            archive.addfile(member, BytesIO(content))
    assert fetched(tmp_path, "source") == [wheel.name]


def test_an_index_that_cannot_be_reached_is_reported_as_that(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/simple")
    monkeypatch.setenv("PIP_RETRIES", "1")
    monkeypatch.delenv("PIP_FIND_LINKS", raising=False)
    with raises(DeployError, "index-unreachable", requirement="plain"):
        fetched(tmp_path, "plain")


def test_a_robot_takes_what_its_c_library_is_new_enough_for() -> None:
    tags = Target("3.11.2", "aarch64", "glibc", "2.36").platforms
    assert "manylinux_2_36_aarch64" in tags
    assert "manylinux_2_37_aarch64" not in tags
    assert tags.index("manylinux_2_36_aarch64") < tags.index("manylinux2014_aarch64")
    assert Target("3.11.2", "armv7l").platforms == ("linux_armv7l",)


def test_a_python_that_is_too_old_for_the_project_is_reported(tmp_path: Path, raises: Raises) -> None:
    project = project_in(
        tmp_path, '[project]\nrequires-python = ">=3.12"\n[tool.robotcore]\napp="app.py"\nrobot="rover"\n'
    )
    Target("3.13.0rc1", "aarch64").require_python(project)
    with raises(DeployError, "python-version", required=">=3.12", found="3.11.2"):
        Target("3.11.2", "aarch64").require_python(project)
