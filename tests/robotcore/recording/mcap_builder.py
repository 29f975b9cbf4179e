"""Build MCAP files record by record with valid checksums, so that forged content is not reported as damage."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import zstandard
from mcap.records import Channel

from robotcore.recording.chunks import MAGIC, ChunkedFile, read_records, unpack

HEADER, FOOTER, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x01, 0x02, 0x04, 0x05, 0x06, 0x0F

Raw = tuple[int, bytes]
"""A record of an MCAP file: its opcode and its body."""


def build_record(opcode: int, body: bytes, length: int | None = None) -> bytes:
    """Return a record as bytes. ``length`` replaces its true length."""
    return struct.pack("<BQ", opcode, len(body) if length is None else length) + body


def build_chunk(
    content: bytes,
    *,
    packed: bytes | None = None,
    size: int | None = None,
    packing: str = "zstd",
) -> bytes:
    """Return a chunk of records as bytes. ``packed`` and ``size`` replace the true values."""
    if packed is None:
        packed = zstandard.compress(content, 1) if packing == "zstd" else content
    head = struct.pack("<QQQI", 0, 0, len(content) if size is None else size, zlib.crc32(content))
    name = packing.encode()
    body = head + struct.pack("<I", len(name)) + name + struct.pack("<Q", len(packed)) + packed
    return build_record(CHUNK, body)


def build_file(*parts: bytes) -> bytes:
    """Return an MCAP file of records as bytes."""
    header, end = build_record(HEADER, bytes(8)), build_record(DATA_END, bytes(4))
    return b"".join((MAGIC, header, *parts, end, build_record(FOOTER, bytes(20)), MAGIC))


def build_channel(number: int, topic: str) -> bytes:
    text = topic.encode()
    return build_record(CHANNEL, struct.pack("<HHI", number, 0, len(text)) + text + bytes(8))


def build_message(channel: int, content: bytes) -> bytes:
    return build_record(MESSAGE, struct.pack("<HIQQ", channel, 1, 0, 0) + content)


def read_raw(file: Path) -> list[list[Raw]]:
    """Return the records of each chunk of a recording."""
    content = file.read_bytes()
    return [
        _split(bytes(unpack(place, content[place.offset : place.offset + place.length])))
        for place, _ in ChunkedFile(file).chunks()
    ]


def _split(data: bytes) -> list[Raw]:
    records, at = [], 0
    while at < len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        records.append((opcode, data[at + 9 : at + 9 + length]))
        at += 9 + length
    return records


def change_messages(file: Path, topic: str, change: Callable[[int, bytes], bytes]) -> bytes:
    """Return the file with each message of a topic changed, with valid checksums.

    change: returns the new message, given its number, from 0, and the old message.
    """
    chunks, numbers, count = read_raw(file), set[int](), 0
    for records in chunks:
        for index, (opcode, body) in enumerate(records):
            if opcode == CHANNEL and _topic(body) == topic:
                numbers.add(int.from_bytes(body[:2], "little"))
            elif opcode == MESSAGE and int.from_bytes(body[:2], "little") in numbers:
                records[index] = opcode, body[:22] + change(count, body[22:])
                count += 1
    return build_file(*(build_chunk(b"".join(build_record(*record) for record in records)) for records in chunks))


def change_json(file: Path, topic: str, change: Callable[[int, Any], Any]) -> bytes:
    """Return the file with the JSON of each message of a topic changed.

    change: returns the new JSON value, given the number of the message, from 0, and the old value.
    """
    return change_messages(
        file, topic, lambda number, content: json.dumps(change(number, json.loads(content))).encode()
    )


def _topic(body: bytes) -> str:
    (channel,) = read_records(build_record(CHANNEL, body))
    assert isinstance(channel, Channel)
    return channel.topic
