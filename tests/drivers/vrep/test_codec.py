"""Bytes: how messages are cut into packets, what they say, and what is no message."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import (
    MAX_PACKET_BYTES,
    VERSION,
    Piece,
    Unpacker,
    decode_message,
    encode_command,
    encode_message,
    encode_packets,
)
from drivers.vrep.wire.errors import GarbledReplyError, RefusedError
from drivers.vrep.wire.link import Assembly
from drivers.vrep.wire.requests import BLOCKING, ONESHOT, STREAMING, Request

RECORDED = Path(__file__).parents[2] / "doubles" / "coppeliasim" / "recorded"
JOINT = requests.joint_position(17)


def recorded_messages(name: str, direction: str) -> list[bytes]:
    chunks = (json.loads(line) for line in (RECORDED / name).read_text().splitlines())
    unpacker, messages = Unpacker(), list[bytes]()
    for chunk in chunks:
        if chunk["dir"] == direction and (message := unpacker.feed(bytes.fromhex(chunk["hex"]))):
            messages.append(message)
            unpacker = Unpacker()
    return messages


@given(st.binary(min_size=1, max_size=5000), st.integers(1, 2000))
def test_a_message_arrives_however_the_line_cuts_its_packets(message: bytes, size: int) -> None:
    line, unpacker = encode_packets(message), Unpacker()
    chunks = [line[at : at + size] for at in range(0, len(line), size)]
    assert [unpacker.feed(chunk) for chunk in chunks] == [None] * (len(chunks) - 1) + [message]


def test_no_packet_is_longer_than_the_maker_s() -> None:
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
        "0100 0100 0000 ff ff",
        "48545450 2f31",
    ],
    ids=["another byte order", "an empty packet", "a packet that came twice", "more than was asked for", "HTTP"],
)
def test_packets_that_no_server_sends_are_no_reply(line: str) -> None:
    with pytest.raises(GarbledReplyError, match="Look which program listens"):
        Unpacker().feed(bytes.fromhex(line))


@pytest.mark.parametrize("direction", ["client", "server"])
@pytest.mark.parametrize("name", ["legacy-wire.jsonl", "legacy-wire-2.jsonl", "legacy-wire-19999.jsonl"])
def test_every_recorded_message_is_understood_and_written_again_byte_by_byte(name: str, direction: str) -> None:
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
    ids=lambda value: value.words if isinstance(value, Request) else "",
)
def test_what_is_asked_is_what_the_official_binding_asked(request_: Request[object], mode: int) -> None:
    _, (ours,) = decode_message(encode_message(0, 0, [request_.encoded(mode)]))
    theirs = [
        piece for message in recorded_messages("legacy-wire.jsonl", "client") for piece in decode_message(message)[1]
    ]
    assert said(ours) in [said(piece) for piece in theirs]


def said(piece: Piece) -> tuple[int, int, bytes, bytes]:
    return piece.command, piece.mode, piece.key, bytes(piece.data)


def test_a_check_sum_that_is_sent_is_checked() -> None:
    message = bytearray(encode_message(7, 0, [JOINT.encoded()]))
    assert decode_message(bytes(message))[0].message == 7
    assert message[:2] != b"\0\0"
    message[-1] ^= 1
    with pytest.raises(GarbledReplyError, match="check sum"):
        decode_message(bytes(message))


def test_a_server_that_sends_no_check_sum_is_understood() -> None:
    message = encode_message(7, 0, [JOINT.encoded()])
    assert decode_message(b"\0\0" + message[2:]) == decode_message(message)


@pytest.mark.parametrize("version", [0, 12, 255])
def test_a_version_that_is_not_known_is_refused(version: int) -> None:
    message = bytearray(encode_message(0, 0, []))
    message[:3] = 0, 0, version
    with pytest.raises(GarbledReplyError, match=f"its version is {version}"):
        decode_message(bytes(message))


@given(st.data())
def test_a_message_that_is_cut_or_changed_is_understood_or_reported(data: st.DataObject) -> None:
    message = bytearray(encode_message(3, 4, [JOINT.encoded(), requests.object_handle("/a").encoded()]))
    message[:2] = b"\0\0"
    for at in data.draw(st.lists(st.integers(0, len(message) - 1), max_size=4)):
        message[at] = data.draw(st.integers(0, 255))
    cut = bytes(message[: data.draw(st.integers(0, len(message)))])
    with suppress(GarbledReplyError):
        header, _ = decode_message(cut)
        assert 1 <= header.version <= VERSION


def test_an_answer_in_pieces_is_whole_when_its_last_piece_has_come() -> None:
    def piece(offset: int, data: bytes, total: int) -> Piece:
        return Piece(1, b"k", 0x30000, 50, False, memoryview(data), offset, total)

    assembly = Assembly()
    assert assembly.whole(piece(0, b"abc", 7)) is None
    assert assembly.whole(piece(0, b"ABC", 8)) is None
    assert assembly.whole(piece(3, b"DEF", 8)) is None
    whole = assembly.whole(piece(6, b"GH", 8))
    assert whole is not None
    assert bytes(whole.data) == b"ABCDEFGH"


@given(st.binary(max_size=60), st.sampled_from([requests.colour_image(1), requests.proximity(1), requests.LAST_ERRORS]))
def test_an_answer_of_any_bytes_is_a_value_or_reported(data: bytes, request_: Request[object]) -> None:
    with suppress(GarbledReplyError):
        request_.read(Piece(1, b"", 0, 0, False, memoryview(data)))


def test_a_request_that_failed_is_reported_with_what_was_asked() -> None:
    with pytest.raises(RefusedError, match="refused to find '/nope'"):
        requests.object_handle("/nope").read(Piece(1, b"", 0, 0, True, memoryview(b"")))
