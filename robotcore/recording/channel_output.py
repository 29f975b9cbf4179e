"""The output to which a run's channels are written: a file, or the clients of a server."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any


class ChannelOutput:
    """Opens channels in a context of foxglove-sdk, which passes their messages on.

    This class discards attachments and metadata records, because only a file has them.
    """

    def __init__(self) -> None:
        import foxglove

        self.context = foxglove.Context()

    def open_json_channel(
        self, topic: str, schema: Mapping[str, Any], metadata: Mapping[str, str] | None = None
    ) -> Callable[[bytes, int], None]:
        """Open a channel of JSON messages, and return a function that writes a message with its time in ns."""
        from foxglove import Channel

        entries = dict(metadata or {})
        channel = Channel(topic, schema=dict(schema), message_encoding="json", context=self.context, metadata=entries)
        return lambda content, at: channel.log(content, log_time=at)

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        """Write an attachment: a file inside an MCAP file."""

    def write_metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Write a metadata record: a named map of texts."""

    def flush(self) -> None:
        """Write all messages."""
