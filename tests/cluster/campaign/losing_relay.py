"""Hands TCP connections to databases on, and loses answers to appends when it is told to.

    losing_relay.py HOST SEED PORT:ADDRESS:PORT...

Its standard input has a number a line. Then it loses the answers to so many appends that the
database has committed, chosen at random among those that come, and prints what it did, as a line of
JSON:

    lost_answers  of appends that were committed: the relay has read these answers, the client not
    at_once       of these: the client's connection was cut before the answer was there
    late          appends that reached the database after the client's connection was cut, and that
                  the database refused, as the outcome had been looked for before
    claims        answers lost of claims, by which a server looks for an outcome
    unknown       connections that the database ended before its answer was there
"""
from __future__ import annotations

import asyncio
import functools
import json
import random
import socket
import struct
import sys
from typing import Optional

from relay import Stream, listen

APPEND = b"INSERT INTO dynmesh.entries"
CLAIM = b"SET epoch = epoch + 1 WHERE key = $1::bigint AND owner = $2::text "
# Of appends, how many are chosen; of these, how many are cut at once, and how many of those late.
CHOSEN, AT_ONCE, LATE = 0.5, 0.5, 0.2
CHOSEN_CLAIMS = 0.1
LATE_BY = 0.05  # seconds at most
# Codes of a first message that the server answers by one byte, without a message.
ENCRYPTION = (80877103, 80877104)


class Messages:
    """Cuts a stream of PostgreSQL's protocol into messages: a type, a length and the rest."""

    def __init__(self) -> None:
        self._rest = b""

    def add(self, data: bytes) -> list[bytes]:
        """The messages that are complete now."""
        self._rest += data
        found = []
        while len(self._rest) >= 5:
            length = 1 + int.from_bytes(self._rest[1:5], "big")
            if len(self._rest) < length:
                break
            found.append(self._rest[:length])
            self._rest = self._rest[length:]
        return found


class Losses:
    """What is to be lost, and what was."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance
        self.wanted = 0
        self.under_way = 0
        self.done: dict[str, int] = {}

    def begin(self, wanted: int) -> None:
        self.done = dict.fromkeys(("lost_answers", "at_once", "late", "claims", "unknown"), 0)
        self.wanted = wanted

    @property
    def is_over(self) -> bool:
        return self.done.get("lost_answers", 0) >= self.wanted and self.under_way == 0

    def chooses(self, share: float) -> bool:
        """Not more answers of appends than are wanted, if all of them are committed."""
        return (self.done.get("lost_answers", 0) + self.under_way < self.wanted
                and self.chance.random() < share)

    def count(self, what: str) -> None:
        self.done[what] += 1


class Connection:
    """One connection of a server, and the one to the database behind it."""

    def __init__(self, losses: Losses, near: asyncio.StreamWriter,
                 far: asyncio.StreamWriter) -> None:
        self._losses = losses
        self._near, self._far = near, far
        self._asked, self._answered = Messages(), Messages()
        self._appends: set[bytes] = set()  # names of prepared statements
        self._claims: set[bytes] = set()
        self._losing = ""  # "append" or "claim" while its answer is to be lost
        self._at_once = self._is_late = self._is_cut = False
        self._held: list[bytes] = []  # of a statement that is late
        self._rows: Optional[bytes] = None  # what the answer says of them

    async def hand_on_questions(self, source: asyncio.StreamReader) -> None:
        try:
            while data := await self._first_message(source):
                self._far.write(data)
                if int.from_bytes(data[4:8], "big") not in ENCRYPTION:
                    break
            while data and (data := await source.read(65536)):
                for message in self._asked.add(data):
                    self._look_at(message)
                    await self._hand_on(message)
                await self._far.drain()
        finally:
            if not self._losing:
                self._far.close()

    async def _hand_on(self, message: bytes) -> None:
        is_complete = self._losing != "" and message[:1] == b"S"
        if self._is_late:
            self._held.append(message)
            if not is_complete:
                return
        if is_complete and self._at_once:
            self._cut()
        if self._is_late:
            await asyncio.sleep(LATE_BY * self._losses.chance.random())
            message = b"".join(self._held)
        self._far.write(message)

    @staticmethod
    async def _first_message(source: asyncio.StreamReader) -> bytes:
        try:
            head = await source.readexactly(4)
            return head + await source.readexactly(int.from_bytes(head, "big") - 4)
        except asyncio.IncompleteReadError:
            return b""

    def _look_at(self, message: bytes) -> None:
        """At what a server sends: a statement that it prepares, or one that it runs."""
        if message[:1] == b"P":
            name, text = message[5:].split(b"\0", 2)[:2]
            if APPEND in text:
                self._appends.add(name)
            elif CLAIM in text:
                self._claims.add(name)
        elif message[:1] == b"B":
            name = message[5:].split(b"\0", 2)[1]
            if name in self._appends and self._losses.chooses(CHOSEN):
                self._losing = "append"
                self._at_once = self._losses.chance.random() < AT_ONCE
                self._is_late = self._at_once and self._losses.chance.random() < LATE
            elif name in self._claims and self._losses.chooses(CHOSEN_CLAIMS):
                self._losing = "claim"
            self._losses.under_way += self._losing != ""

    async def hand_on_answers(self, source: asyncio.StreamReader) -> None:
        try:
            while data := await source.read(65536):
                if self._losing == "":
                    self._near.write(data)
                    await self._near.drain()
                elif any(map(self._is_last, self._answered.add(data))):
                    self._count()
                    return
            if self._losing:
                self._losses.count("unknown")
        finally:
            if self._losing:
                self._losses.under_way -= 1
                self._cut()
            self._losing = ""
            self._near.close()
            self._far.close()

    def _is_last(self, message: bytes) -> bool:
        """The end of an answer comes when the transaction is committed."""
        if message[:1] == b"C":
            self._rows = message[5:-1]
        return message[:1] == b"Z"

    def _count(self) -> None:
        if self._losing == "claim":
            self._losses.count("claims")
        elif self._rows == b"SELECT 1":
            self._losses.count("lost_answers")
            if self._at_once:
                self._losses.count("at_once")
        elif self._at_once:
            self._losses.count("late")

    def _cut(self) -> None:
        """Ends the server's connection: by a reset or in order, at random."""
        if self._is_cut:
            return
        self._is_cut = True
        if self._losses.chance.random() < 0.5:
            self._near.get_extra_info("socket").setsockopt(
                socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._near.transport.abort()


async def serve(losses: Losses, near: Stream, far: Stream) -> None:
    connection = Connection(losses, near[1], far[1])
    questions = asyncio.create_task(connection.hand_on_questions(near[0]))
    try:
        await connection.hand_on_answers(far[0])
    except OSError:
        pass
    finally:
        questions.cancel()
        await asyncio.gather(questions, return_exceptions=True)


async def obey(losses: Losses) -> None:
    lines = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(lines), sys.stdin)
    while line := await lines.readline():
        losses.begin(int(line))
        while not losses.is_over:
            await asyncio.sleep(0.01)
        print(json.dumps(losses.done), flush=True)


async def main() -> None:
    host, seed, *ways = sys.argv[1:]
    losses = Losses(random.Random(int(seed)))
    serve_way = functools.partial(serve, losses)
    await asyncio.gather(obey(losses), *(listen(host, way, serve_way) for way in ways))


if __name__ == "__main__":
    asyncio.run(main())
