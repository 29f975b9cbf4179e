"""The hub of the page's server: the newest state of the run, and the viewers who get it."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Callable
from typing import Any

from robotcore.live.actions import read_action
from robotcore.live.messages import encode
from robotcore.live.viewer import Viewer

MAX_VIEWERS = 16
MAX_LINES = 300
"""The number of log lines that a new viewer gets."""

MAX_WHEELS = 500
"""The number of ticks whose velocities of the wheels a new viewer gets: 20 s with 25 in a second."""

WHEEL_KEYS = ("time", "asked", "sent", "measured")
"""The parts of a tick that the plot of the wheels shows."""

MAX_PATH_POINTS = 3000
"""A longer path loses every second of its points."""


class Hub:
    """Passes each message of the run to the viewers, and their actions to the run.

    A new viewer gets the description of the run, the path so far, the last lines and velocities of the wheels, and the
    newest pictures.

    act: sends an action to the run.
    """

    def __init__(self, act: Callable[[dict[str, Any]], None]) -> None:
        self._act = act
        self._run: dict[str, Any] | None = None
        self._end: dict[str, Any] | None = None
        self._timing: dict[str, Any] | None = None
        self._lines: deque[dict[str, Any]] = deque(maxlen=MAX_LINES)
        self._path: list[list[Any]] = []
        self._wheels: deque[dict[str, Any]] = deque(maxlen=MAX_WHEELS)
        self._is_pressed = False
        self._operator: Viewer | None = None
        self._time = 0.0
        self.tick = b""
        """The newest tick, as JSON."""
        self.pictures: dict[str, bytes] = {}
        """The newest message with the picture of each name."""
        self.viewers: set[Viewer] = set()

    @property
    def is_full(self) -> bool:
        """Whether no other viewer may enter."""
        return len(self.viewers) >= MAX_VIEWERS

    def receive(self, content: dict[str, Any], picture: bytes) -> None:
        """Pass a message of the run to the viewers.

        picture: the encoded picture of a message of the type ``picture``, with its name before it.
        """
        match content["type"]:
            case "picture":
                self.pictures[content["name"]] = picture
                for viewer in self.viewers:
                    viewer.add_picture(content["name"])
            case "tick":
                self.tick, self._time = encode(content), content["time"]
                self._extend_path(content["path"])
                self._wheels += [*content.get("wheels", ()), {key: content[key] for key in WHEEL_KEYS}]
                for viewer in self.viewers:
                    viewer.add_tick()
            case kind:
                if kind == "history":
                    self._path, self._lines = list(content["path"]), deque(content["lines"], maxlen=MAX_LINES)
                    self._wheels = deque(content["wheels"], maxlen=MAX_WHEELS)
                elif kind == "run":
                    self._run = content
                elif kind == "end":
                    self._end = content
                elif kind == "line":
                    self._lines.append(content)
                elif kind == "timing":
                    self._timing = content
                self._broadcast(content)

    def enter(self, viewer: Viewer) -> None:
        """Add a viewer, and send it the present state."""
        self.viewers.add(viewer)
        if self._run:
            viewer.add_message(encode(self._run))
        history = {"path": self._path, "lines": list(self._lines), "wheels": list(self._wheels)}
        viewer.add_message(encode({"type": "history", **history}))
        viewer.add_tick()
        if self._timing:
            viewer.add_message(encode(self._timing))
        for name in self.pictures:
            viewer.add_picture(name)
        if self._end:
            viewer.add_message(encode(self._end))
        self._describe_viewers()

    def leave(self, viewer: Viewer) -> None:
        """Remove a viewer. If it drives, the robot stands, and waits for a person."""
        if viewer not in self.viewers:
            return
        self.viewers.remove(viewer)
        if viewer is self._operator:
            self._operator = None
            self._act({"type": "drive", "linear": 0.0, "angular": 0.0})
            self._add_line("the viewer who drove has left, and the robot stands")
        self._describe_viewers()

    def press_estop(self) -> None:
        """Press the e-stop of the run. It stays pressed, so only the first press is sent."""
        if not self._is_pressed:
            self._is_pressed = True
            self._act({"type": "estop"})

    def handle(self, viewer: Viewer, text: str) -> None:
        """Execute a message of a viewer. Raises ValueError for a message that the page does not send.

        Actions of a viewer who does not drive have no effect, because another viewer may just have taken over.
        """
        match json.loads(text, parse_constant=_refuse_constant):
            case {"type": "estop"}:
                self.press_estop()
            case {"type": "ack", "picture": str(name)}:
                viewer.acknowledge_picture(name)
            case {"type": "ack", "tick": int(_)}:
                viewer.acknowledge_tick()
            case {"type": "take"}:
                if viewer is not self._operator:
                    self._add_line("another viewer drives now" if self._operator else "a viewer drives now")
                self._operator = viewer
                self._describe_viewers()
            case dict(message):
                self._execute(viewer, read_action(message))
            case _:
                raise ValueError("not a message")

    def _execute(self, viewer: Viewer, action: dict[str, Any]) -> None:
        """Send an action of the viewer who drives to the run. Without one, any viewer may pause or release."""
        needs_operator = action["type"] in {"drive", "actuate"}
        if needs_operator and viewer.delays.is_late(action.pop("sent") / 1000, asyncio.get_running_loop().time()):
            if viewer is self._operator:
                self._add_line("the commands of the viewer who drives come too late, and have no effect")
            return
        if viewer is self._operator or (self._operator is None and not needs_operator):
            self._act(action)
            if action["type"] == "release":
                self._operator = None
                self._add_line("a viewer has returned the robot to the app")
                self._describe_viewers()

    def _describe_viewers(self) -> None:
        """Send to each viewer the number of viewers, and which one drives."""
        count = len(self.viewers)
        self._act({"type": "viewers", "count": count})
        for viewer in self.viewers:
            operator = "none" if self._operator is None else "you" if viewer is self._operator else "other"
            viewer.add_message(encode({"type": "viewers", "count": count, "operator": operator}))

    def _add_line(self, text: str) -> None:
        """Add a line to the log of the page, unless it is the last one again."""
        if not self._lines or self._lines[-1]["text"] != text:
            self.receive({"type": "line", "level": "Info", "time": self._time, "text": text}, b"")

    def _broadcast(self, content: dict[str, Any]) -> None:
        text = encode(content)
        for viewer in self.viewers:
            viewer.add_message(text)

    def _extend_path(self, points: list[list[Any]]) -> None:
        self._path += points
        if len(self._path) > MAX_PATH_POINTS:
            del self._path[1::2]


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")
