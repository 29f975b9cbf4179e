"""The server of the page that plays recordings."""

from __future__ import annotations

import asyncio
import json
import math
import socket
from collections.abc import AsyncIterator, Sequence
from contextlib import suppress
from typing import Any

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from robotcore.errors import RecordingError
from robotcore.live.access import Access, AccessControl
from robotcore.live.connections import mark_viewer
from robotcore.live.hub import MAX_LINES, MAX_PATH_POINTS, Hub
from robotcore.live.messages import encode
from robotcore.live.page_process import build_picture_message
from robotcore.live.playback import Playback, draw_missing_picture
from robotcore.live.server import (
    FLOOD,
    HELLO_S,
    PAGE,
    WRONG_TOKEN,
    build_server,
    encode_picture,
    read_token,
    serve_viewer,
)
from robotcore.live.viewer import SENDING_S
from robotcore.optics import Image

MAX_STEP_TICKS = 100
"""A seek over more ticks sends the whole path again."""

Messages = list[tuple[dict[str, Any], bytes]]


class Screen:
    """Shows one recording at one time, to all viewers."""

    def __init__(self, playback: Playback) -> None:
        self.playback, self.hub = playback, Hub(_ignore)
        self._at = -1
        self._shown: dict[str, object] = {}

    def begin(self) -> Messages:
        """Return the messages before the first tick."""
        world = self.playback.draw_world()
        return [(self.playback.describe(), b""), *([] if world is None else [_build_picture("@world", world)])]

    def seek(self, at: int) -> Messages:
        """Return the messages that show a tick."""
        playback, before = self.playback, self._at
        if at == before:
            return []
        self._at, messages = at, []
        if before < at <= before + MAX_STEP_TICKS:
            since = before + 1
            messages += playback.list_lines(since, at)
        else:
            since = at + 1
            path, lines = playback.list_path(0, at), playback.list_lines(0, at)[-MAX_LINES:]
            path = path[:: 1 + len(path) // MAX_PATH_POINTS]
            messages.append({"type": "history", "path": path, "lines": lines, "wheels": playback.list_wheels(at)})
        messages.append(playback.build_tick(at, since))
        return [*((each, b"") for each in messages), *self._list_pictures(at)]

    def _list_pictures(self, at: int) -> Messages:
        pictures: Messages = []
        for name, key in self.playback.list_pictures(at):
            if self._shown.get(name) != key:
                self._shown[name] = key
                try:
                    image = self.playback.read_picture(key) if key else draw_missing_picture()
                    pictures.append(_build_picture(name, image))
                except RecordingError as error:
                    time = round(self.playback.times[at], 3)
                    pictures.append(({"type": "line", "level": "Error", "time": time, "text": str(error)}, b""))
        return pictures


def _build_picture(name: str, image: Image) -> tuple[dict[str, Any], bytes]:
    message = build_picture_message(name, image)
    return message.content, encode_picture(message.content, bytes(message.picture))


def _ignore(action: dict[str, Any]) -> None:
    """Do nothing, because a recording has no actuators."""


class Player:
    """Shows recordings side by side, at the same time of their clocks."""

    def __init__(self, playbacks: Sequence[Playback]) -> None:
        self.screens = [Screen(each) for each in playbacks]
        self._lock, self._moved = asyncio.Lock(), asyncio.Condition()
        self.moves = 0
        """The number of seeks and steps of all viewers."""
        self._time = min(each.times[0] for each in playbacks)

    async def begin(self) -> None:
        """Show the first tick."""
        for screen in self.screens:
            for content, picture in screen.begin():
                screen.hub.receive(content, picture)
        await self.seek(self._time)

    def describe(self) -> dict[str, Any]:
        """Return the message with the names, the times and the problems of the recordings."""
        shown = [each.playback for each in self.screens]
        recordings = [
            {"name": each.name, "begin": each.times[0], "end": each.times[-1], "problems": each.problems}
            for each in shown
        ]
        return {"type": "player", "time": self._time, "recordings": recordings}

    async def seek(self, time: float) -> None:
        """Show a time in seconds."""
        async with self._lock:
            self._time = time
            ticks = [each.playback.find(time) for each in self.screens]
            for screen, at in zip(self.screens, ticks, strict=True):
                for content, picture in await asyncio.to_thread(screen.seek, at):
                    screen.hub.receive(content, picture)
        async with self._moved:
            self.moves += 1
            self._moved.notify_all()

    async def list_times(self, moves: int) -> AsyncIterator[float]:
        """Yield the time that is shown, in seconds, after each seek and step of any viewer.

        moves: the number of the last move that is known.
        """
        while True:
            async with self._moved:
                while self.moves == moves:
                    await self._moved.wait()
            moves = self.moves
            yield self._time

    async def step(self, by: int) -> None:
        """Show the next tick of any recording, or with -1 the one before."""
        shown = [each.playback for each in self.screens]
        at = [each.find(self._time) for each in shown]
        if by > 0:
            times = [each.times[tick + 1] for each, tick in zip(shown, at, strict=True) if tick + 1 < len(each.times)]
            # a recording that begins later has its first tick ahead
            times += [each.times[0] for each in shown if each.times[0] > self._time + 1e-9]
            await self.seek(min(times, default=self._time))
            return
        times = [
            each.times[tick - (each.times[tick] >= self._time - 1e-9)]
            for each, tick in zip(shown, at, strict=True)
            if tick or each.times[0] < self._time - 1e-9
        ]
        await self.seek(max(times, default=self._time))


def build_app(player: Player, access: Access) -> Starlette:
    """Return the application that serves the player, and a page for each recording."""

    async def show_player(_request: Request) -> Response:
        return FileResponse(PAGE / "player.html")

    # The class, and not the first message, hides the stop button, so that the page never shows it.
    classes = "is-recording" if len(player.screens) == 1 else "is-recording is-pair"
    page = (PAGE / "index.html").read_text(encoding="utf-8").replace("<body>", f'<body class="{classes}">')

    async def show_page(_request: Request) -> Response:
        return HTMLResponse(page)

    async def control(socket: WebSocket) -> None:
        await serve_controls(socket, player, access)

    files = StaticFiles(directory=PAGE)
    routes: list[BaseRoute] = [Route("/", show_player), WebSocketRoute("/player", control), Mount("/page", files)]
    for number, screen in enumerate(player.screens, 1):

        async def show_recording(socket: WebSocket, hub: Hub = screen.hub) -> None:
            await serve_viewer(socket, hub, access)

        routes += [
            Route(f"/{number}/", show_page),
            WebSocketRoute(f"/{number}/live", show_recording),
            Mount(f"/{number}/page", files),
        ]
    return Starlette(routes=routes, middleware=[Middleware(AccessControl, access=access)])


async def serve_controls(socket: WebSocket, player: Player, access: Access) -> None:
    """Serve the slider and the buttons of one viewer."""
    await socket.accept()
    with suppress(WebSocketDisconnect, asyncio.TimeoutError, RuntimeError):
        if not access.is_token_right(await asyncio.wait_for(read_token(socket), HELLO_S)):
            await socket.close(WRONG_TOKEN)
            return
        mark_viewer(socket)
        sending = asyncio.create_task(_send_times(socket, player))
        try:
            while True:
                await _execute(player, json.loads(await socket.receive_text()))
        except (ValueError, KeyError, RecursionError, OverflowError):  # KeyError: a binary message
            await socket.close(FLOOD)
        finally:
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)


async def _send_times(socket: WebSocket, player: Player) -> None:
    """Send the description of the recordings, and each time that is shown."""
    moves = player.moves
    await socket.send_text(encode(player.describe()).decode())
    async for time in player.list_times(moves):
        message = encode({"type": "time", "time": time}).decode()
        await asyncio.wait_for(socket.send_text(message), SENDING_S)


async def _execute(player: Player, message: Any) -> None:
    match message:
        case {"type": "seek", "time": int(time) | float(time)} if math.isfinite(time):
            await player.seek(float(time))
        case {"type": "step", "by": (1 | -1) as by}:
            await player.step(by)
        case _:
            raise ValueError("not a message of the player")


async def serve(listener: socket.socket, playbacks: Sequence[Playback], token: str, hosts: Sequence[str]) -> None:
    """Serve the player until a signal ends the process."""
    player = Player(playbacks)
    await player.begin()
    access = Access(token, tuple(hosts), has_frames=True)
    await build_server(build_app(player, access)).serve([listener])
