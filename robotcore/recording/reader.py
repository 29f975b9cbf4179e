"""Read a recording: a whole file, or the part before a cut or damage."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, Schema

from robotcore.errors import RecordingError
from robotcore.hal.devices import Angle, Frame, Image, Range, Voltage
from robotcore.recording import foxglove as channels
from robotcore.recording.chunks import DAMAGE, Allowance, ChunkedFile, ChunkLocation, Message, Record, format_damage
from robotcore.recording.codec import decode_compressed_image, decode_raw_image, from_json
from robotcore.recording.events import GroundTruthSample, RecordedSample, SampleKey, Tick
from robotcore.recording.foxglove import DEVICE
from robotcore.recording.recording import Metadata, Recording
from robotcore.recording.validation import UnknownFormatError, parse_metadata, parse_number, parse_result, parse_tick
from robotcore.runtime.result import RunResult

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


class FileSamples(Mapping[SampleKey, RecordedSample]):
    """Samples by their key; a picture that cannot be read is a RecordingError."""

    def __init__(
        self, path: Path, numbers: Mapping[SampleKey, RecordedSample], pictures: Mapping[SampleKey, Picture]
    ) -> None:
        self._path, self._numbers, self._pictures = path, numbers, pictures
        self._messages = lru_cache(CHUNKS_KEPT)(self._read)

    def __getitem__(self, key: SampleKey) -> RecordedSample:
        if key in self._numbers:
            return self._numbers[key]
        picture = self._pictures[key]
        try:
            messages = self._messages(picture.place)
            image = picture.unpack(messages[picture.channel, picture.message])
        except RecordingError:
            raise
        except DAMAGE as error:
            problem = f"picture {key.number} of {key.device} is damaged ({format_damage(picture.place.offset, error)})"
            raise RecordingError(self._path, problem, "Record the run again", kind="recording-damaged") from error
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
        records = ChunkedFile(self._path).read_again(place)
        return {(each.channel_id, each.sequence): each.data for each in records if isinstance(each, Message)}


_NUMBERS: dict[str, type[Range | Angle | Voltage]] = {
    "robotcore.Range": Range,
    "robotcore.Angle": Angle,
    "robotcore.Voltage": Voltage,
}
_PICTURES: dict[str, Unpack] = {
    "foxglove.RawImage": decode_raw_image,
    "foxglove.CompressedImage": decode_compressed_image,
}


_TOPICS = {channels.RUN, channels.TICKS, channels.TRUTH, channels.RESULT, channels.END}


def read_file(path: Path) -> Recording:
    """Return what is in a recording. Raises RecordingError where it is none, or holds nothing of a run."""
    file, builder, at = ChunkedFile(path), _RecordingBuilder(path), 0
    try:
        for place, records in file.chunks():
            at = place.offset
            builder.add_chunk(place, records, file.allowance)
    except RecordingError:
        raise
    except UnknownFormatError as error:
        raise RecordingError(path, str(error), "Update robotcore", kind="recording-format") from error
    except DAMAGE as error:
        return builder.build(is_whole=False, damage=format_damage(at, error))
    return builder.build(is_whole=file.is_whole, damage=file.damage)


class _PictureLocation(NamedTuple):
    """A picture's message, and what makes it a picture again."""

    place: ChunkLocation
    channel: int
    message: int
    unpack: Unpack


class _End(NamedTuple):
    """Why a recording ends before its run did."""

    reason: str


class _Channel(NamedTuple):
    """What is kept of a channel."""

    topic: str
    device: str | None
    schema: str


