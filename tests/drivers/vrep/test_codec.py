"""Tests of packets, messages and requests as bytes, and of invalid bytes."""

from __future__ import annotations

import io
import json
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import VERSION, Piece, decode_message, encode_command, encode_message
from drivers.vrep.wire.errors import ProtocolError, RefusedError
from drivers.vrep.wire.message_socket import MAX_PACKET_BYTES, AnswerAssembler, encode_packets, read_packets
from drivers.vrep.wire.requests import BLOCKING, ONESHOT, STREAMING, Request
from tests.texts import Raises

RECORDED = Path(__file__).parents[2] / "doubles" / "coppeliasim" / "recorded"
JOINT = requests.joint_position(17)


def recorded_messages(name: str, direction: str) -> list[bytes]:
    chunks = (json.loads(line) for line in (RECORDED / name).read_text().splitlines())
    line = io.BytesIO(b"".join(bytes.fromhex(chunk["hex"]) for chunk in chunks if chunk["dir"] == direction))
    messages = list[bytes]()
    with suppress(ConnectionResetError):
        while True:
            messages.append(read_packets(line.read))
    return messages


@given(st.binary(min_size=1, max_size=5000))
def test_packets_are_read_back(message: bytes) -> None:
    line = io.BytesIO(encode_packets(message) + b"more")
    assert (read_packets(line.read), line.read()) == (message, b"more")


def test_packets_have_the_size_of_the_makers() -> None:
    line = encode_packets(bytes(3000))
    sizes = [1294, 1294, 412]
    assert len(line) == 3000 + 6 * len(sizes)
    assert [line[at : at + 6] for at in (0, MAX_PACKET_BYTES, 2 * MAX_PACKET_BYTES)] == [
        bytes.fromhex("0100 0e05 0200"),
        bytes.fromhex("0100 0e05 0100"),
        bytes.fromhex("0100 9c01 0000"),
    ]


@pytest.mark.parametrize(
    "line",
    [
        "0001 0500 0000 0102030405",
        "0100 0000 0000",
        "0100 0100 0200 ff 0100 0100 0200 ff",
        "48545450 2f31",
    ],
    ids=["another byte order", "an empty packet", "a packet that came twice", "HTTP"],
)
def test_invalid_packets_are_an_error(line: str, raises: Raises) -> None:
    with raises(ProtocolError):
        read_packets(io.BytesIO(bytes.fromhex(line)).read)


@pytest.mark.parametrize("direction", ["client", "server"])
@pytest.mark.parametrize("name", ["legacy-wire.jsonl", "legacy-wire-2.jsonl", "legacy-wire-19999.jsonl"])
def test_each_recorded_message_is_decoded_and_encoded_again(name: str, direction: str) -> None:
    for message in recorded_messages(name, direction):
        header, pieces = decode_message(message)
        again = decode_message(
            encode_message(
                header.message,
                header.client_time_ms,
                [encode_command(each.command, each.mode, 0, each.key, bytes(each.data)) for each in pieces],
            )
        )
        assert [(each.command, each.mode, each.key, each.data) for each in again[1]] == [
            (each.command, each.mode, each.key, each.data) for each in pieces
        ]
        assert again[0].message == header.message
        assert header.version == 11


@pytest.mark.parametrize(
    "request_, mode",
    [
        (requests.object_handle("/rover/leftMotor"), BLOCKING),
        (requests.SYNCHRONOUS_ON, BLOCKING),
        (requests.START, BLOCKING),
        (requests.STOP, BLOCKING),
        (requests.TRIGGER, BLOCKING),
        (requests.CLOCK, BLOCKING),
        (requests.colour_image(23), STREAMING),
        (requests.grey_image(23), BLOCKING),
        (requests.proximity(29), STREAMING),
        (requests.set_colour_image(24, bytes(range(256)) * 2 + bytes(range(64))), ONESHOT),
        (requests.joint_target_velocity(17, 3), STREAMING),
        (requests.joint_position(17), BLOCKING),
        (requests.object_position(16), BLOCKING),
    ],
    ids=lambda value: value.action if isinstance(value, Request) else "",
)
def test_requests_equal_those_of_the_official_binding(request_: Request[object], mode: int) -> None:
    _, (ours,) = decode_message(encode_message(0, 0, [request_.encode(mode)]))
    theirs = [
        piece for message in recorded_messages("legacy-wire.jsonl", "client") for piece in decode_message(message)[1]
    ]
    assert to_tuple(ours) in [to_tuple(piece) for piece in theirs]


def to_tuple(piece: Piece) -> tuple[int, int, bytes, bytes]:
    return piece.command, piece.mode, piece.key, bytes(piece.data)


def test_wrong_check_sum_is_an_error(raises: Raises) -> None:
    message = bytearray(encode_message(7, 0, [JOINT.encode()]))
    assert decode_message(bytes(message))[0].message == 7
    assert message[:2] != b"\0\0"
    message[-1] ^= 1
    with raises(ProtocolError):
        decode_message(bytes(message))


def test_message_without_a_check_sum_is_decoded() -> None:
    message = encode_message(7, 0, [JOINT.encode()])
    assert decode_message(b"\0\0" + message[2:]) == decode_message(message)


@pytest.mark.parametrize("version", [0, 12, 255])
def test_unknown_version_is_an_error(version: int, raises: Raises) -> None:
    message = bytearray(encode_message(0, 0, []))
    message[:3] = 0, 0, version
    with raises(ProtocolError):
        decode_message(bytes(message))


@given(st.data())
def test_damaged_message_is_decoded_or_an_error(data: st.DataObject) -> None:
    message = bytearray(encode_message(3, 4, [JOINT.encode(), requests.object_handle("/a").encode()]))
    message[:2] = b"\0\0"
    for at in data.draw(st.lists(st.integers(0, len(message) - 1), max_size=4)):
        message[at] = data.draw(st.integers(0, 255))
    cut = bytes(message[: data.draw(st.integers(0, len(message)))])
    with suppress(ProtocolError):
        header, _ = decode_message(cut)
        assert 1 <= header.version <= VERSION


def test_answer_in_pieces_is_complete_after_its_last_piece() -> None:
    def piece(offset: int, data: bytes, total: int) -> Piece:
        return Piece(1, b"k", 0x30000, 50, False, memoryview(data), offset, total)

    assembler = AnswerAssembler()
    assert assembler.add(piece(0, b"abc", 7)) is None
    assert assembler.add(piece(0, b"ABC", 8)) is None
    assert assembler.add(piece(3, b"DEF", 8)) is None
    whole = assembler.add(piece(6, b"GH", 8))
    assert whole is not None
    assert bytes(whole.data) == b"ABCDEFGH"


@given(
    st.binary(max_size=60), st.sampled_from([requests.colour_image(1), requests.proximity(1), requests.OBJECT_NAMES])
)
def test_answer_of_any_bytes_is_a_value_or_an_error(data: bytes, request_: Request[object]) -> None:
    with suppress(ProtocolError):
        request_.read(Piece(1, b"", 0, 0, False, memoryview(data)))


def test_failed_request_is_an_error_with_its_action(raises: Raises) -> None:
    with raises(RefusedError, action="find '/nope'"):
        requests.object_handle("/nope").read(Piece(1, b"", 0, 0, True, memoryview(b"")))
