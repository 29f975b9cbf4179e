"""Read a recording from its file, or the intact part of a file that is cut or damaged."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, Schema

from robotcore.compatibility import PACKAGE, is_newer
from robotcore.errors import RecordingError
from robotcore.hal.device import Sample
from robotcore.hal.kind import Kind, load_kind
from robotcore.hal.value_log import MAX_NAMES, LoggedValue
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from robotcore.recording import foxglove_channels as channels
from robotcore.recording.chunks import ChunkedFile, ChunkLocation, Message, Record
from robotcore.recording.codec import decode_compressed_image, decode_log_line, decode_raw_image, from_json
from robotcore.recording.events import GroundTruthSample, SampleKey, Tick
from robotcore.recording.foxglove_channels import DEVICE
from robotcore.recording.limits import DAMAGE, Allowance, format_damage
from robotcore.recording.logged_values import LOGGED, parse_logged
from robotcore.recording.recording import Metadata, Recording
from robotcore.recording.validation import (
    MissingKindError,
    UnknownFormatError,
    parse_metadata,
    parse_result,
    parse_sample,
    parse_tick,
)
from robotcore.runtime.result import RunResult
from robotcore.text import escape

CACHED_CHUNKS = 2
"""The number of unpacked chunks in memory. Two are enough to read all pictures in order."""

Unpack = Callable[[memoryview], Image]
"""A function that decodes the message of a picture."""


MAX_VERSION_TEXT = 40
"""The greatest number of characters of a version of robotcore in a message."""


class Picture(NamedTuple):
    """A picture in a file."""

    chunk: ChunkLocation
    channel: int
    message: int
    """The sequence number of its message in the channel. The first message has 1."""
    unpack: Unpack
    time: float = 0.0
    """The capture time in seconds on the robot's clock."""
    sequence: int = 0
    """The sequence number of the frame."""


class FileSamples(Mapping[SampleKey, Sample]):
    """The samples of a file by key. Getting a damaged picture raises RecordingError."""

    def __init__(self, path: Path, samples: Mapping[SampleKey, Sample | Picture]) -> None:
        self._path, self._samples = path, samples
        self._messages = lru_cache(CACHED_CHUNKS)(self._read)

    def __getitem__(self, key: SampleKey) -> Sample:
        sample = self._samples[key]
        if not isinstance(sample, Picture):
            return sample
        try:
            image = sample.unpack(self._messages(sample.chunk)[sample.channel, sample.message])
        except RecordingError:
            raise
        except DAMAGE as error:
            place = format_damage(sample.chunk.offset, error)
            problem = f"picture {key.number} of {key.device} is damaged ({place})"
            raise RecordingError(self._path, problem, "Record the run again", kind="recording-damaged") from error
        return Frame(image, sample.time, sample.sequence)

    def __contains__(self, key: object) -> bool:
        """Return whether the file has a sample. The file is not read."""
        return key in self._samples

    def __iter__(self) -> Iterator[SampleKey]:
        return iter(self._samples)

    def __len__(self) -> int:
        return len(self._samples)

    def _read(self, chunk: ChunkLocation) -> dict[tuple[int, int], memoryview]:
        records = ChunkedFile(self._path).read_again(chunk)
        return {(each.channel_id, each.sequence): each.data for each in records if isinstance(each, Message)}


_PICTURES: dict[str, Unpack] = {
    "foxglove.RawImage": decode_raw_image,
    "foxglove.CompressedImage": decode_compressed_image,
}


_TOPICS = {channels.RUN, channels.TICKS, channels.TRUTH, channels.RESULT, channels.END}


