"""Write the end of an MCAP file: the index with which programs such as Foxglove find its chunks.

The format is https://mcap.dev/spec#summary-section.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO, FileIO

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from robotcore.files import write_all
from robotcore.recording.chunks import (
    CHUNK_HEADER_BYTES,
    MAGIC,
    RECORD,
    ChunkLocation,
    locate_chunk,
    read_records,
    unpack,
)
from robotcore.recording.limits import DAMAGE, MAX_RECORD_BYTES

INDEX_BYTES = 90
"""The size of the index entry of a chunk, in bytes, without its channels."""
CHANNEL_INDEX_BYTES = 10
"""The size of a channel in the index entry of a chunk, in bytes."""

_INDEX_HEADER_BYTES = 6
_INDEX_ENTRY_BYTES = 16


def write_index(file: FileIO, end: int) -> None:
    """Write the end of an MCAP file, with the index of its chunks, attachments and metadata.

    If a record is damaged, the index ends before it.

    end: the offset of the end of the last record.
    """
    index = _Index(file)
    with suppress(*DAMAGE):  # a reader reports the damage
        for opcode, at, length in _list_records(file, end):
            index.add(opcode, at, length)
    file.seek(end)
    write_all(file, index.build(end))


def _list_records(file: FileIO, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield the opcode, the offset and the whole length of each record before an offset."""
    at = len(MAGIC)
    while at < end:
        file.seek(at)
        opcode, length = RECORD.unpack(file.read(RECORD.size))
        yield opcode, at, RECORD.size + length
        at += RECORD.size + length


class _Index:
    """The schemas, the channels and the places of the records of a file."""

    def __init__(self, file: FileIO) -> None:
        self._file = file
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._chunks: list[ChunkIndex] = []
        self._last: ChunkLocation | None = None
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: Counter[int] = Counter()

    def add(self, opcode: int, at: int, length: int) -> None:
        """Add a record at an offset, with its whole length. The position of the file is behind the record's head."""
        if opcode == Opcode.CHUNK:
            self._add_chunk(at, length)
        elif opcode == Opcode.MESSAGE_INDEX and self._chunks:
            self._add_message_index(at, length)
        elif opcode in (Opcode.ATTACHMENT, Opcode.METADATA) and length <= MAX_RECORD_BYTES:
            stream = ReadDataStream(BytesIO(self._file.read(length - RECORD.size)))
            if opcode == Opcode.METADATA:
                self._metadata.append(MetadataIndex(at, length, Metadata.read(stream).name))
            else:
                attachment = Attachment.read(stream)
                times = attachment.log_time, attachment.create_time
                self._attachments.append(
                    AttachmentIndex(at, length, *times, len(attachment.data), attachment.name, attachment.media_type)
                )

    def _add_chunk(self, at: int, length: int) -> None:
        header = locate_chunk(self._file.read(min(length - RECORD.size, CHUNK_HEADER_BYTES)), at + RECORD.size)
        self._last = location = header.location
        if not location.compression:
            self._add_definitions(location)
        self._chunks.append(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=at,
                compression=location.compression,
                compressed_size=location.length,
                message_end_time=header.end_ns,
                message_index_length=0,
                message_index_offsets={},
                message_start_time=header.begin_ns,
                uncompressed_size=location.size,
            )
        )

    def _add_message_index(self, at: int, length: int) -> None:
        channel = int.from_bytes(self._file.read(2), "little")
        if channel not in self._channels and self._last:
            self._add_definitions(self._last)
        chunk = self._chunks[-1]
        chunk.message_index_offsets[channel] = at
        chunk.message_index_length += length
        self._counts[channel] += (length - RECORD.size - _INDEX_HEADER_BYTES) // _INDEX_ENTRY_BYTES

    def _add_definitions(self, location: ChunkLocation) -> None:
        """Add the schemas and the channels that a chunk defines."""
        self._file.seek(location.offset)
        for record in read_records(unpack(location, self._file.read(min(location.length, MAX_RECORD_BYTES)))):
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._channels[record.id] = record

    def build(self, end: int) -> bytes:
        """Return the end of the file: the end of the data, the summary, and the footer.

        end: the offset at which it is written.
        """
        builder = RecordBuilder()
        DataEnd(0).write(builder)
        summary_start = end + builder.count
        chunks = [each for each in self._chunks if each.message_index_offsets]
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=max((each.message_end_time for each in chunks), default=0),
            message_start_time=min((each.message_start_time for each in chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        defined = (*self._schemas.values(), *self._channels.values())
        for record in (*defined, statistics, *self._chunks, *self._attachments, *self._metadata):
            record.write(builder)
        Footer(summary_start, 0, 0).write(builder)
        return take_bytes(builder) + MAGIC


def take_bytes(builder: RecordBuilder) -> bytes:
    """Return the bytes of a builder, and empty it."""
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # the method has no annotation
    return data
