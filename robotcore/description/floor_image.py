"""The picture on the floor of a world, such as a printed course."""

from __future__ import annotations

from base64 import b64decode, b64encode
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, model_validator
from pydantic.json_schema import SkipJsonSchema

from robotcore.description.file_reading import read_limited
from robotcore.description.lines import Array
from robotcore.description.png import Pixels, decode_png
from robotcore.description.types import MAX_METRES, MIN_METRES, Colour, Coordinate, Metres, StrictModel
from robotcore.errors import Mistake, UsageError

MAX_IMAGE_BYTES = 2**21
"""The greatest size of a picture's file, in bytes. A recording holds its text of 4/3 of this size in one message."""


class FloorImage(StrictModel):
    """A picture on the floor. Its columns run along the world's x axis, and its top is at the greatest y.

    >>> from base64 import b64encode
    >>> import cv2
    >>> import numpy as np
    >>> _, png = cv2.imencode(".png", np.zeros((10, 20, 3), np.uint8))
    >>> image = FloorImage(file="course.png", length_m=2.0, content=b64encode(png).decode())
    >>> image.width_m
    1.0
    """

    file: str
    """The name of a PNG file in the folder of the world's file."""
    length_m: Metres
    """The length of the picture along x, in metres. Its width along y follows from its pixels, which are square."""
    x_m: Coordinate = 0.0
    """The x coordinate of the picture's middle in the world's frame, in metres."""
    y_m: Coordinate = 0.0
    """The y coordinate of the picture's middle in the world's frame, in metres."""
    content: Annotated[SkipJsonSchema[str], Field(repr=False)]
    """The bytes of the file in Base64. A world's file has no such key: loading it reads the picture."""

    @model_validator(mode="before")
    @classmethod
    def _read_content(cls, table: Any, info: ValidationInfo) -> Any:
        # Only files are validated with a context.
        if info.context is None or not isinstance(table, dict):
            return table
        if "content" in table:
            raise Mistake("content is unknown", "Remove it", kind="unknown-key")
        name = table.get("file")
        content = _read_file(info.context["file"], name) if isinstance(name, str) else b""
        return {**table, "content": b64encode(content).decode()}

    @model_validator(mode="after")
    def _check_picture(self) -> FloorImage:
        # To compute the width, the picture is decoded.
        if not MIN_METRES <= self.width_m <= MAX_METRES:
            problem = f"the picture has a width of {self.width_m:g} m, outside of {MIN_METRES:g} to {MAX_METRES:g} m"
            raise Mistake(problem, "Change length_m, or cut the picture", kind="out-of-bounds")
        return self

    @property
    def width_m(self) -> float:
        """The width of the picture along y, in metres."""
        rows, columns = _decode(self.content).shape[:2]
        return float(self.length_m * rows / columns)

    @property
    def limits(self) -> tuple[float, float, float, float]:
        """The least x, the least y, the greatest x and the greatest y of the picture, in metres."""
        half_length, half_width = self.length_m / 2, self.width_m / 2
        return self.x_m - half_length, self.y_m - half_width, self.x_m + half_length, self.y_m + half_width

    def render(self, ground: Colour) -> Pixels:
        """Return red, green and blue of the picture on a floor of a colour, (rows, columns, 3), from 0 to 255.

        The first row is at the greatest y. The floor is visible through transparent pixels.
        """
        picture = _decode(self.content)
        opacity = picture[:, :, 3:]
        colours = picture[:, :, 2::-1]
        if (opacity == 255).all():
            return colours
        parts = opacity.astype(np.float32) / 255
        return np.rint(np.array(ground, np.float32) + (colours - np.array(ground, np.float32)) * parts).astype(np.uint8)

    def locate(self, points: Array) -> tuple[NDArray[np.bool_], NDArray[np.intp], NDArray[np.intp]]:
        """Return which points are on the picture, (n,), and the rows and the columns of these points in it.

        points: points of the world, (n, 2) in metres.
        """
        left, _, _, top = self.limits
        rows, columns = _decode(self.content).shape[:2]
        pixels = (points - (left, top)) * (columns / self.length_m, -rows / self.width_m)
        is_inside = np.asarray(((pixels >= 0) & (pixels < (columns, rows))).all(axis=1))
        column, row = pixels[is_inside].astype(np.intp).T
        return is_inside, row, column


def _read_file(world: str, name: str) -> bytes:
    if Path(name).name != name:
        problem = f"file {name[:40]!r} is not the plain name of a file"
        remedy = "Put the picture into the folder of the world's file, and write its name"
        raise Mistake(problem, remedy, kind="has-path")
    try:
        return read_limited(Path(world).parent / name, MAX_IMAGE_BYTES)
    except UsageError as error:
        problem, _, remedy = str(error).rpartition(". ")
        raise Mistake(problem, remedy, kind=error.kind) from error


@lru_cache(maxsize=4)
def _decode(content: str) -> Pixels:
    try:
        picture = decode_png(b64decode(content, validate=True))
    except Mistake:
        raise
    except ValueError as error:
        raise Mistake("the picture is not Base64", kind="not-base64") from error
    picture.flags.writeable = False
    return picture
