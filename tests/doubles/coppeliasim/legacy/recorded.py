"""Sessions of a real server on the line, and what their clients must have said.

A file holds what passed, chunk by chunk, both ways. From one of them repeated idle traffic was cut out, and with it
some messages: the numbers of those that are left show which. A message that is missing was empty, or it asked for what
the reply of its number answers and no message on record asked for; `Session.messages` has all of them again. Where a
question was cut out together with its reply, ``legacy-calls-2.json`` still has the call: see ``LOST``.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from tests.doubles.coppeliasim.legacy.codec import Command, Header, pack, read_message, unpack
from tests.doubles.coppeliasim.legacy.codes import Code, Mode

FOLDER = Path(__file__).parent.parent / "recorded"

PATIENCE = 40
"""A command was answered within so many messages: stopped, the real one's main loop took 125 ms, a message 5."""

LOST = {
    "legacy-wire-2.jsonl": {
        268: Command(Code.SYNCHRONOUS_NEXT, Mode.BLOCKING),
        284: Command(Code.SYNCHRONOUS_NEXT, Mode.BLOCKING),
    }
}
"""What was asked for of which nothing is on the line: two steps after the start. Their numbers are about right."""

DATA = {Code.SET_JOINT_TARGET_VELOCITY: struct.pack("<f", 1.0)}
"""What came with a command of which only the reply is on the line."""

Key = tuple[int, int, bytes]


@dataclass(frozen=True)
class Reply:
    """What the real server sent; ``answers`` is the number of the message that it is the reply to."""

    header: Header
    commands: list[Command]
    answers: int


@dataclass
class Session:
    """All that a client said, message by message, and the replies that are on record."""

    messages: list[bytes]
    replies: list[Reply]


def session(name: str) -> Session:
    """Return the session that is recorded in a file of that name."""
    rows = [json.loads(row) for row in (FOLDER / name).read_text().splitlines()]
    said = {unpack(message)[0].message: message for message in _messages(rows, "client")}
    asked = _Asked(said, LOST.get(name, {}))
    replies = [asked.reply(*unpack(message)) for message in _messages(rows, "server")]
    messages = [said.get(number) or asked.message(number) for number in range(max(said) + 1)]
    return Session(messages, [reply for reply in replies if reply.header.message >= 0])


def _messages(rows: list[dict[str, str]], who: str) -> Iterator[bytes]:
    line = io.BytesIO(b"".join(bytes.fromhex(row["hex"]) for row in rows if row["dir"] == who))
    size = len(line.getbuffer())
    while line.tell() < size:
        yield read_message(line.read)


class _Asked:
    """Which message asked for what, as far as is on record; what is answered all the same is put where it belongs."""

    def __init__(self, said: dict[int, bytes], lost: dict[int, Command]) -> None:
        self._open = [(number, _key(command)) for number, message in said.items() for command in unpack(message)[1]]
        self._streams: set[Key] = set()
        self._missing = {number: [command] for number, command in lost.items()}

    def message(self, number: int) -> bytes:
        """Return a message that is not on record."""
        return pack(Header(number, 0), self._missing.get(number, []))

    def reply(self, header: Header, commands: list[Command]) -> Reply:
        """Return a reply with the number of the last message that it answers."""
        asked = [self._asked(header.message, command) for command in commands]
        return Reply(header, commands, max((each for each in asked if each is not None), default=header.message))

    def _asked(self, number: int, command: Command) -> int | None:
        """Return the message that asked for this; None for a stream that goes on."""
        key = _key(command)
        is_open = ((n, k) for n, k in self._open if k == key and number - PATIENCE < n <= number)
        if found := next(is_open, None):
            self._open.remove(found)
        elif key in self._streams:
            return None
        else:
            found = (number, key)
            self._missing.setdefault(number, []).append(_request(command))
        if command.mode == Mode.STREAMING:
            self._streams.add(key)
        return found[0]


def _request(reply: Command) -> Command:
    return replace(reply, data=DATA.get(Code(reply.code), b""), status=0, sim_ms=0)


def _key(command: Command) -> Key:
    return command.code, command.mode, command.identity
