"""The samples of a recording: numbers are at hand, pictures are read when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from robotcore.errors import RecordingError
from robotcore.hal.devices import Frame, Image
from robotcore.recording.chunks import ChunkedFile
from robotcore.recording.events import Recorded, SampleKey
from robotcore.recording.records import DAMAGE, ChunkLocation, Message, damage_at

CHUNKS_KEPT = 2
"""Unpacked; pictures are mostly asked for in the order in which they were taken."""

Unpack = Callable[[memoryview], Image]


@dataclass(frozen=True)
class Picture:
    """Where a picture is: which message of which channel in a chunk; ``unpack`` makes it a picture again.

    ``time`` and ``sequence`` are those of its Frame.
    """

    place: ChunkLocation
    channel: int
    message: int
    unpack: Unpack
    time: float
    sequence: int


class FileSamples(Mapping[SampleKey, Recorded]):
    """Samples by their key; a picture that cannot be read is a RecordingError."""

    def __init__(
        self, path: Path, numbers: Mapping[SampleKey, Recorded], pictures: Mapping[SampleKey, Picture]
    ) -> None:
        self._path, self._numbers, self._pictures = path, numbers, pictures
        self._messages = lru_cache(CHUNKS_KEPT)(self._read)

    def __getitem__(self, key: SampleKey) -> Recorded:
        if key in self._numbers:
            return self._numbers[key]
        picture = self._pictures[key]
        try:
            messages = self._messages(picture.place)
            image = picture.unpack(messages[picture.channel, picture.message])
        except RecordingError:
            raise
        except DAMAGE as error:
            problem = f"picture {key.number} of {key.device} is damaged ({damage_at(picture.place.offset, error)})"
            raise RecordingError(self._path, problem, "Record the run again") from error
        return Frame(image, picture.time, picture.sequence)

    def __contains__(self, key: object) -> bool:
        """Whether there is such a sample; no picture is read for it."""
        return key in self._numbers or key in self._pictures

    def __iter__(self) -> Iterator[SampleKey]:
        yield from self._numbers
        yield from self._pictures

    def __len__(self) -> int:
        return len(self._numbers) + len(self._pictures)

    def _read(self, place: ChunkLocation) -> dict[tuple[int, int], memoryview]:
        records = ChunkedFile(self._path).again(place)
        return {(each.channel_id, each.sequence): each.data for each in records if isinstance(each, Message)}
