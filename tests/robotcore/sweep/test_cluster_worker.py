"""Job bundles: what fits on a worker, and how files are unpacked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.sweep.cluster_worker import JobBundle
from tests.robotcore.sweep.conftest import AppFile, sweep_of


def test_a_kit_fits_where_it_was_packed() -> None:
    assert JobBundle.of(sweep_of("green-search")).mismatch() is None


@pytest.mark.parametrize(
    "name, remedy",
    [
        ("robotcore", "pip install robotcore==0.0.1 there"),
        ("numpy", "pip install numpy==0.0.1 there"),
        ("absent-simulator", "pip install absent-simulator==0.0.1 there"),
        ("python", "Take the same python there"),
    ],
)
def test_the_library_that_differs_is_named_with_its_remedy(name: str, remedy: str) -> None:
    kit = JobBundle.of(sweep_of("green-search"))
    fault = replace(kit, versions={**kit.versions, name: "0.0.1"}).mismatch()
    assert fault
    assert fault.startswith(f"{name}: it has ")
    assert fault.endswith(f", here is 0.0.1. {remedy}, and start it again")


def test_the_simulator_counts_where_it_is_asked_for() -> None:
    pytest.importorskip("pybullet")
    sweep = sweep_of("green-search")
    assert "pybullet" not in JobBundle.of(sweep).versions
    assert "pybullet" in JobBundle.of(replace(sweep, backends=("kinematic", "pybullet"))).versions


def test_a_kit_is_unpacked_in_whole_or_not_at_all(
    app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path(app_file()).with_name("helper.py").touch()
    kit, root = JobBundle.of(sweep_of(app_file())), tmp_path / "bench" / "kit"
    root.parent.mkdir()
    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_bytes", _full_after(1))
        with pytest.raises(OSError, match="No space left"):
            kit.unpack(root)
    assert not list(root.parent.iterdir())
    kit.unpack(root)
    assert sorted(file.name for file in root.glob("*/*")) == ["helper.py", "odd.py"]


def _full_after(files: int) -> object:
    """Return a `Path.write_bytes` for a disk that takes so many files."""
    room = iter(range(files))

    def write_bytes(path: Path, content: bytes) -> int:
        if next(room, None) is None:
            raise OSError(28, "No space left on device")
        with path.open("wb") as file:
            return file.write(content)

    return write_bytes
