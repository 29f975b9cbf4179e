from __future__ import annotations

import socket
import tarfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import pytest

from robotcore.deploy.wheels import Platform, fetch_wheels
from robotcore.errors import DeployError, DescriptionError
from tests.robotcore.deploy.projects import write_project
from tests.texts import Raises

PI = Platform("3.12.3", "aarch64", "glibc", "2.36")
Publish = Callable[..., None]


@pytest.fixture
def publish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Publish:
    """Publishes a wheel in the only package index of pip, which is a folder."""
    index = tmp_path / "index"
    index.mkdir()
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(index))

    def add_wheel(name: str, tag: str = "py3-none-any", requires: tuple[str, ...] = ()) -> None:
        lines = [f"Requires-Dist: {each}" for each in requires]
        metadata = "\n".join(["Metadata-Version: 2.1", f"Name: {name}", "Version: 1.0", *lines, ""])
        with ZipFile(index / f"{name}-1.0-{tag}.whl", "w") as wheel:
            wheel.writestr(f"{name}-1.0.dist-info/METADATA", metadata)
            wheel.writestr(f"{name}-1.0.dist-info/WHEEL", f"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: {tag}\n")
            wheel.writestr(f"{name}-1.0.dist-info/RECORD", "")

    return add_wheel


def fetch(tmp_path: Path, *requirements: str, target: Platform = PI) -> list[str]:
    return sorted(path.name for path in fetch_wheels(requirements, target, str, tmp_path / "cache").iterdir())


@pytest.mark.slow
def test_wheels_fit_the_robot_and_are_cached(tmp_path: Path, publish: Publish, monkeypatch: pytest.MonkeyPatch) -> None:
    needs = ("there; python_version == '3.12'", "on_pi; platform_machine == 'aarch64'")
    publish("fast", "cp312-cp312-manylinux_2_28_aarch64", needs)
    publish("fast", "cp312-cp312-manylinux_2_39_aarch64")
    publish("there")
    publish("on_pi", "py3-none-any", ("deep; extra == 'more'",))
    requirements = ("fast>=1", "elsewhere; python_version < '3.10'")
    first = fetch(tmp_path, *requirements)
    assert first == [
        "fast-1.0-cp312-cp312-manylinux_2_28_aarch64.whl",
        "on_pi-1.0-py3-none-any.whl",
        "there-1.0-py3-none-any.whl",
    ]
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "gone"))
    assert fetch(tmp_path, *requirements) == first


@pytest.mark.slow
def test_package_without_a_wheel_for_the_robot_is_named_and_nothing_is_cached(
    tmp_path: Path, publish: Publish, raises: Raises
) -> None:
    publish("plain")
    publish("other", "cp312-cp312-manylinux_2_28_x86_64")
    with raises(DeployError, "no-wheel", requirement="other"):
        fetch(tmp_path, "plain", "other")
    assert list((tmp_path / "cache").iterdir()) == []


@pytest.mark.slow
def test_address_is_refused_before_pip_connects_to_it_and_nothing_is_cached(
    tmp_path: Path, publish: Publish, raises: Raises
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setblocking(False)
        address = f"thing[x] @ http://127.0.0.1:{server.getsockname()[1]}/thing-1.0-py3-none-any.whl"
        publish("plain", requires=(f"{address} ; extra == 'more'",))
        publish("other", requires=(f"{address} ; python_version == '3.12'",))
        assert fetch(tmp_path, "plain") == ["plain-1.0-py3-none-any.whl"]
        for requirements in ([address], ["plain", "other"], ["thing @ git+https://host.example/thing@v1"]):
            with raises(DeployError, "requirement-from-address", requirement="thing"):
                fetch(tmp_path, *requirements)
        with pytest.raises(BlockingIOError):
            server.accept()
    assert len(list((tmp_path / "cache").iterdir())) == 1


@pytest.mark.slow
def test_pure_python_package_without_a_wheel_is_built(tmp_path: Path, publish: Publish) -> None:
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
    assert fetch(tmp_path, "source") == [wheel.name]


@pytest.mark.slow
def test_unreachable_package_index_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/simple")
    monkeypatch.setenv("PIP_RETRIES", "1")
    monkeypatch.delenv("PIP_FIND_LINKS", raising=False)
    with raises(DeployError, "index-unreachable", requirement="plain"):
        fetch(tmp_path, "plain")


def test_platforms_depend_on_the_version_of_the_c_library() -> None:
    tags = Platform("3.11.2", "aarch64", "glibc", "2.36").platforms
    assert "manylinux_2_36_aarch64" in tags
    assert "manylinux_2_37_aarch64" not in tags
    assert tags.index("manylinux_2_36_aarch64") < tags.index("manylinux2014_aarch64")
    assert Platform("3.11.2", "armv7l").platforms == ("linux_armv7l",)


def test_too_old_python_is_refused(tmp_path: Path, raises: Raises) -> None:
    table = '[project]\nrequires-python = "{}"\n[tool.robotcore]\napp="app.py"\nrobot="rover"\n'
    project = write_project(tmp_path, table.format(">=3.12"))
    Platform("3.13.0rc1", "aarch64").require_python(project)
    with raises(DeployError, "python-version", required=">=3.12", found="3.11.2"):
        Platform("3.11.2", "aarch64").require_python(project)
    with raises(DescriptionError, key="project.requires-python"):
        Platform("3.11.2", "aarch64").require_python(write_project(tmp_path, table.format("three")))
