"""The server of the live page, in a process of its own.

Standard input has the messages of the run, and standard output gets the actions of the viewers, one line of JSON each.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import socket
import sys
from contextlib import suppress
from pathlib import Path
from threading import Condition
from typing import Any, BinaryIO

import cv2
import numpy as np
import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from robotcore.live.access import Access, AccessControl
from robotcore.live.address import Address
from robotcore.live.connections import (
    MAX_ACCEPTED,
    MAX_REQUEST_BYTES,
    LimitedHttp,
    LimitedWebSocket,
    Listener,
    mark_viewer,
)
from robotcore.live.hub import Hub
from robotcore.live.messages import HEAD, MAX_JSON_BYTES, MAX_PICTURE_BYTES
from robotcore.live.viewer import Viewer
from robotcore.system import HAS_POSIX
from robotcore.threads import start_thread

PAGE = Path(__file__).parent / "page"

HELLO_S = 5.0
"""A viewer who does not send the token within this time, in seconds, is dropped."""

MAX_MESSAGE_BYTES = 4096
"""The greatest size of a message of a viewer."""

PING_S = 5.0
"""The time between two pings of a viewer, and the longest wait for its answer, in seconds."""

MAX_WAITING = 32
"""The number of actions that wait for the run, above which it gets no more commands to actuators."""

JPEG_QUALITY = 82

WRONG_TOKEN, FULL, FLOOD, ENDED = 4401, 4429, 1008, 4000
"""The codes with which the server closes a viewer's socket."""

FLUSH_S = 0.5
"""The longest wait for the viewers to read the end of the run, in seconds."""


def build_app(hub: Hub, access: Access) -> Starlette:
    """Return the application that serves the page, its socket and the e-stop."""

    async def show_page(_request: Request) -> Response:
        return FileResponse(PAGE / "index.html")

    async def press_estop(request: Request) -> Response:
        if not access.may_press_estop(request.headers):
            return Response(status_code=403)
        hub.press_estop()
        return Response(status_code=204)

    async def show_live(socket: WebSocket) -> None:
        await serve_viewer(socket, hub, access)

    routes = [
        Route("/", show_page),
        Route("/estop", press_estop, methods=["POST"]),
        WebSocketRoute("/live", show_live),
        Mount("/page", StaticFiles(directory=PAGE)),
    ]
    return Starlette(routes=routes, middleware=[Middleware(AccessControl, access=access)])


async def serve_viewer(socket: WebSocket, hub: Hub, access: Access) -> None:
    """Serve one viewer, until it leaves, does not read, or sends what the page does not send."""
    await socket.accept()
    with suppress(WebSocketDisconnect, asyncio.TimeoutError, RuntimeError):
        if not access.is_token_right(await asyncio.wait_for(read_token(socket), HELLO_S)):
            await socket.close(WRONG_TOKEN)
            return
        if hub.is_full:
            await socket.close(FULL)
            return
        mark_viewer(socket)
        viewer = Viewer(socket, hub)
        hub.enter(viewer)
        try:
            tasks = [asyncio.create_task(viewer.send_all()), asyncio.create_task(_read_all(socket, hub, viewer))]
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            viewer.is_dropped = True  # before Python 3.12, `asyncio.wait_for` may lose the cancellation
            for task in tasks:
                task.cancel()
            for result in await asyncio.gather(*tasks, return_exceptions=True):
                if isinstance(result, Exception):
                    raise result
            await socket.close(ENDED if viewer.is_ending else FLOOD)
        finally:
            hub.leave(viewer)


async def read_token(socket: WebSocket) -> object:
    """Return the token in the first message of a viewer; None if it has none."""
    try:
        hello = json.loads(await socket.receive_text())
    except (ValueError, KeyError, RecursionError):
        return None
    return hello.get("token", "") if isinstance(hello, dict) and hello.get("type") == "hello" else None


async def _read_all(socket: WebSocket, hub: Hub, viewer: Viewer) -> None:
    with suppress(ValueError, KeyError, RecursionError):  # KeyError: a binary message
        while True:
            hub.handle(viewer, await socket.receive_text())


class ActionPipe:
    """Writes the actions of the viewers for the run. It never waits.

    While the run does not read, only the newest action of each kind waits, and a press of the e-stop is the first.
    """

    def __init__(self, descriptor: int, loop: asyncio.AbstractEventLoop) -> None:
        self._descriptor, self._loop = descriptor, loop
        self._waiting: dict[tuple[str, ...], dict[str, Any]] = {}
        self._changed = Condition()
        if HAS_POSIX:
            os.set_blocking(descriptor, False)
        else:
            start_thread(self._write_all, "actions")

    def write(self, action: dict[str, Any]) -> None:
        """Write an action as a line, with the time at which this was called."""
        kind = (action["type"], action.get("device", ""), *action)
        with self._changed:
            if kind[0] == "actuate" and len(self._waiting) >= MAX_WAITING:
                return
            self._waiting.pop(kind, None)
            self._waiting[kind] = action | {"time": self._loop.time()}
            self._changed.notify()
        if HAS_POSIX:
            self._write_waiting()

    def _find_first(self) -> tuple[str, ...]:
        return min(self._waiting, key=lambda each: each[0] != "estop")

    def _write_waiting(self) -> None:
        try:
            while self._waiting:
                kind = self._find_first()
                # The system writes a line as a whole or not at all, because it is shorter than PIPE_BUF.
                os.write(self._descriptor, json.dumps(self._waiting[kind]).encode() + b"\n")
                del self._waiting[kind]
        except BlockingIOError:
            self._loop.add_writer(self._descriptor, self._write_waiting)
            return
        except OSError:  # the run has ended
            self._waiting.clear()
        self._loop.remove_writer(self._descriptor)

    def _write_all(self) -> None:
        """Write the actions in a thread, which waits while the run does not read. Windows has no other way."""
        with suppress(OSError):  # the run has ended
            while True:
                with self._changed:
                    self._changed.wait_for(lambda: self._waiting)
                    action = self._waiting.pop(self._find_first())
                os.write(self._descriptor, json.dumps(action).encode() + b"\n")


