"""Send the channels of a run to Foxglove while it runs."""

from __future__ import annotations

from importlib.resources import files
from threading import Event, Thread
from typing import TYPE_CHECKING

from robotcore.errors import UsageError
from robotcore.extras import require_extra
from robotcore.recording.channel_output import ChannelOutput
from robotcore.recording.foxglove_channels import to_nanoseconds
from robotcore.recording.recorder import WriteQueue
from robotcore.recording.recording import Metadata, build_metadata
from robotcore.recording.tick_collector import TickCollector
from robotcore.recording.writer import Entry, RecordingWriter
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.threads import start_thread

if TYPE_CHECKING:
    from foxglove.websocket import ChannelView, Client

HOST, PORT = "127.0.0.1", 8765
"""The address that Foxglove proposes. The protocol has no password, so only programs on this machine can connect."""

QUEUE_BYTES = 8 * 2**20
"""The size of the queue to the thread that sends. If it is full, pictures and ticks are dropped."""

BACKLOG = 128
"""The number of messages that wait for a client who does not read. Older ones are dropped."""

CLOSING_S = 2.0
"""The longest wait until the last messages are sent, in seconds."""


class FoxgloveServer:
    """An observer that shows its run in Foxglove: ``session.run(request, [server], [server.layer])``.

    A thread sends the channels of a recording, with pictures as JPEGs. So `tick` never waits. A client receives
    messages and cannot send commands.

    port: the port of 127.0.0.1 at which the server listens. With 0, the system chooses a free one.

    Raises UsageError if the system refuses the port, and BackendMissingError if a library of the extra ``record`` is
    missing.

    >>> server = FoxgloveServer(0)
    >>> server.link.startswith("ws://127.0.0.1:")
    True
    >>> server.close()
    """

    def __init__(self, port: int = PORT) -> None:
        require_extra("record", "--foxglove")
        from foxglove import start_server
        from foxglove.websocket import Capability, ServerListener

        class Listener(ServerListener):
            """Notes a new subscription to a channel, so that the messages that are sent once are sent again."""

            def on_subscribe(_self, client: Client, channel: ChannelView) -> None:  # noqa: N805
                self._has_new_client.set()

        self._output, self._has_new_client = ChannelOutput(), Event()
        self._queue: WriteQueue[Entry] = WriteQueue(QUEUE_BYTES)
        self._collector = TickCollector(self._queue.has_room)
        self.layer = self._collector.layer
        """The layer of the run that records the calls of the app."""
        self.failure = ""
        """The error because of which the server sends nothing more. Empty if there is none."""
        self._thread: Thread | None = None
        self._result: RunResult | None = None
        try:
            self._server = start_server(
                name="robotcore",
                host=HOST,
                port=port,
                capabilities=[Capability.Time],
                server_listener=Listener(),
                context=self._output.context,
                message_backlog_size=BACKLOG,
            )
        except RuntimeError as error:
            raise UsageError(
                f"--foxglove {port}: the server cannot listen at {HOST}:{port}: {error}. Choose another port, or 0 for "
                "a free one",
                kind="cannot-listen",
                host=HOST,
                port=port,
            ) from error
        self.link = f"ws://{HOST}:{self._server.port}"
        """The address for Foxglove's dialog *Open connection*."""

    def describe_link(self) -> str:
        """Return the address and the file of the layout as text."""
        layout = files("robotcore.recording") / "foxglove-layout.json"
        return f"The run in Foxglove: {self.link}\nThe layout for Foxglove: {layout}"

    def begin(self, run: RunContext) -> None:
        self._collector.begin(run)
        metadata = build_metadata(run)
        self._thread = start_thread(lambda: self._send_all(run, metadata), "foxglove")

    def tick(self, record: TickRecord) -> None:
        entry = self._collector.collect(record)
        if self._queue.has_room():
            self._queue.put(entry, entry.size, is_blocking=False)

    def end(self, result: RunResult) -> None:
        self._result = result
        self.close()

    def close(self) -> None:
        """Send the last messages, and end the server. Later calls do nothing."""
        self._queue.end()
        if self._thread:
            self._thread.join(CLOSING_S)
        self._server.stop()

    def _send_all(self, run: RunContext, metadata: Metadata) -> None:
        try:
            writer = RecordingWriter(self._output, run, metadata, is_jpeg=True, notes=[])
            self._send_ticks(writer)
            if self._result:
                writer.end(self._result)
        except Exception as error:  # noqa: BLE001  any error, such as one of a driver, must end only the server
            self.failure = f"{type(error).__name__}: {error}"
            self._queue.end()

    def _send_ticks(self, writer: RecordingWriter) -> None:
        time = 0.0
        while not self._queue.is_over:
            if self._has_new_client.is_set():
                self._has_new_client.clear()
                writer.describe_run(time)
            if entry := self._queue.get():
                time = entry.record.time
                writer.write(entry)
                self._server.broadcast_time(to_nanoseconds(time))
