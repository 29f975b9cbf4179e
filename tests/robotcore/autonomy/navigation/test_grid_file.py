from __future__ import annotations

import os
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.grid_file import Layer
from robotcore.errors import MapError
from robotcore.geometry import Pose
from tests.texts import Raises


@pytest.fixture
def grid() -> OccupancyGrid:
    grid = OccupancyGrid(size=3.1, cell=0.07, centre=(1.0, -2.3))
    grid.add_range(Pose(1.0, -2.0, 0.3), distance=0.8, max_range=2.0, cone=0.5)
    grid.travelled = 0.1 + 0.2
    return grid


@pytest.fixture
def file(grid: OccupancyGrid, tmp_path: Path) -> Path:
    grid.save(tmp_path / "hall.npz")
    return tmp_path / "hall.npz"


def test_loaded_map_equals_the_saved_one_to_the_bit(grid: OccupancyGrid, file: Path) -> None:
    loaded = OccupancyGrid.load(str(file))
    assert vars(loaded).keys() == vars(grid).keys()
    for name, value in vars(grid).items():
        np.testing.assert_array_equal(getattr(loaded, name), value, strict=True)


def test_loaded_map_takes_further_readings(grid: OccupancyGrid, file: Path) -> None:
    loaded = OccupancyGrid.load(file)
    for each in (grid, loaded):
        each.add_range(Pose(1.0, -2.0, 0.5), distance=0.7, max_range=2.0, cone=0.5)
    np.testing.assert_array_equal(loaded.evidence, grid.evidence)


def test_map_is_readable_by_numpy(grid: OccupancyGrid, file: Path) -> None:
    with np.load(file) as arrays:
        assert arrays["cell_m"] == 0.07
        np.testing.assert_array_equal(arrays["evidence"], grid.evidence)


def change(file: Path, **arrays: Any) -> None:
    with np.load(file) as old:
        np.savez_compressed(file, **{**old, **arrays})


def write_object(file: Path) -> None:
    change(file, evidence=np.array([os.getcwd], dtype=object))


def write_evidence(file: Path, description: str, content: bytes = b"", compression: int = zipfile.ZIP_DEFLATED) -> None:
    """Write a layer with any header and content."""
    with np.load(file) as old:
        arrays = dict(old)
    del arrays["evidence"]
    np.savez_compressed(file, **arrays)
    header = b"\x93NUMPY\1\0" + len(description).to_bytes(2, "little") + description.encode()
    with zipfile.ZipFile(file, "a", compression) as archive:
        archive.writestr("evidence.npy", header + content)


HEADER = "{'descr': '<f4', 'fortran_order': False, 'shape': (44, 44), }"


def break_lzma(file: Path) -> None:
    write_evidence(file, HEADER, bytes(44 * 44 * 4), zipfile.ZIP_LZMA)
    with zipfile.ZipFile(file) as archive:
        options = archive.getinfo("evidence.npy").header_offset + 30 + len("evidence.npy") + 4
    content = file.read_bytes()
    file.write_bytes(content[:options] + b"\xff" * 5 + content[options + 5 :])


def remove_layer(file: Path) -> None:
    with np.load(file) as old:
        np.savez(file, **{name: array for name, array in old.items() if name != "updated_at"})


