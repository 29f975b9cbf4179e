"""Job bundles: the software of a worker, and the unpacking of files."""

from __future__ import annotations

import errno
import platform
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest

from robotcore.sweep.cluster_worker import JobBundle
from tests.robotcore.sweep.conftest import AppFile, sweep_of
from tests.texts import CheckText


def test_a_bundle_matches_the_process_that_packed_it() -> None:
    assert JobBundle.of(sweep_of("green-search")).find_mismatch() is None


@pytest.mark.parametrize("name", ["robotcore", "numpy", "absent-simulator", "python"])
def test_the_mismatch_names_the_library_and_the_remedy(name: str, check_text: CheckText) -> None:
    bundle = JobBundle.of(sweep_of("green-search"))
    mismatch = replace(bundle, versions={**bundle.versions, name: "0.0.1"}).find_mismatch()
    check_text(mismatch, hide=[platform.python_version(), version("numpy"), version("robotcore")])


def test_a_simulator_counts_if_the_sweep_uses_it() -> None:
    pytest.importorskip("pybullet")
    sweep = sweep_of("green-search")
    assert "pybullet" not in JobBundle.of(sweep).versions
    assert "pybullet" in JobBundle.of(replace(sweep, backends=("kinematic", "pybullet"))).versions


def test_a_bundle_is_unpacked_completely_or_not_at_all(
    app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path(app_file()).with_name("helper.py").touch()
    bundle, root = JobBundle.of(sweep_of(app_file())), tmp_path / "bundles" / "one"
    root.parent.mkdir()
    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_bytes", _make_full_disk(1))
        with pytest.raises(OSError) as raised:  # noqa: PT011  the errno is asserted
            bundle.unpack(root)
    assert raised.value.errno == errno.ENOSPC
    assert not list(root.parent.iterdir())
    bundle.unpack(root)
    assert sorted(file.name for file in root.glob("*/*")) == ["helper.py", "odd.py"]


def _make_full_disk(files: int) -> object:
    """Return a `Path.write_bytes` for a disk that is full after this number of files."""
    room = iter(range(files))

    def write_bytes(path: Path, content: bytes) -> int:
        if next(room, None) is None:
            raise OSError(errno.ENOSPC, "No space left on device")
        with path.open("wb") as file:
            return file.write(content)

    return write_bytes