def read_file(path: Path) -> Recording:
    """Return the recording in a file. Raises RecordingError if the file has no metadata of a run."""
    file, builder, at = ChunkedFile(path), _RecordingBuilder(path), 0
    try:
        for chunk, records in file.chunks():
            at = chunk.offset
            builder.add_chunk(chunk, records, file.allowance)
    except RecordingError:
        raise
    except UnknownFormatError as error:
        raise RecordingError(path, str(error), "Update robotcore", kind="recording-format") from error
    except MissingKindError as error:
        remedy = "Install the package of this kind"
        raise RecordingError(path, str(error), remedy, kind="recording-kind", name=error.name) from error
    except DAMAGE as error:
        return builder.build(is_whole=False, damage=format_damage(at, error) + builder.describe_newer_version())
    return builder.build(is_whole=file.is_whole, damage=file.damage)


class _End(NamedTuple):
    reason: str


class _Channel(NamedTuple):
    topic: str
    device: str | None
    """The device whose samples the channel has; None if it has no samples."""
    schema: str
    logged: str | None = None
    """The name of the logged value that the channel has; None if it has none."""


class _RecordingBuilder:
    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, _Channel] = {}
        self._numbers: dict[SampleKey, Sample] = {}
        self._pictures: dict[SampleKey, Picture] = {}
        self._ticks: list[Tick] = []
        self._truth: list[GroundTruthSample] = []
        self._logged: dict[int, dict[str, LoggedValue]] = {}
        self._logged_names: set[str] = set()
        self._printed: dict[int, list[str]] = {}
        self._metadata: Metadata | None = None
        self._kinds: dict[str, Kind] = {}
        self._result: RunResult | None = None
        self._ended_early = ""

    def add_chunk(self, chunk: ChunkLocation, records: Iterable[Record], allowance: Allowance) -> None:
        """Add the records of a chunk. Malformed or contradictory records raise one of the errors in `DAMAGE`."""
        for record in records:
            if isinstance(record, Message):
                self._add_message(chunk, self._channels[record.channel_id], record, allowance)
            elif isinstance(record, Schema):
                self._schemas[record.id] = record.name
            elif isinstance(record, Channel):
                schema = self._schemas.get(record.schema_id, "")
                names = record.metadata.get(DEVICE), schema, record.metadata.get(LOGGED)
                self._channels[record.id] = _Channel(record.topic, *names)

    def _add_message(self, chunk: ChunkLocation, channel: _Channel, message: Message, allowance: Allowance) -> None:
        if channel.device is not None and channel.schema in _PICTURES:
            key = SampleKey(channel.device, message.sequence - 1)  # the first message has the sequence 1
            self._pictures[key] = Picture(chunk, message.channel_id, message.sequence, _PICTURES[channel.schema])
        elif channel.device is not None or channel.logged is not None or channel.topic in _TOPICS:
            allowance.take_text(len(message.data))
            content = bytes(message.data)
            allowance.take_values(content)
            self._add_json(channel, message.sequence, content)
        elif channel.topic == channels.LOG:
            allowance.take_text(len(message.data))
            self._add_line(message.data)

    def _add_line(self, content: memoryview) -> None:
        source, text = decode_log_line(content)
        if source == channels.APP and self._ticks:  # a ring may have deleted the tick of its first lines
            self._printed.setdefault(self._ticks[-1].number, []).append(text)

    def _add_json(self, channel: _Channel, sequence: int, content: bytes) -> None:
        if channel.device is not None:
            self._numbers[SampleKey(channel.device, sequence - 1)] = parse_sample(self._kinds[channel.device], content)
        elif channel.logged is not None:
            self._add_logged(channel.logged, channel.schema, content)
        elif channel.topic == channels.RUN:
            self._metadata = parse_metadata(content)
            self._kinds = {each.name: load_kind(each.kind) for each in self._metadata.description.devices}
        elif channel.topic == channels.TICKS:
            self._ticks.append(parse_tick(content, self._ticks[-1] if self._ticks else None))
        elif channel.topic == channels.TRUTH:
            self._truth.append(from_json(GroundTruthSample, content))
        elif channel.topic == channels.RESULT:
            self._result = parse_result(content)
        else:
            self._ended_early = from_json(_End, content).reason

    def _add_logged(self, name: str, schema: str, content: bytes) -> None:
        message = parse_logged(name, schema, content)
        self._logged_names.add(name)
        if len(self._logged_names) > MAX_NAMES:
            raise ValueError(f"the run has logged more than {MAX_NAMES} names")
        self._logged.setdefault(message.tick, {})[name] = LoggedValue(message.value, message.unit)

    def describe_newer_version(self) -> str:
        """Return a clause that names the robotcore that wrote the file if it is newer than this one, else ``""``."""
        written = self._metadata.platform.get(PACKAGE, "")[:MAX_VERSION_TEXT] if self._metadata else ""
        return f"; the newer robotcore {escape(written)} wrote the file" if is_newer(written) else ""

    def build(self, *, is_whole: bool, damage: str) -> Recording:
        """Return the recording. Raises RecordingError if the file has no metadata of a run."""
        if self._metadata is None:
            raise _build_no_run_error(self._path, damage, is_whole=is_whole)
        samples = FileSamples(self._path, {**self._numbers, **dict(self._list_pictures())})
        jpegs = {key.device for key, place in self._pictures.items() if place.unpack is decode_compressed_image}
        ticks = skip_incomplete_beginning(self._ticks, samples)
        first = ticks[0].number if ticks else 0
        return Recording(
            metadata=self._metadata,
            ticks=ticks,
            samples=samples,
            result=self._result,
            truth=[each for each in self._truth if each.tick >= first],
            logged=self._logged,
            printed=self._printed,
            ended_early=self._ended_early,
            is_cut=not (is_whole and (self._result or self._ended_early)),
            damage=damage,
            missing_inputs=explain_missing_inputs(ticks, samples, jpegs),
        )

    def _list_pictures(self) -> Iterator[tuple[SampleKey, Picture]]:
        for tick in self._ticks:
            captured = [(read.key, read.time or 0.0, read.sequence or 0) for read in tick.reads if read.key]
            captured += [(each.key, tick.time, each.key.number) for each in tick.shown if each.key]
            for key, time, sequence in captured:
                if picture := self._pictures.get(key):
                    yield key, picture._replace(time=time, sequence=sequence)