class _RecordingBuilder:
    """Collects the content of a file, and builds the recording."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, _Channel] = {}
        self._numbers: dict[SampleKey, RecordedSample] = {}
        self._pictures: dict[SampleKey, _PictureLocation] = {}
        self._ticks: list[Tick] = []
        self._truth: list[GroundTruthSample] = []
        self._metadata: Metadata | None = None
        self._result: RunResult | None = None
        self._ended_early = ""

    def add_chunk(self, place: ChunkLocation, records: Iterable[Record], allowance: Allowance) -> None:
        """Take in what is in a chunk; one of `DAMAGE` where that does not fit what was before."""
        for record in records:
            if isinstance(record, Message):
                self._add_message(place, self._channels[record.channel_id], record, allowance)
            elif isinstance(record, Schema):
                self._schemas[record.id] = record.name
            elif isinstance(record, Channel):
                schema = self._schemas.get(record.schema_id, "")
                self._channels[record.id] = _Channel(record.topic, record.metadata.get(DEVICE), schema)

    def _add_message(self, place: ChunkLocation, channel: _Channel, message: Message, allowance: Allowance) -> None:
        """The library counts the messages of a channel from one."""
        if channel.device is not None and channel.schema in _PICTURES:
            key = SampleKey(channel.device, message.sequence - 1)
            self._pictures[key] = _PictureLocation(
                place, message.channel_id, message.sequence, _PICTURES[channel.schema]
            )
        elif channel.device is not None or channel.topic in _TOPICS:
            allowance.take_text(len(message.data))
            content = bytes(message.data)
            allowance.take_values(content)
            self._add_json(channel, message.sequence, content)

    def _add_json(self, channel: _Channel, sequence: int, content: bytes) -> None:
        if channel.device is not None:
            self._numbers[SampleKey(channel.device, sequence - 1)] = parse_number(_NUMBERS[channel.schema], content)
        elif channel.topic == channels.RUN:
            self._metadata = parse_metadata(content)
        elif channel.topic == channels.TICKS:
            self._ticks.append(parse_tick(content, self._ticks[-1] if self._ticks else None))
        elif channel.topic == channels.TRUTH:
            self._truth.append(from_json(GroundTruthSample, content))
        elif channel.topic == channels.RESULT:
            self._result = parse_result(content)
        else:
            self._ended_early = from_json(_End, content).reason

    def build(self, *, is_whole: bool, damage: str) -> Recording:
        """Return all of it. Raises RecordingError where nothing tells of a run."""
        if self._metadata is None:
            raise _build_no_run_error(self._path, damage, is_whole=is_whole)
        samples = FileSamples(self._path, self._numbers, dict(self._list_pictures()))
        return Recording(
            metadata=self._metadata,
            ticks=self._ticks,
            samples=samples,
            result=self._result,
            truth=self._truth,
            ended_early=self._ended_early,
            is_cut=not (is_whole and (self._result or self._ended_early)),
            damage=damage,
            why_not=explain_gaps(self._ticks, samples, self._jpegs()),
        )

    def _list_pictures(self) -> Iterator[tuple[SampleKey, Picture]]:
        """Yield the pictures that a tick was given or showed, as frames of that time."""
        for tick in self._ticks:
            captured = [(read.key, read.time or 0.0, read.sequence or 0) for read in tick.reads if read.key]
            captured += [(each.key, tick.time, each.key.number) for each in tick.shown if each.key]
            for key, time, sequence in captured:
                if where := self._pictures.get(key):
                    yield key, Picture(*where, time, sequence)

    def _jpegs(self) -> set[str]:
        return {key.device for key, where in self._pictures.items() if where.unpack is decode_compressed_image}


def _build_no_run_error(path: Path, damage: str, *, is_whole: bool) -> RecordingError:
    if is_whole:
        return RecordingError(
            path, "it holds no run", "Name a file that robotcore has recorded", kind="recording-without-run"
        )
    what, where = ("damaged", f" ({damage})") if damage else ("cut", "")
    problem = f"it is {what} before it says what was run, so nothing in it can be read{where}"
    kind = "recording-damaged" if damage else "recording-cut"
    return RecordingError(path, problem, "Take another copy of it, or record the run again", kind=kind)


def explain_gaps(ticks: list[Tick], samples: FileSamples, jpegs: set[str]) -> str:
    """Say what is missing of that which steered a run, empty where nothing is; ``jpegs`` name devices."""
    reads = [read for tick in ticks for read in tick.reads if not read.error]
    if not ticks:
        return "it holds no tick"
    if dropped := {(read.device, read.sequence) for read in reads if read.number is None}:
        return f"{len(dropped)} picture(s) were dropped: the disk was too slow"
    if lossy := sorted(jpegs & {read.device for read in reads}):
        return f"{', '.join(lossy)}: JPEG is not what the app saw"
    if missing := {read.key for read in reads if read.key not in samples}:
        return f"{len(missing)} sample(s) are missing"
    return ""
