"""A picture on the floor: its colours at points of the world, its files, and mistakes in them."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from robotcore.description import FloorImage, WorldDescription, find_floor_image, load_world
from robotcore.description.doubtful_values import find_bodies_outside
from robotcore.description.floor_colours import FloorColours
from robotcore.description.floor_image import MAX_IMAGE_BYTES
from robotcore.description.png import MAX_PIXELS, MAX_SIDE_PX, decode_png
from robotcore.errors import DescriptionError, Mistake
from tests.robotcore.description.courses import COURSE, QUADRANTS, encode_png, load_course, write_course
from tests.texts import CheckText, Raises

RED, GREEN, BLUE, WHITE, PLAIN = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255), (200, 190, 180)
LINE = "[[lines]]\nwidth_m = 0.1\npoints_m = [[-1.0, 0.0], [1.0, 0.0]]\ncolour = [1, 2, 3]\n"


def measure(world: WorldDescription, *points: tuple[float, float]) -> list[tuple[int, ...]]:
    """Return the colours of the floor at points."""
    return [tuple(round(part) for part in colour) for colour in FloorColours(world).measure(np.array(points)).tolist()]


def test_top_of_the_picture_is_at_the_greatest_y_and_its_left_at_the_least_x(tmp_path: Path) -> None:
    colours = measure(load_course(tmp_path), (-0.24, 0.24), (1.24, 0.24), (-0.24, -0.74), (1.24, -0.74))
    assert colours == [RED, GREEN, BLUE, WHITE]


def test_floor_outside_of_the_picture_is_plain(tmp_path: Path) -> None:
    colours = measure(load_course(tmp_path), (-0.26, 0.0), (1.26, 0.0), (0.5, 0.26), (0.5, -0.76), (9.0, 9.0))
    assert colours == [PLAIN] * 5


def test_line_covers_the_picture_and_the_picture_covers_the_pattern(tmp_path: Path) -> None:
    text = COURSE.replace("colour =", 'texture = { pattern = "checker", contrast = 0.5 }\ncolour =') + LINE
    world = load_course(tmp_path, text=text)
    assert measure(world, (0.0, 0.0), (0.0, 0.2), (-0.9, 0.04)) == [(1, 2, 3), RED, (1, 2, 3)]
    assert measure(world, (-1.5, 1.4)) == [(100, 95, 90)]


@pytest.mark.parametrize(
    "pixel, colour",
    [
        ((255, 0, 0, 255), RED),
        ((255, 0, 0, 0), PLAIN),
        ((255, 0, 0, 51), (211, 152, 144)),
        (77, (77, 77, 77)),
        (np.uint16(0xFF80), WHITE),
    ],
    ids=["opaque", "transparent", "in between", "grey", "16 bits"],
)
def test_floor_is_visible_through_transparent_pixels(tmp_path: Path, pixel: Any, colour: tuple[int, ...]) -> None:
    picture = np.zeros((4, 4, *np.shape(pixel)), np.uint16 if isinstance(pixel, np.uint16) else np.uint8)
    picture[:] = pixel
    assert measure(load_course(tmp_path, picture), (0.5, -0.25)) == [colour]


def test_width_follows_from_the_pixels(tmp_path: Path) -> None:
    image = load_course(tmp_path).floor.image
    assert image
    assert image.width_m == pytest.approx(1.0)
    assert image.limits == pytest.approx((-0.25, -0.75, 1.25, 0.25))


def test_description_holds_the_picture_without_its_file(tmp_path: Path) -> None:
    world = load_course(tmp_path)
    (tmp_path / "course.png").unlink()
    copy = WorldDescription.model_validate_json(world.model_dump_json())
    assert copy == world
    assert measure(copy, (-0.24, 0.24)) == [RED]
    assert "content" not in repr(world)


def test_path_of_the_picture_is_beside_the_world(tmp_path: Path) -> None:
    assert find_floor_image(write_course(tmp_path)) == tmp_path / "course.png"
    assert find_floor_image("track") is None


def test_picture_partly_outside_of_the_floor_is_a_warning(tmp_path: Path, check_text: CheckText) -> None:
    assert list(find_bodies_outside(load_course(tmp_path))) == []
    check_text("\n".join(find_bodies_outside(load_course(tmp_path, text=COURSE.replace("x_m = 0.5", "x_m = 1.3")))))


KEYS = 'file = "course.png", length_m = 1.5'


@pytest.mark.parametrize(
    "keys, key, kind",
    [
        ('length_m = 1.5, file = "gone.png"', "floor.image", "unreadable-file"),
        ('length_m = 1.5, file = "."', "floor.image", "has-path"),
        ('length_m = 1.5, file = ""', "floor.image", "unreadable-file"),
        ('length_m = 1.5, file = "a\\u0000b.png"', "floor.image", "unreadable-file"),
        ('length_m = 1.5, file = "../course.png"', "floor.image", "has-path"),
        ('length_m = 1.5, file = "/etc/passwd"', "floor.image", "has-path"),
        ('length_m = 1.5, file = "course.toml"', "floor.image", "not-png"),
        ("length_m = 1.5, file = 3", "floor.image.file", "wrong-value"),
        ("length_m = 1.5", "floor.image.file", "missing-key"),
        ('file = "course.png"', "floor.image.length_m", "missing-key"),
        ('file = "course.png", length_m = 0.0', "floor.image.length_m", "out-of-bounds"),
        ('file = "course.png", length_m = -1.0', "floor.image.length_m", "out-of-bounds"),
        ('file = "course.png", length_m = nan', "floor.image.length_m", "wrong-value"),
        ('file = "course.png", length_m = 101.0', "floor.image.length_m", "out-of-bounds"),
        ('file = "course.png", length_m = 0.001', "floor.image", "out-of-bounds"),
        (f"{KEYS}, width_m = 1.0", "floor.image.width_m", "unknown-key"),
        (f"{KEYS}, x_m = inf", "floor.image.x_m", "wrong-value"),
        (f'{KEYS}, content = ""', "floor.image", "unknown-key"),
    ],
)
def test_mistake_in_the_keys_has_its_key_and_kind(
    tmp_path: Path, check_text: CheckText, keys: str, key: str, kind: str
) -> None:
    text = COURSE.replace('file = "course.png", length_m = 1.5, x_m = 0.5, y_m = -0.25', keys)
    with pytest.raises(DescriptionError) as caught:
        load_course(tmp_path, text=text)
    assert (caught.value.key, caught.value.kind, caught.value.others) == (key, kind, ())
    check_text(caught.value, hide=[tmp_path])


def test_picture_that_is_no_table_is_refused(tmp_path: Path, raises: Raises) -> None:
    with raises(DescriptionError, "wrong-form", hide=[tmp_path]):
        load_course(tmp_path, text=COURSE.replace('{ file = "course.png", length_m', '"course.png"\n# {'))


def state_size(width: int, height: int) -> bytes:
    """Return an intact PNG of one pixel whose header states another size."""
    png = encode_png(np.zeros((1, 1, 3), np.uint8))
    header = b"IHDR" + struct.pack(">II", width, height) + png[24:29]
    return png[:12] + header + struct.pack(">I", zlib.crc32(header)) + png[33:]


PNG = encode_png(QUADRANTS)


@pytest.mark.parametrize(
    "content, kind",
    [
        (b"", "not-png"),
        (b"\xff\xd8\xff\xe0 a JPEG", "not-png"),
        (PNG[:8], "damaged-png"),
        (PNG[:20], "damaged-png"),
        (PNG[: len(PNG) // 2], "damaged-png"),
        (PNG[:-12], "damaged-png"),
        (PNG[:50] + bytes([PNG[50] ^ 1]) + PNG[51:], "damaged-png"),
        (PNG[:8] + PNG[-12:], "damaged-png"),
        (state_size(2**31 - 1, 2**31 - 1), "too-many-pixels"),
        (state_size(MAX_PIXELS + 1, 1), "too-many-pixels"),
        (state_size(MAX_SIDE_PX + 1, 1), "too-long-side"),
        (state_size(1, MAX_SIDE_PX + 1), "too-long-side"),
        (PNG + bytes(MAX_IMAGE_BYTES), "file-too-large"),
    ],
    ids=[
        "empty",
        "jpeg",
        "begin",
        "header",
        "half",
        "no end",
        "bit",
        "no header",
        "huge",
        "large",
        "wide",
        "high",
        "long",
    ],
)
def test_file_that_is_no_small_png_is_refused(
    tmp_path: Path, content: bytes, kind: str, raises: Raises, capfd: pytest.CaptureFixture[str]
) -> None:
    with raises(DescriptionError, kind, hide=[tmp_path]):
        load_course(tmp_path, content)
    assert capfd.readouterr() == ("", "")


def add_transparency(picture: Any, colour: bytes) -> bytes:
    """Return a PNG in which one colour is transparent."""
    png, chunk = encode_png(picture), b"tRNS" + colour
    at = png.index(b"IDAT") - 4
    return png[:at] + struct.pack(">I", len(colour)) + chunk + struct.pack(">I", zlib.crc32(chunk)) + png[at:]


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_transparent_grey_is_refused(tmp_path: Path, depth: type, raises: Raises) -> None:
    with raises(DescriptionError, "transparent-grey", hide=[tmp_path]):
        load_course(tmp_path, add_transparency(np.full((4, 4), 77, depth), b"\0\x4d"))


def test_transparent_colour_shows_the_floor(tmp_path: Path) -> None:
    picture = add_transparency(np.full((4, 4, 3), 77, np.uint8), b"\0\x4d" * 3)
    assert measure(load_course(tmp_path, picture), (0.5, -0.25)) == [PLAIN]


def test_picture_with_the_longest_side_is_decoded() -> None:
    assert decode_png(encode_png(np.zeros((1, MAX_SIDE_PX), np.uint8))).shape == (1, MAX_SIDE_PX, 4)


def test_damaged_pixels_are_refused(tmp_path: Path, raises: Raises) -> None:
    with raises(DescriptionError, "damaged-png", hide=[tmp_path]):
        load_course(tmp_path, state_size(40, 40))


@given(
    cuts=st.lists(st.tuples(st.integers(0, len(PNG)), st.integers(0, 20), st.binary(max_size=20)), max_size=4),
    is_summed=st.booleans(),
)
def test_changed_png_is_a_picture_or_a_mistake(cuts: list[tuple[int, int, bytes]], *, is_summed: bool) -> None:
    content = PNG
    for at, length, text in cuts:
        content = content[:at] + text + content[at + length :]
    with suppress(Mistake):
        picture = decode_png(_sum_chunks(content) if is_summed else content)
        assert picture.ndim == 3
        assert picture.shape[2] == 4
        assert picture.shape[0] * picture.shape[1] <= MAX_PIXELS


def _sum_chunks(content: bytes) -> bytes:
    """Correct the checksums of the chunks of a PNG, as far as it has chunks."""
    at, parts = 8, [content[:8]]
    while at + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        chunk = content[at + 4 : at + 8 + length]
        parts.append(content[at : at + 4] + chunk + struct.pack(">I", zlib.crc32(chunk)))
        at += 12 + length
    return b"".join(parts)


def make_pipe(path: Path) -> None:
    os.mkfifo(path)


@pytest.mark.parametrize(
    "make, kind", [(Path.mkdir, "unreadable-file"), (make_pipe, "no-regular-file")], ids=["folder", "pipe"]
)
def test_picture_that_is_no_file_is_refused(
    tmp_path: Path, make: Callable[[Path], None], kind: str, raises: Raises
) -> None:
    file = write_course(tmp_path)
    (tmp_path / "course.png").unlink()
    make(tmp_path / "course.png")
    with raises(DescriptionError, kind, hide=[tmp_path]):
        load_world(file)


@pytest.mark.parametrize("content", ["", "no Base64", "c29tZSB0ZXh0", 3, None])
def test_recorded_picture_that_is_none_is_refused(content: Any) -> None:
    with pytest.raises(ValidationError):
        FloorImage.model_validate({"file": "course.png", "length_m": 1.0, "content": content})
