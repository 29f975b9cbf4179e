"""Answers that come in several pieces, as they do in the operation modes for heavy data."""

from __future__ import annotations

from dataclasses import replace

from drivers.vrep.wire.messages import Piece
from drivers.vrep.wire.request import Identity


class Assembly:
    """Keeps pieces until their answer is whole. An answer of another size begins anew."""

    def __init__(self) -> None:
        self._begun: dict[Identity, bytearray] = {}

    def whole(self, piece: Piece) -> Piece | None:
        """Return the answer if this piece makes it whole."""
        if piece.is_whole:
            return piece
        identity = piece.command, piece.key
        begun = self._begun.get(identity)
        if begun is None or len(begun) != piece.total:
            begun = self._begun[identity] = bytearray(piece.total)
        end = piece.offset + len(piece.data)
        begun[piece.offset : end] = piece.data
        if end < piece.total:
            return None
        return replace(piece, data=memoryview(bytes(self._begun.pop(identity))), offset=0)