class RunPipe:
    """Reads the messages of the run in a thread of its own, which also encodes the pictures."""

    def __init__(self, source: BinaryIO, loop: asyncio.AbstractEventLoop) -> None:
        self._source, self._loop = source, loop

    def read(self) -> tuple[dict[str, Any], bytes] | None:
        """Return the next message and its encoded picture; None at the end of the run."""
        head = self._source.read(HEAD.size)
        if len(head) < HEAD.size:
            return None
        text_size, picture_size = HEAD.unpack(head)
        if text_size > MAX_JSON_BYTES or picture_size > MAX_PICTURE_BYTES:
            return None
        content: dict[str, Any] = json.loads(self._source.read(text_size))
        pixels = self._source.read(picture_size)
        try:
            return content, encode_picture(content, pixels) if picture_size else b""
        except (cv2.error, ValueError, KeyError) as error:
            text = f"the page cannot show the picture {content.get('name')}: {error}"
            return {"type": "line", "level": "Warning", "time": 0.0, "text": text}, b""

    def pass_on(self, hub: Hub, ended: asyncio.Event) -> None:
        """Pass each message to the hub, in the thread of the event loop. Set ``ended`` at the end of the run."""

        async def receive(content: dict[str, Any], picture: bytes) -> None:
            hub.receive(content, picture)

        try:
            with suppress(ValueError, OSError, RuntimeError):  # RuntimeError: the event loop has ended
                while message := self.read():
                    asyncio.run_coroutine_threadsafe(receive(*message), self._loop).result()
        finally:
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(ended.set)


def encode_picture(content: dict[str, Any], pixels: bytes) -> bytes:
    """Return the message with a picture: one byte with the length of its name, the name, and a JPEG or a PNG.

    A drawing, whose name begins with ``@``, is a PNG.
    """
    image = np.frombuffer(pixels, np.uint8).reshape(content["shape"])
    is_drawing = content["name"].startswith("@")
    ending, options = (".png", []) if is_drawing else (".jpg", [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    _, encoded = cv2.imencode(ending, image, options)
    name = content["name"].encode()[:255]
    return b"".join((bytes([len(name)]), name, encoded.tobytes()))


def build_server(app: Starlette) -> uvicorn.Server:
    """Return a server of an application, with the limits of the page."""
    logging.getLogger("asyncio").setLevel(
        logging.CRITICAL
    )  # else it logs, such as an error for each refused connection
    return uvicorn.Server(
        uvicorn.Config(
            app,
            http=LimitedHttp,
            h11_max_incomplete_event_size=MAX_REQUEST_BYTES,
            ws=LimitedWebSocket,
            ws_max_size=MAX_MESSAGE_BYTES,
            ws_per_message_deflate=False,
            ws_ping_interval=PING_S,
            ws_ping_timeout=PING_S,
            lifespan="off",
            log_level="critical",
            backlog=MAX_ACCEPTED,
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
        )
    )


async def serve(listener: socket.socket) -> None:
    """Serve the page until the run has ended."""
    loop, ended = asyncio.get_running_loop(), asyncio.Event()
    pipe = RunPipe(sys.stdin.buffer, loop)
    first = await asyncio.to_thread(pipe.read)
    if first is None:
        return
    hub = Hub(ActionPipe(sys.stdout.fileno(), loop).write)
    access = Access(first[0]["token"], tuple(first[0]["hosts"]))
    server = build_server(build_app(hub, access))
    serving = asyncio.create_task(server.serve([listener]))
    start_thread(lambda: pipe.pass_on(hub, ended), "run")
    await asyncio.wait([serving, asyncio.create_task(ended.wait())], return_when=asyncio.FIRST_COMPLETED)
    await close_viewers(hub)
    server.should_exit = True
    await serving


async def close_viewers(hub: Hub) -> None:
    """Send the last messages to the viewers, and close their sockets."""
    viewers = tuple(hub.viewers)
    for viewer in viewers:
        viewer.end()
    if viewers:
        await asyncio.wait([asyncio.create_task(each.is_done.wait()) for each in viewers], timeout=FLUSH_S)


def main(place: int | tuple[str, int]) -> None:
    """Serve the page until the run has ended.

    place: the file descriptor of a socket that listens, or the host and the port at which this process listens.
    """
    descriptor = place if isinstance(place, int) else Address(*place).listen().detach()
    with Listener(fileno=descriptor) as listener:
        use_selectors()
        asyncio.run(serve(listener))


def use_selectors() -> None:
    """Let asyncio accept connections by the methods of a `Listener`. On Windows, it would not by default."""
    if policy := getattr(asyncio, "WindowsSelectorEventLoopPolicy", None):  # Windows alone has it
        asyncio.set_event_loop_policy(policy())
