"""Read the live page as several viewers, without a browser: ``python -m benchmarks.live_viewers LINK NUMBER``.

It prints a line when all viewers get ticks, and ends with the run.
"""

from __future__ import annotations

import asyncio
import json
import sys
from urllib.parse import urlsplit

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed
from websockets.typing import Origin


async def view(link: str, has_tick: asyncio.Event) -> None:
    """Acknowledge each tick and each picture, as the page does."""
    where = urlsplit(link).netloc
    async with connect(f"ws://{where}/live", origin=Origin(f"http://{where}"), max_size=None) as socket:
        await socket.send(json.dumps({"type": "hello", "token": ""}))
        async for data in socket:
            if isinstance(data, bytes):
                await socket.send(json.dumps({"type": "ack", "picture": data[1 : 1 + data[0]].decode()}))
            elif (message := json.loads(data))["type"] == "tick":
                has_tick.set()
                await socket.send(json.dumps({"type": "ack", "tick": message["tick"]}))


async def view_all(link: str, number: int) -> None:
    """View the page until the run ends."""
    ready = [asyncio.Event() for _ in range(number)]
    viewers = [asyncio.create_task(view(link, each)) for each in ready]
    await asyncio.gather(*(each.wait() for each in ready))
    print("ready", flush=True)
    for ended in await asyncio.gather(*viewers, return_exceptions=True):
        if isinstance(ended, BaseException) and not isinstance(ended, ConnectionClosed):
            raise ended


if __name__ == "__main__":
    asyncio.run(view_all(sys.argv[1], int(sys.argv[2])))
