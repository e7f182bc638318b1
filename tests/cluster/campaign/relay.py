"""Hands TCP connections on, late: each chunk 50 ms each way, one in twenty 200 ms later still.

    relay.py HOST SEED PORT:ADDRESS:PORT...
"""
from __future__ import annotations

import asyncio
import random
import sys

DELAY, MORE, SHARE = 0.05, 0.2, 0.05


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


async def main() -> None:
    host, seed, *ways = sys.argv[1:]
    chance = random.Random(int(seed))

    async def serve(way: str) -> None:
        here, address, there = way.split(":")

        async def on_connection(reader: asyncio.StreamReader,
                                writer: asyncio.StreamWriter) -> None:
            try:
                far_reader, far_writer = await asyncio.open_connection(address, int(there))
            except OSError:
                writer.close()
                return
            await asyncio.gather(hand_on(reader, far_writer, chance),
                                 hand_on(far_reader, writer, chance), return_exceptions=True)
        server = await asyncio.start_server(on_connection, host, int(here))
        async with server:
            await server.serve_forever()

    await asyncio.gather(*map(serve, ways))


if __name__ == "__main__":
    asyncio.run(main())
