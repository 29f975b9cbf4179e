"""The observer that shows a run on its live page."""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from threading import Condition, Thread
from typing import Any

from robotcore.errors import RobotcoreError
from robotcore.extras import require_extra
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.live.actions import execute_action
from robotcore.live.address import Address, build_token
from robotcore.live.messages import Message
from robotcore.live.page_process import PageProcess, build_picture_message
from robotcore.live.run_description import MAP_PX, describe_run, draw_world, find_grid
from robotcore.live.snapshot import Snapshot, SnapshotBuilder
from robotcore.optics import Image
from robotcore.runtime.observer import RunContext
from robotcore.runtime.operator_input import LEASE_S
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.safety.velocity_limits import AccelerationLimit
from robotcore.threads import start_thread

PERIOD_S = 0.04
"""The shortest time between two messages, in seconds."""

MAP_PERIOD_S = 1.0
"""The shortest time between two pictures of the app's map, in seconds."""

SUMMARY_PERIOD_S = 1.0
"""The time between two summaries of the ticks' durations, in seconds."""

MAX_LINES = 500
"""The number of lines that wait for the page. Older ones are lost."""

LOST_PAGE = (
    "the live page has ended; its e-stop is gone: Ctrl-C ends the run. A robot that a viewer drove stands until then"
)

CLOSING_S = 1.0
"""The longest wait until the page has the end of the run, in seconds."""