DAMAGES: dict[str, Callable[[Path], object]] = {
    "text": lambda file: file.write_text("free free occupied"),
    "empty": lambda file: file.write_bytes(b""),
    "pickle": lambda file: file.write_bytes(pickle.dumps([1])),
    "picture": lambda file: file.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(50)),
    "truncated": lambda file: file.write_bytes(file.read_bytes()[:-40]),
    "flipped": lambda file: file.write_bytes(file.read_bytes()[:900] + b"x" * 60 + file.read_bytes()[960:]),
    "other archive": lambda file: np.savez(file, a=np.zeros(3)),
    "missing layer": remove_layer,
    "object array": write_object,
    "huge header": lambda file: write_evidence(file, HEADER.replace("44", "1000000000")),
    "bomb": lambda file: write_evidence(file, HEADER, bytes(10**8)),
    "open bracket in a header": lambda file: write_evidence(file, "(" * 60),
    "indented header": lambda file: write_evidence(file, "  1\n 2\n"),
    "header with a list as a key": lambda file: write_evidence(file, "{[]: 1}"),
    "damaged lzma": break_lzma,
    "double precision": lambda file: change(file, evidence=np.zeros((44, 44))),
    "other shape": lambda file: change(file, evidence=np.zeros((3, 3), np.float32)),
    "nan in a layer": lambda file: change(file, evidence=np.full((44, 44), np.nan, np.float32)),
    "nan": lambda file: change(file, size_m=np.nan),
    "infinite": lambda file: change(file, centre_x_m=np.inf),
    "no cell": lambda file: change(file, cell_m=0.0),
    "negative": lambda file: change(file, cell_m=-0.07, size_m=-3.1),
    "enormous": lambda file: change(file, size_m=1e5, cell_m=0.001),
    "less than a cell": lambda file: change(file, size_m=0.01),
    "future": lambda file: change(file, travelled=-1.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_map_is_refused(damage: str, file: Path) -> None:
    DAMAGES[damage](file)
    with pytest.raises(MapError) as raised:
        OccupancyGrid.load(file)
    assert raised.value.kind == "map-damaged"
    assert raised.value.fields["file"] == str(file)


@pytest.mark.parametrize("padding", [0, 7, 300])
def test_spaces_after_the_header_are_those_of_any_version_of_numpy(padding: int, file: Path) -> None:
    evidence = np.full((44, 44), 0.5, np.float32)
    write_evidence(file, HEADER + " " * padding + "\n", evidence.tobytes())
    np.testing.assert_array_equal(OccupancyGrid.load(file).evidence, evidence)


@pytest.mark.parametrize("damage", ["huge header", "other shape", "enormous"])
def test_size_is_refused_before_a_layer_is_read(damage: str, file: Path, raises: Raises) -> None:
    DAMAGES[damage](file)
    with raises(MapError, "map-damaged"):
        OccupancyGrid.load(file)


def test_each_cut_of_a_map_is_refused(file: Path) -> None:
    content = file.read_bytes()
    for length in range(0, len(content), 37):
        file.write_bytes(content[:length])
        with pytest.raises(MapError):
            OccupancyGrid.load(file)


def test_missing_map_is_refused(tmp_path: Path, raises: Raises) -> None:
    with raises(MapError, "no-map-file", file=str(tmp_path / "hall.npz")):
        OccupancyGrid.load(tmp_path / "hall.npz")


def test_folder_and_pipe_are_no_maps(tmp_path: Path, raises: Raises) -> None:
    os.mkfifo(tmp_path / "pipe")
    for file in (tmp_path, tmp_path / "pipe"):
        with raises(MapError, "no-map-file"):
            OccupancyGrid.load(file)


def test_map_without_a_folder_is_not_written(grid: OccupancyGrid, tmp_path: Path, raises: Raises) -> None:
    with raises(MapError, "map-not-writable"):
        grid.save(tmp_path / "no" / "hall.npz")


@pytest.mark.parametrize(
    "wrong",
    [
        OccupancyGrid(size=40.01, cell=0.01),
        OccupancyGrid(size=0.03),
        OccupancyGrid(centre=(2e6, 0.0)),
        OccupancyGrid(centre=(0.0, -2e6)),
    ],
    ids=["cells", "less than a cell", "x", "y"],
)
def test_map_that_load_would_refuse_is_not_saved(wrong: OccupancyGrid, file: Path, raises: Raises) -> None:
    old = file.read_bytes()
    with raises(MapError, "map-out-of-limits", file=str(file)):
        wrong.save(file)
    assert file.read_bytes() == old


@pytest.mark.parametrize("layer", [np.zeros((3, 3)), np.full((44, 44), np.nan)], ids=["shape", "nan"])
def test_layer_that_load_would_refuse_is_not_saved(
    layer: Layer, grid: OccupancyGrid, file: Path, raises: Raises
) -> None:
    grid.evidence = layer
    with raises(MapError, "map-out-of-limits"):
        grid.save(file)


def test_layer_of_another_type_and_order_is_saved(grid: OccupancyGrid, file: Path) -> None:
    grid.evidence = grid.evidence.T.astype(np.float64)
    grid.save(file)
    np.testing.assert_array_equal(OccupancyGrid.load(file).evidence, grid.evidence)


def test_failed_save_keeps_the_old_map(grid: OccupancyGrid, file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = file.read_bytes()
    grid.forget(grid.free)

    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(MapError, match="No space left"):
        grid.save(file)
    assert file.read_bytes() == old
    assert [each.name for each in file.parent.iterdir()] == ["hall.npz"]


def test_message_names_the_file_and_the_remedy(file: Path, raises: Raises) -> None:
    change(file, cell_m=-1.0)
    with raises(MapError, "map-damaged"):
        OccupancyGrid.load(file)