def _build_no_run_error(path: Path, damage: str, *, is_whole: bool) -> RecordingError:
    if is_whole:
        remedy = "Name a file that robotcore has recorded"
        return RecordingError(path, "the file has no recorded run", remedy, kind="recording-without-run")
    problem = f"is damaged ({damage})" if damage else "ends"
    problem = f"the file {problem} before the metadata of its run, so it cannot be read"
    kind = "recording-damaged" if damage else "recording-cut"
    return RecordingError(path, problem, "Use another copy of the file, or record the run again", kind=kind)


def skip_incomplete_beginning(ticks: list[Tick], samples: Container[SampleKey]) -> list[Tick]:
    """Return the ticks of a ring recording from the first one with all its samples; all ticks if there is none.

    A ring may have deleted the samples that its first ticks read.
    """
    if not ticks or not ticks[0].number:
        return ticks
    complete = (at for at, tick in enumerate(ticks) if all(each.key in samples for each in tick.reads if each.key))
    return ticks[next(complete, 0) :]


def explain_missing_inputs(ticks: list[Tick], samples: FileSamples, jpegs: set[str]) -> str:
    """Return a text about the missing inputs of the app; empty if no input is missing.

    jpegs: the cameras whose pictures are JPEGs, which differ from the pictures that the app read.
    """
    reads = [read for tick in ticks for read in tick.reads if not read.error]
    if not ticks:
        return "the recording has no tick"
    if ticks[0].number:
        return f"the recording begins at {ticks[0].time:.1f} s, and the state of the app at that time is unknown"
    if dropped := {(read.device, read.sequence) for read in reads if read.number is None}:
        return f"{len(dropped)} picture(s) are missing, because the disk was too slow"
    if lossy := sorted(jpegs & {read.device for read in reads}):
        return f"the pictures of {', '.join(lossy)} are JPEGs, which differ from those that the app read"
    if missing := {read.key for read in reads if read.key not in samples}:
        return f"{len(missing)} sample(s) are missing"
    return ""
