"""Recordings with random changes: of bytes, lengths, values, or the order of records."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import NamedTuple

from tests.robotcore.recording.hostile_files.mcap_builder import Raw, build_chunk, build_file, build_record, read_raw

_LENGTHS = (0, 1, 100, 2**16, 2**31, 2**62, 2**64 - 1)
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
            random.choice(_ON_BYTES)(content, random)
        return bytes(content)
    records = [record for chunk in source.chunks for record in chunk]
    for _ in range(random.randint(1, 6)):
        random.choice(_ON_RECORDS)(records, random)
    return _pack(records, random)


def _pack(records: list[Raw], random: Random) -> bytes:
    parts, step = [], random.choice((1, 20, 1000))
    for at in range(0, len(records), step):
        content = b"".join(build_record(*record) for record in records[at : at + step])
        parts.append(build_chunk(content, packing=random.choice(("zstd", ""))))
    return build_file(*parts)


def _flip(content: bytearray, random: Random) -> None:
    if content:
        content[random.randrange(len(content))] ^= random.randint(1, 255)


def _cut(content: bytearray, random: Random) -> None:
    del content[random.randint(0, len(content)) :]


def _drop(content: bytearray, random: Random) -> None:
    at = random.randint(0, len(content))
    del content[at : at + random.choice((1, 8, 100, 5000))]


def _repeat(content: bytearray, random: Random) -> None:
    at = random.randint(0, len(content))
    content[at:at] = content[at : at + random.choice((1, 8, 100, 5000))]


def _lengthen(content: bytearray, random: Random) -> None:
    heads, at = [], 8
    while at + 9 <= len(content):
        heads.append(at + 1)
        at += 9 + int.from_bytes(content[at + 1 : at + 9], "little")
    if heads:
        head, length = (
            random.choice(heads),
            random.choice((0, 1, 2**16, 2**31, 2**62, 2**64 - 1, random.randrange(5000))),
        )
        content[head : head + 8] = length.to_bytes(8, "little")


def _change_value(records: list[Raw], random: Random) -> None:
    texts = [at for at, (_, body) in enumerate(records) if body[22:23] == b"{"]
    if not texts:
        return
    at = random.choice(texts)
    opcode, body = records[at]
    if tokens := list(_TOKEN.finditer(body)):
        token = random.choice(tokens)
        records[at] = opcode, body[: token.start()] + random.choice(_VALUES).encode() + body[token.end() :]


def _flip_in_record(records: list[Raw], random: Random) -> None:
    if records:
        at = random.randrange(len(records))
        body = bytearray(records[at][1])
        _flip(body, random)
        records[at] = records[at][0], bytes(body)


def _shorten_record(records: list[Raw], random: Random) -> None:
    if records:
        at = random.randrange(len(records))
        opcode, body = records[at]
        records[at] = opcode, body[: random.randint(0, len(body))]


def _swap(records: list[Raw], random: Random) -> None:
    if len(records) > 1:
        one, other = random.sample(range(len(records)), 2)
        records[one], records[other] = records[other], records[one]


def _drop_record(records: list[Raw], random: Random) -> None:
    if records:
        del records[random.randrange(len(records))]


def _repeat_record(records: list[Raw], random: Random) -> None:
    if records:
        records.insert(random.randrange(len(records)), random.choice(records))


def _shuffle(records: list[Raw], random: Random) -> None:
    random.shuffle(records)


_ON_BYTES: tuple[Callable[[bytearray, Random], None], ...] = (_flip, _flip, _cut, _drop, _repeat, _lengthen)
_ON_RECORDS: tuple[Callable[[list[Raw], Random], None], ...] = (
    *(_change_value, _change_value, _change_value, _change_value),
    *(_flip_in_record, _shorten_record, _swap, _drop_record, _repeat_record, _shuffle),
)
