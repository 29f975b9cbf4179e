"""Recordings with random changes: of bytes, lengths, values, or the order of records."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import NamedTuple

from tests.robotcore.recording.hostile_files.mcap_builder import Raw, build_chunk, build_file, build_record, read_raw

_LENGTHS = (0, 1, 2, 100, 2**16, 2**31, 2**62, 2**64 - 1)
_VALUES = (
    *("NaN", "Infinity", "-1", "0", "1e308", "-1e308", "1e9", "1" + "0" * 400, "null", "true", "[]", "{}", "[[[]]]"),
    *('""', '"nan"', '"inf"', '"\\u001b[2J"', '"../evil.py"', '"=cmd()"', '"' + "a" * 5000 + '"'),
)
_TOKEN = re.compile(rb'(?<=[:\[,])("[^"]*"|-?[0-9][^,\]}]*|true|false|null)')


class SourceRecording(NamedTuple):
    """A valid recording: its bytes, and the records of its chunks."""

    content: bytes
    chunks: list[list[Raw]]

    @classmethod
    def of(cls, file: Path) -> SourceRecording:
        return cls(file.read_bytes(), read_raw(file))


def mutate(source: SourceRecording, random: Random) -> bytes:
    """Return the recording with random changes as bytes. With a probability of one half, its checksums are valid."""
    if random.random() < 0.5:
        content = bytearray(source.content)
        for _ in range(random.randint(1, 3)):
            _change_bytes(content, random)
        return bytes(content)
    records = [record for chunk in source.chunks for record in chunk]
    for _ in range(random.randint(1, 6)):
        if records:
            _change_records(records, random)
    parts, step = [], random.choice((1, 20, 1000))
    for at in range(0, len(records), step):
        packed = b"".join(build_record(*record) for record in records[at : at + step])
        parts.append(build_chunk(packed, packing=random.choice(("zstd", ""))))
    return build_file(*parts)


def _change_bytes(content: bytearray, random: Random) -> None:
    at, size = random.randint(0, len(content)), random.choice((1, 8, 100, 5000))
    match random.choice(("flip", "flip", "cut", "drop", "repeat", "lengthen")):
        case "flip" if at < len(content):
            content[at] ^= random.randint(1, 255)
        case "cut":
            del content[at:]
        case "drop":
            del content[at : at + size]
        case "repeat":
            content[at:at] = content[at : at + size]
        case "lengthen":
            if heads := list(_find_lengths(content)):
                head, length = random.choice(heads), random.choice((*_LENGTHS, random.randrange(5000)))
                content[head : head + 8] = length.to_bytes(8, "little")


def _find_lengths(content: bytearray) -> Iterator[int]:
    """Yield the offset of the length in each record of a file."""
    at = 8
    while at + 9 <= len(content):
        yield at + 1
        at += 9 + int.from_bytes(content[at + 1 : at + 9], "little")


def _change_records(records: list[Raw], random: Random) -> None:
    at, other = random.randrange(len(records)), random.randrange(len(records))
    opcode, body = records[at]
    match random.choice(("value",) * 4 + ("flip", "shorten", "swap", "drop", "repeat", "shuffle")):
        case "value":
            if tokens := list(_TOKEN.finditer(body)):
                token = random.choice(tokens)
                value = random.choice(_VALUES).encode()
                records[at] = opcode, body[: token.start()] + value + body[token.end() :]
        case "flip" if body:
            flipped = bytearray(body)
            flipped[random.randrange(len(body))] ^= random.randint(1, 255)
            records[at] = opcode, bytes(flipped)
        case "shorten":
            records[at] = opcode, body[: random.randint(0, len(body))]
        case "swap":
            records[at], records[other] = records[other], records[at]
        case "drop":
            del records[at]
        case "repeat":
            records.insert(at, records[other])
        case "shuffle":
            random.shuffle(records)
