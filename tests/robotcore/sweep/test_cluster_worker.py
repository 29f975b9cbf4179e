"""Job bundles: comparing the software of a worker, and unpacking files."""

from __future__ import annotations

import errno
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from unittest.mock import Mock

import pytest

from robotcore.description import load_world
from robotcore.runtime.request import RunRequest
from robotcore.sweep.cluster_worker import JobBundle
from tests.robotcore.description.courses import write_course
from tests.robotcore.sweep.conftest import AppFile, make_sweep
from tests.texts import CheckText


def test_the_mismatch_names_the_software_that_differs(check_text: CheckText) -> None:
    bundle = JobBundle.from_sweep(make_sweep("green-search"))
    assert bundle.find_mismatch() is None
    software = {**bundle.software, "numpy": "0.0.1", "absent-simulator": "0.0.1", "the code of apps": "0123"}
    mismatch = replace(bundle, software=software).find_mismatch()
    check_text(mismatch, hide=[version("numpy"), bundle.software["the code of apps"]])


def test_a_bundle_has_the_versions_of_the_simulators_that_the_sweep_uses() -> None:
    pytest.importorskip("pybullet")
    sweep = make_sweep("green-search")
    assert "pybullet" not in JobBundle.from_sweep(sweep).software
    assert "pybullet" in JobBundle.from_sweep(replace(sweep, backends=("kinematic", "pybullet"))).software


def test_a_bundle_is_unpacked_completely_or_not_at_all(
    app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path(app_file()).with_name("helper.py").touch()
    bundle, root = JobBundle.from_sweep(make_sweep(app_file())), tmp_path / "bundles" / "one"
    root.parent.mkdir()
    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_bytes", Mock(side_effect=[1, OSError(errno.ENOSPC, "No space left on device")]))
        with pytest.raises(OSError) as raised:  # noqa: PT011  the errno is asserted
            bundle.unpack(root)
    assert raised.value.errno == errno.ENOSPC
    assert not list(root.parent.iterdir())
    bundle.unpack(root)
    assert sorted(file.name for file in root.glob("*/*")) == ["helper.py", "odd.py"]


def test_a_picture_on_the_floor_is_unpacked_beside_its_world(tmp_path: Path) -> None:
    world = write_course(tmp_path)
    bundle = JobBundle.from_sweep(make_sweep("green-search", worlds=(world,)))
    (tmp_path / "course.png").unlink()
    bundle.unpack(tmp_path / "unpacked")
    local = bundle.localize(RunRequest("green-search", world=world), tmp_path / "unpacked").world
    assert local
    assert load_world(local).floor.image