class LiveView:
    """An observer that shows its run on a web page, from which each viewer can press the e-stop and one can drive.

    The page's own process serves the viewers, and a thread sends the newest state to it. So `tick` never waits. If the
    process ends, the run says so and continues, but a robot that a viewer drives stands.

    The constructor listens at the address. Raises UsageError if the system refuses that, and BackendMissingError if a
    library of the extra ``view`` is missing.

    >>> view = LiveView(Address())
    >>> view.link.startswith("http://127.0.0.1:")
    True
    >>> view.close()
    """

    def __init__(self, address: Address) -> None:
        require_extra("view", "the live page")
        listener = address.listen()
        token = build_token(address)
        self.link = address.build_link(listener.getsockname()[1], token)
        """The link to the page."""
        self.is_public = bool(token)
        """Whether other machines can reach the page. The link then contains the token."""
        self._page = PageProcess(listener, token, address.list_hosts())
        self._wall = MonotonicClock()
        self._run: RunContext | None = None
        self._builder: SnapshotBuilder | None = None
        self._thread: Thread | None = None
        self._changed = Condition()
        self._newest: Snapshot | None = None
        self._is_new = False
        self._causes: dict[str, None] = {}
        self._active_causes: frozenset[str] = frozenset()
        self._state = ""
        self._lines: deque[dict[str, Any]] = deque(maxlen=MAX_LINES)
        self._last_warning = ""
        self._end: dict[str, Any] | None = None
        self._is_closing = False
        self._viewers = 0
        self._sent_pictures: dict[str, Image] = {}
        """The picture of each name that the page has."""
        self._map_due = self._summary_due = 0.0

    def describe_link(self) -> str:
        """Return the link to the page as text, with a QR code for phones if other machines can reach the page."""
        return describe_link(self.link, is_public=self.is_public)

    def begin(self, run: RunContext) -> None:
        self._run, self._builder = run, SnapshotBuilder(run)
        self._page.start(self._handle_action, self._report_page_end)
        self._thread = start_thread(self._send_all, "live page")

    def tick(self, record: TickRecord) -> None:
        if self._builder is None:
            return
        snapshot = self._builder.take(record)
        with self._changed:
            self._newest, self._is_new = snapshot, True
            self._add_lines(record)
            self._changed.notify()

    def end(self, result: RunResult) -> None:
        with self._changed:
            self._end = {
                "type": "end",
                "headline": result.headline,
                "reason": result.reason,
                "exit_status": result.exit_status,
                "notes": list(result.notes),
            }
        self.close()

    def close(self) -> None:
        """Send the last messages, and end the page's process. Later calls do nothing."""
        with self._changed:
            self._is_closing = True
            self._changed.notify()
        if self._thread:
            self._thread.join(CLOSING_S)
            if self._thread.is_alive():
                self._page.kill()
                self._thread.join(CLOSING_S)
        self._page.close()
        self._wall.close()

    def _add_lines(self, record: TickRecord) -> None:
        causes = frozenset(each.cause for each in record.interventions) - {AccelerationLimit.cause}
        self._causes |= dict.fromkeys(each.cause for each in record.interventions)
        state = record.status_text
        texts = [("Info", f"state: {state}")] if state != self._state else []
        texts += [("Warning", f"{cause} changes the command") for cause in sorted(causes - self._active_causes)]
        texts += [("Warning", warning) for warning in record.warnings]
        texts += [("Info", line) for line in record.printed]
        self._state, self._active_causes = state, causes
        for level, text in texts:
            self._add_line(level, text)

    def _handle_action(self, action: dict[str, Any]) -> None:
        assert self._run
        if action["type"] == "viewers":
            self._viewers, self._sent_pictures = action["count"], {}
        elif not self._is_late(action):
            try:
                execute_action(self._run, action)
            except RobotcoreError as refusal:
                self._add_line("Warning", str(refusal))
        elif action["type"] == "actuate":
            self._add_line("Warning", f"a viewer's command to {action['device']} came too late, and has no effect")
        if action["type"] in {"viewers", "pace", "release"}:
            with self._changed:  # a paused run has no ticks, so the page would not show the change
                self._is_new = self._newest is not None
                self._changed.notify()

    def _report_page_end(self) -> None:
        """Say that the page's process has ended, and end a pause, which no viewer can end now.

        A robot that a viewer drove stands, because its commands have expired, and the app does not continue.
        """
        assert self._run
        if not self._is_closing:
            self._run.add_note(LOST_PAGE)
            if self._run.pace:
                self._run.pace.resume()

    def _is_late(self, action: dict[str, Any]) -> bool:
        """Return whether an action moves something and has waited for too long, as while the run was suspended."""
        is_motion = action["type"] in {"drive", "actuate"}
        return is_motion and self._wall.now() > self._wall.time_of(action["time"]) + LEASE_S

    def _warn(self, text: str) -> None:
        """Add a warning, unless it is the last one again."""
        if text != self._last_warning:
            self._last_warning = text
            self._add_line("Warning", text)

    def _add_line(self, level: str, text: str) -> None:
        time = self._newest.record.time if self._newest else 0.0
        self._lines.append({"type": "line", "level": level, "time": round(time, 3), "text": text})

    def _send_all(self) -> None:
        run = self._run
        assert run
        if not self._page.send(Message(describe_run(run))):
            return
        if (world := draw_world(run.world if run.truth else None)) is not None:
            self._page.send(build_picture_message("@world", world))
        is_open = True
        while is_open:
            due = self._wall.now() + PERIOD_S
            with self._changed:
                self._changed.wait_for(lambda: self._is_new or self._is_closing)
                is_open = not self._is_closing
                snapshot, self._is_new = self._newest, False
                causes, self._causes = list(self._causes), {}
                lines, self._lines = list(self._lines), deque(maxlen=MAX_LINES)
            try:
                is_open &= all(map(self._page.send, self._build_messages(snapshot, causes, lines)))
            except Exception as error:  # noqa: BLE001  any exception of a device's class: the page goes on without it
                self._warn(f"the live page cannot show all of the run: {type(error).__name__}: {error}")
            with self._changed:
                self._changed.wait_for(lambda: self._is_closing, max(0.0, due - self._wall.now()))
        if self._end:
            self._page.send(Message(self._end))

    def _build_messages(
        self, snapshot: Snapshot | None, causes: Sequence[str], lines: Sequence[dict[str, Any]]
    ) -> Iterator[Message]:
        assert self._builder
        yield from map(Message, lines)
        if snapshot is None:
            return
        yield Message(self._builder.build_message(snapshot, causes))
        if self._viewers:
            sent = self._sent_pictures
            for name, image in self._builder.list_pictures(snapshot):
                if name in snapshot.commands or sent.get(name) is not image:  # an app may draw on a shown picture again
                    sent[name] = image
                    yield build_picture_message(name, image)
            yield from self._draw_map(snapshot)
            yield from self._summarise_ticks()

    def _summarise_ticks(self) -> Iterator[Message]:
        assert self._run
        if self._wall.now() >= self._summary_due:
            self._summary_due = self._wall.now() + SUMMARY_PERIOD_S
            yield Message({"type": "timing", "phases": self._run.statistics.summarise()})

    def _draw_map(self, snapshot: Snapshot) -> Iterator[Message]:
        assert self._run
        grid, now = find_grid(self._run.behaviour), self._wall.now()
        if grid is None or now < self._map_due:
            return
        self._map_due = now + MAP_PERIOD_S
        with suppress(ValueError, IndexError):  # the app may change its map meanwhile
            yield build_picture_message("@map", grid.draw(snapshot.pose, (), MAP_PX))


def describe_link(link: str, *, is_public: bool) -> str:
    """Return the link to a page as text, with a QR code for phones if other machines can reach the page."""
    if not is_public:
        return f"The live page: {link}"
    import segno

    code = io.StringIO()
    segno.make(link, micro=False).terminal(out=code, compact=True)
    return f"The live page, also for other machines: {link}\n{code.getvalue()}"
