"""Reads a recording back: all of a whole file, and of one that was cut or damaged what came before."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, McapRecord, Message, Schema

from robotcore.devices import Angle, Image, Range, Voltage
from robotcore.errors import RecordingError
from robotcore.recording import channels
from robotcore.recording.channels import DEVICE
from robotcore.recording.chunks import DAMAGE, ChunkedFile, Place
from robotcore.recording.events import Glimpse, Recorded, SampleKey, Tick
from robotcore.recording.protobuf import compressed_image, raw_image
from robotcore.recording.recording import FORMAT, Metadata, Recording
from robotcore.recording.samples import FileSamples, Picture
from robotcore.recording.wire import from_json
from robotcore.running.outcome import Outcome, RunResult

_NUMBERS: dict[str, type[Range | Angle | Voltage]] = {
    "robotcore.Range": Range,
    "robotcore.Angle": Angle,
    "robotcore.Voltage": Voltage,
}
_PICTURES: dict[str, Callable[[bytes], Image]] = {
    "foxglove.RawImage": raw_image,
    "foxglove.CompressedImage": compressed_image,
}


def read_file(path: Path) -> Recording:
    """Return what is in a recording. Raises RecordingError where it is none, or holds nothing of a run."""
    file, found = ChunkedFile(path), _Found(path)
    try:
        for place, records in file.chunks():
            found.take(place, records)
    except RecordingError:
        raise
    except DAMAGE:
        return found.recording(is_whole=False, is_damaged=True)
    return found.recording(is_whole=file.is_whole, is_damaged=file.is_damaged)


class _Where(NamedTuple):
    """A picture's message, and what makes it a picture again."""

    place: Place
    channel: int
    message: int
    unpack: Callable[[bytes], Image]


class _Found:
    """What was found in a file by now."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, Channel] = {}
        self._numbers: dict[SampleKey, Recorded] = {}
        self._pictures: dict[SampleKey, _Where] = {}
        self._ticks: list[Tick] = []
        self._truth: list[Glimpse] = []
        self._metadata: Metadata | None = None
        self._result: RunResult | None = None
        self._ended_early = ""

    def take(self, place: Place, records: list[McapRecord]) -> None:
        """Take in what is in a chunk; one of `DAMAGE` where that does not fit what was before."""
        for record in records:
            if isinstance(record, Schema):
                self._schemas[record.id] = record.name
            elif isinstance(record, Channel):
                self._channels[record.id] = record
            elif isinstance(record, Message):
                self._take_message(place, self._channels[record.channel_id], record)

    def _take_message(self, place: Place, channel: Channel, message: Message) -> None:
        if DEVICE in channel.metadata:
            self._take_sample(place, channel, message)
        elif channel.topic == channels.RUN:
            self._metadata = _metadata(self._path, message.data)
        elif channel.topic == channels.TICKS:
            self._take_tick(from_json(Tick, message.data))
        elif channel.topic == channels.TRUTH:
            self._truth.append(from_json(Glimpse, message.data))
        elif channel.topic == channels.RESULT:
            self._result = _result(message.data)
        elif channel.topic == channels.END:
            self._ended_early = json.loads(message.data)["reason"]

    def _take_sample(self, place: Place, channel: Channel, message: Message) -> None:
        """The library counts the messages of a channel from one."""
        key, schema = SampleKey(channel.metadata[DEVICE], message.sequence - 1), self._schemas[channel.schema_id]
        if schema in _NUMBERS:
            self._numbers[key] = from_json(_NUMBERS[schema], message.data)
        else:
            self._pictures[key] = _Where(place, message.channel_id, message.sequence, _PICTURES[schema])

    def _take_tick(self, tick: Tick) -> None:
        if self._ticks and tick.number != self._ticks[-1].number + 1:
            raise ValueError(f"tick {tick.number} comes after tick {self._ticks[-1].number}")
        self._ticks.append(tick)

    def recording(self, *, is_whole: bool, is_damaged: bool) -> Recording:
        """Return all of it. Raises RecordingError where nothing tells of a run."""
        if self._metadata is None:
            raise _without_a_run(self._path, is_whole=is_whole, is_damaged=is_damaged)
        samples = FileSamples(self._path, self._numbers, dict(self._captured()))
        return Recording(
            metadata=self._metadata,
            ticks=self._ticks,
            samples=samples,
            result=self._result,
            truth=self._truth,
            ended_early=self._ended_early,
            is_cut=not (is_whole and (self._result or self._ended_early)),
            is_damaged=is_damaged,
            why_not=why_not(self._ticks, samples, self._jpegs()),
        )

    def _captured(self) -> Iterator[tuple[SampleKey, Picture]]:
        """Yield the pictures that a tick was given or showed, as frames of that time."""
        for tick in self._ticks:
            told = [(read.key, read.time or 0.0, read.sequence or 0) for read in tick.reads if read.key]
            told += [(each.key, tick.time, each.key.number) for each in tick.shown if each.key]
            for key, time, sequence in told:
                if where := self._pictures.get(key):
                    yield key, Picture(*where, time, sequence)

    def _jpegs(self) -> set[str]:
        return {key.device for key, where in self._pictures.items() if where.unpack is compressed_image}


def _without_a_run(path: Path, *, is_whole: bool, is_damaged: bool) -> RecordingError:
    if is_whole:
        return RecordingError(path, "it holds no run", "Name a file that robotcore has recorded")
    what = "damaged" if is_damaged else "cut"
    fault = f"it is {what} before it says what was run, so nothing in it can be read"
    return RecordingError(path, fault, "Take another copy of it, or record the run again")


def why_not(ticks: list[Tick], samples: FileSamples, jpegs: set[str]) -> str:
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


def _metadata(path: Path, content: bytes) -> Metadata:
    written = json.loads(content).get("format", FORMAT)
    if written != FORMAT:
        raise RecordingError(path, f"it is of format {written}, known is {FORMAT}", "Update robotcore")
    return from_json(Metadata, content)


def _result(content: bytes) -> RunResult:
    told: dict[str, Any] = json.loads(content)
    known = {field.name: told[field.name] for field in fields(RunResult) if field.name in told}
    return RunResult(**{**known, "outcome": Outcome(known["outcome"])})
