"""The file of a map: a ZIP archive of NumPy arrays (``.npz``) that is read without pickle.

`read_arrays` checks the names, the types and the sizes of the arrays before it reads their contents. So a damaged or
hostile file costs no more memory than the largest map.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from robotcore.errors import MapError
from robotcore.files import replace_file

MAX_COUNT = 4000
"""The greatest number of rows of a map in a file."""

MAX_COORDINATE_M = 1e6
"""The greatest coordinate of a map in a file, in metres."""

SCALARS = ("size_m", "cell_m", "centre_x_m", "centre_y_m", "travelled")
"""The numbers in the file, each an array of the shape () with the type float64."""

LAYERS = ("evidence", "nearest_echo_m", "updated_at")
"""The layers in the file, each an array of the shape (rows, rows) with the type float32."""

_DAMAGE_ERRORS = (zipfile.BadZipFile, zlib.error, KeyError, ValueError, EOFError, RuntimeError, MemoryError)
"""The exceptions of a file that is no archive, is damaged, is encrypted, or has arrays of another form."""

Layer = NDArray[np.float32]


def write_arrays(file: Path, scalars: Mapping[str, float], layers: Mapping[str, Layer]) -> None:
    """Write the numbers and the layers of a map.

    Raises MapError if the file cannot be written, or if `read_arrays` would refuse it.
    """
    ordered = {name: np.ascontiguousarray(layer, np.float32) for name, layer in layers.items()}
    try:
        _require_readable(scalars, ordered)
    except ValueError as error:
        remedy = "Change this value of the map, and save it again"
        raise MapError(file, f"cannot hold this map: {error}", remedy, kind="map-out-of-limits") from None
    arrays: dict[str, Any] = {**{name: np.float64(value) for name, value in scalars.items()}, **ordered}
    try:
        with replace_file(file) as part, part.open("wb") as stream:
            np.savez_compressed(stream, **arrays)
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}"
        remedy = "Name a file that you can write, on a disk with free space"
        raise MapError(file, problem, remedy, kind="map-not-writable") from None


def read_arrays(file: Path) -> tuple[dict[str, float], dict[str, Layer]]:
    """Return the numbers and the layers of a map. Raises MapError if the file is missing or is no valid map."""
    try:
        _require_file(file)
        with zipfile.ZipFile(file) as archive:
            scalars = {name: float(_read(archive, name, np.dtype(np.float64), ())) for name in SCALARS}
            count = _compute_count(scalars)
            shape = (count, count)
            layers = {name: _read(archive, name, np.dtype(np.float32), shape) for name in LAYERS}
    except OSError as error:
        remedy = "Name a file that you can read"
        raise MapError(file, f"cannot be read: {error.strerror or error}", remedy, kind="map-not-readable") from None
    except MapError:
        raise
    except _DAMAGE_ERRORS as error:
        remedy = "Save the map again with OccupancyGrid.save"
        raise MapError(file, f"is not a map, or is damaged: {error}", remedy, kind="map-damaged") from None
    return scalars, layers


def _require_file(file: Path) -> None:
    if not file.is_file():
        problem = "is not a file" if file.exists() else "does not exist"
        raise MapError(file, problem, "Name a file that OccupancyGrid.save has written", kind="no-map-file")


def _require_readable(scalars: Mapping[str, float], layers: Mapping[str, Layer]) -> None:
    """Raise ValueError if `read_arrays` would refuse these numbers or layers."""
    count = _compute_count(scalars)
    for name, layer in layers.items():
        if layer.shape != (count, count):
            raise ValueError(f"the shape of {name} is {layer.shape} in place of {(count, count)}")
        _require_numbers(name, layer)


def _compute_count(scalars: Mapping[str, float]) -> int:
    """Return the number of rows. Raises ValueError if a number is impossible."""
    size, cell = scalars["size_m"], scalars["cell_m"]
    for name, value in scalars.items():
        if not abs(value) <= MAX_COORDINATE_M:
            raise ValueError(f"{name} is {value:g}, and -{MAX_COORDINATE_M:g} to {MAX_COORDINATE_M:g} are possible")
    if not (cell > 0 and size > 0 and scalars["travelled"] >= 0):
        raise ValueError(f"size_m is {size}, cell_m is {cell}, and travelled is {scalars['travelled']}")
    if not 1 <= size / cell <= MAX_COUNT:
        raise ValueError(f"its side has {size / cell:g} cells, and 1 to {MAX_COUNT} are possible")
    return round(size / cell)


def _read(archive: zipfile.ZipFile, name: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Return one array. Raises ValueError if it is not of this type and shape."""
    compression = archive.getinfo(f"{name}.npy").compress_type
    if compression not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} has the compression {compression}, and NumPy does not write it")
    with archive.open(f"{name}.npy") as stream:
        _require_form(stream, name, dtype, shape)
        length = math.prod(shape) * dtype.itemsize
        content = stream.read(length + 1)
    if len(content) != length:
        raise ValueError(f"{name} has {len(content)} bytes in place of {length}")
    array = np.frombuffer(content, dtype).reshape(shape).copy()
    _require_numbers(name, array)
    return array


def _require_numbers(name: str, array: NDArray[Any]) -> None:
    if np.isnan(array).any():
        raise ValueError(f"{name} has a value that is not a number")


def _require_form(stream: IO[bytes], name: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> None:
    """Raise ValueError unless the header is the one that NumPy writes, up to the spaces at its end.

    NumPy's parser raises many exceptions for a damaged header, so it does not get the header.
    """
    expected = BytesIO()
    form = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(expected, form)
    if _read_header(stream) != _read_header(BytesIO(expected.getvalue())):
        raise ValueError(f"{name} has another type, shape or format")


def _read_header(stream: IO[bytes]) -> tuple[bytes, bytes]:
    """Return the name of the format, and the description of the array without the spaces that follow it."""
    magic, length = stream.read(np.lib.format.MAGIC_LEN), int.from_bytes(stream.read(2), "little")
    return magic, stream.read(length).rstrip()
