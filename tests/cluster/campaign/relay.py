"""Hands TCP connections on, late: each chunk 50 ms each way, one in twenty 200 ms later still.

    relay.py HOST SEED PORT:ADDRESS:PORT...
"""
from __future__ import annotations

import asyncio
import random
import sys
from typing import Awaitable, Callable

DELAY, MORE, SHARE = 0.05, 0.2, 0.05
Stream = tuple[asyncio.StreamReader, asyncio.StreamWriter]


async def hand_on(source: asyncio.StreamReader, target: asyncio.StreamWriter,
                  chance: random.Random) -> None:
    """In order: a chunk does not overtake the one before."""
    chunks: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
    now = asyncio.get_running_loop().time

    async def send() -> None:
        last = 0.0
        while True:
            due, data = await chunks.get()
            last = max(last, due)
            await asyncio.sleep(max(0.0, last - now()))
            if not data:
                target.close()
                return
            target.write(data)
            await target.drain()

    sender = asyncio.create_task(send())
    try:
        data = b"x"
        while data and not sender.done():
            data = await source.read(65536)
            late = MORE if chance.random() < SHARE else 0.0
            chunks.put_nowait((now() + DELAY + late, data))
        await sender
    except OSError:
        sender.cancel()
        target.close()


async def listen(host: str, way: str,
                 serve: Callable[[Stream, Stream], Awaitable[object]]) -> None:
    """Serves the connections of a way, PORT:ADDRESS:PORT: the client's and the one behind it."""
    here, address, there = way.split(":")
    tasks: set[object] = set()  # one whose client is gone has no other owner

    async def on_connection(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        tasks.add(task)
        try:
            far = await asyncio.open_connection(address, int(there))
        except OSError:
            writer.close()
        else:
            await serve((reader, writer), far)
        finally:
            tasks.discard(task)
    server = await asyncio.start_server(on_connection, host, int(here))
    async with server:
        await server.serve_forever()


async def main() -> None:
    host, seed, *ways = sys.argv[1:]
    chance = random.Random(int(seed))

    async def serve(near: Stream, far: Stream) -> None:
        await asyncio.gather(hand_on(near[0], far[1], chance), hand_on(far[0], near[1], chance),
                             return_exceptions=True)
    await asyncio.gather(*(listen(host, way, serve) for way in ways))


if __name__ == "__main__":
    asyncio.run(main())
