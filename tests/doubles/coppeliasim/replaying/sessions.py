"""The recorded sessions: what a client asked, and what a real server replied.

``_*wait*_`` and ``_*executed*_`` are not kept: how often they come is timing. That a call waited is kept.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.doubles.coppeliasim.zmq.table import table

RECORDED = Path(__file__).parents[1] / "recorded"
EXECUTED, WAIT = "_*executed*_", "_*wait*_"
ELSEWHERE = "<see sim-info.json>"

Message = dict[str, Any]


@dataclass(frozen=True)
class Exchange:
    """A request and the reply to it; ``raw`` is the reply as it was sent, where it was kept."""

    line: int
    request: Message
    reply: Message
    waited: bool
    raw: bytes | None

    @property
    def name(self) -> str:
        """The function that was called, or ``eval``."""
        return str(self.request.get("func", "eval"))


def session(file: str) -> list[Exchange]:
    """Return the exchanges of a recorded session, in order."""
    return list(_exchanges(_messages(file)))


def _messages(file: str) -> Iterator[tuple[int, Message]]:
    for number, text in enumerate((RECORDED / file).read_text().splitlines(), start=1):
        yield number, json.loads(text)


def _exchanges(messages: Iterator[tuple[int, Message]]) -> Iterator[Exchange]:
    asked, waited = (0, dict[str, Any]()), False
    for number, message in messages:
        body = _decoded(message["body"])
        if message["dir"] == "request":
            if body.get("func") != EXECUTED:
                asked, waited = (number, body), False
        elif body.get("func") == WAIT:
            waited = True
        elif asked[0]:
            raw = base64.b64decode(message["raw_b64"]) if "raw_b64" in message else None
            yield Exchange(*asked, body, waited, raw)


def _decoded(body: Any) -> Any:
    """Return a body with its bytes as such, and the table of functions in its place."""
    if isinstance(body, dict):
        if "__bytes__" in body:
            return base64.b64decode(body["__bytes__"])
        return {key: _decoded(each) for key, each in body.items()}
    if isinstance(body, list):
        return [_decoded(each) for each in body]
    return table() if body == ELSEWHERE else body
