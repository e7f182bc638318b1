#!/usr/bin/python3
"""What the statements of a shared journal cost in PostgreSQL: the constants of scale.py.

    tests/bench/experiments/database_costs.py [--quick] [--meshes M] [--nodes N]

Starts a PostgreSQL 15 of its own, as root for the user postgres, fills the tables with M meshes
(1,000,000) of N nodes (1,000), and runs the statements of server/journal. Processor time is that of
the database's process for the session, so it does not depend on what else the machine does; bytes
are those of the write-ahead log.
"""
from __future__ import annotations

import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile

from output import ROOT, arguments, write_csv

PROGRAMS = pathlib.Path("/usr/lib/postgresql/15/bin")
AS_POSTGRES = ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"]
JOURNAL = ROOT / "server/journal"
LEASE = 3_000_000  # microseconds


def statement(file: str, name: str) -> str:
    """A constant of the sources: raw text, one line, or macro and text of a place."""
    text = (JOURNAL / file).read_text(encoding="utf-8")
    raw = re.search(rf'constexpr char {name}\[\] = R"\((.*?)\)";', text, re.S)
    raw = raw or re.search(rf'constexpr char {name}\[\] = "(.*?)";', text)
    if raw:
        return raw[1].strip()
    places = re.search(r"#define DYNMESH_PLACES(.*?)\nconstexpr", text, re.S)
    own = re.search(rf'constexpr char {name}\[\] = DYNMESH_PLACES "(.*?)";', text)
    return "".join(re.findall(r'"(.*?)"\s*\\?$', places[1], re.M)) + own[1]


class Session:
    """psql, and the processor time of the process that serves it."""

    def __init__(self, socket: pathlib.Path) -> None:
        self.psql = subprocess.Popen(
            [PROGRAMS / "psql", "-XAtq", "-v", "ON_ERROR_STOP=1", "-h", socket, "-U", "postgres"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.pid = int(self.ask("SELECT pg_backend_pid()")[0])

    def ask(self, sql: str) -> list[str]:
        self.psql.stdin.write(f"{sql};\n\\echo END\n")
        self.psql.stdin.flush()
        lines = []
        while (line := self.psql.stdout.readline()) != "END\n":
            if not line:
                raise RuntimeError(f"psql has ended at: {sql[:200]}")
            lines.append(line.rstrip("\n"))
        return lines

    def seconds(self) -> float:
        return int(pathlib.Path(f"/proc/{self.pid}/schedstat").read_text().split()[0]) / 1e9

    def own_megabytes(self) -> float:
        """Without what it shares with other connections."""
        status = pathlib.Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(r"RssAnon:\s+(\d+)", status)[1]) / 1024

    def cost(self, sqls: list[str]) -> tuple[float, float]:
        """Milliseconds of processor time (median) and bytes of log (mean) of each of `sqls`."""
        times = []
        before = self.ask("SELECT pg_current_wal_insert_lsn()")[0]
        for sql in sqls:
            begun = self.seconds()
            self.ask(sql)
            times.append(1e3 * (self.seconds() - begun))
        size = self.ask(f"SELECT pg_current_wal_insert_lsn() - '{before}'::pg_lsn")[0]
        return statistics.median(times), float(size) / len(sqls)


def run(words: list[object]) -> None:
    subprocess.run([*AS_POSTGRES, *words], check=True, cwd="/", stdout=subprocess.DEVNULL)


def fill(session: Session, meshes: int, nodes: int) -> None:
    session.ask(statement("postgres_schema.cc", "kTables"))
    session.ask(statement("postgres_leases.cc", "kTables"))
    session.ask(f"""INSERT INTO dynmesh.nodes SELECT 'node-' || n, 'node-' || n || '.example:7878',
        clock_timestamp() FROM generate_series(0, {nodes - 1}) AS n""")
    session.ask(f"""INSERT INTO dynmesh.meshes(id, description, checksum, owner, lease_until)
        SELECT 'mesh-' || n, decode(repeat('00', 80), 'hex'), 0, 'node-' || n % {nodes},
        clock_timestamp() + interval '1 day' FROM generate_series(1, {meshes}) AS n""")
    session.ask("VACUUM ANALYZE dynmesh.meshes")
    session.ask("CHECKPOINT")


def prepare(session: Session) -> None:
    session.ask(f"PREPARE renew(text, text, bigint) AS {statement('postgres_leases.cc', 'kRenew')}")
    session.ask("PREPARE seen(text) AS UPDATE dynmesh.nodes SET seen = clock_timestamp() "
                "WHERE id = $1 AND seen > clock_timestamp() - interval '1 day' RETURNING 1")
    session.ask(f"PREPARE claim(bigint, text, bigint) AS "
                f"{statement('postgres_leases.cc', 'kClaimFree')}")
    session.ask(f"PREPARE live(bigint) AS {statement('postgres_leases.cc', 'kLive')}")
    session.ask(f"PREPARE locate(text, text) AS {statement('postgres_leases.cc', 'kLocate')}")
    append = statement("postgres_append.cc", "kAppend")
    session.ask(f"PREPARE append(bigint, bigint, bigint, bigint, bytea, int[], int[], bigint[], "
                f"bytea, int[], int[], int[], bigint[], bigint) AS {append}")


def append_of(mesh: int, revision: int, size: int) -> str:
    return (f"EXECUTE append({mesh}, 1, {revision}, {revision}, decode(repeat('ab', {size}), 'hex'),"
            f" '{{1}}', '{{{size}}}', '{{7}}', decode(repeat('cd', 80), 'hex'), '{{1}}', '{{20}}',"
            f" '{{60}}', '{{7}}', 0)")


def reading_of(mesh: int) -> str:
    """As postgres_reading.cc reads a mesh with a snapshot of one part and few entries."""
    def rows(query: str, count: int) -> str:
        fetch = f"FETCH {count} FROM rows;"
        return f"DECLARE rows NO SCROLL CURSOR FOR {query}; {fetch} {fetch} CLOSE rows;"

    where = f"WHERE mesh = {mesh}"
    return (
        "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY; SELECT convert_to(id, 'UTF8'), "
        f"description, checksum, snapshot, head FROM dynmesh.meshes WHERE key = {mesh};"
        + rows(f"SELECT number, checksum, id, answer FROM dynmesh.requests {where} ORDER BY number",
               2_048)
        + f"SELECT parts FROM dynmesh.generations {where} AND revision = 0;"
        + rows(f"SELECT part, checksum, data FROM dynmesh.snapshots {where} AND revision = 0 "
               "ORDER BY part", 8)
        + rows(f"SELECT revision, checksum, data FROM dynmesh.entries {where} AND revision > 0 "
               "ORDER BY revision", 8)
        + "ROLLBACK")


def measure(session: Session, meshes: int, nodes: int, repeats: int) -> list[list[object]]:
    rows: list[list[object]] = []

    def add(what: str, sqls: list[str]) -> None:
        session.ask(sqls[0])  # plans, caches
        milliseconds, size = session.cost(sqls[1:])
        rows.append([what, round(milliseconds, 4), round(size)])
        print(*rows[-1], sep="  ", flush=True)

    def renewals() -> list[str]:
        return [f"EXECUTE renew('node-{i}', 'node-{i}.example:7878', {LEASE})"
                for i in range(1, repeats + 2)]

    each = meshes // nodes
    add(f"renewal of {each:,} of {meshes:,} meshes, without the index", renewals())
    session.ask(statement("postgres_leases.cc", "kIndex"))
    session.ask("ANALYZE dynmesh.meshes")
    add(f"renewal of {each:,} meshes", renewals())
    for share in (10, 100):
        count = meshes // share
        session.ask(f"UPDATE dynmesh.meshes SET owner = 'large-{share}' WHERE key % {share} = 0")
        session.ask("VACUUM ANALYZE dynmesh.meshes")
        add(f"renewal of {count:,} meshes",
            [f"EXECUTE renew('large-{share}', 'l', {LEASE})"] * 4)
    add("renewal of a node's row", [f"EXECUTE seen('node-{i}')" for i in range(10 * repeats)])
    many = 20 * repeats
    add("claim", [f"EXECUTE claim({10 * i + 1}, 'node-{(10 * i + 1) % nodes}', {LEASE})"
                  for i in range(many)])
    add("places of one mesh", [f"EXECUTE locate('node-1', 'mesh-{7 * i + 1}')" for i in range(many)])
    add(f"list of {nodes:,} live nodes", [f"EXECUTE live({86_400_000_000})"] * (2 * repeats))
    # As if it could not be compressed.
    session.ask("ALTER TABLE dynmesh.snapshots ALTER data SET STORAGE EXTERNAL")
    session.ask("INSERT INTO dynmesh.snapshots SELECT n, 0, 0, 7, decode(repeat('5a', 28000), 'hex') "
                "FROM generate_series(11, 10000, 11) AS n")
    session.ask("ANALYZE dynmesh.snapshots")
    session.ask("INSERT INTO dynmesh.snapshots SELECT m, 0, n, 7, decode(repeat('5a', 936000), 'hex') "
                "FROM generate_series(7, 42, 7) AS m, generate_series(0, 2) AS n")
    add("reading of a mesh with 28 kB", [reading_of(11 * i) for i in range(1, many)])
    add("reading of a mesh with 2.8 MB", [reading_of(7 * i) for i in range(1, 7)])
    session.ask("UPDATE dynmesh.meshes SET epoch = 1 WHERE key < 10000")
    add("append of 150 bytes", [append_of(3, revision, 150) for revision in range(many)])
    return rows


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--meshes", type=int, default=1_000_000)
    parser.add_argument("--nodes", type=int, default=1_000)
    flags = parser.parse_args()
    meshes = 20_000 if flags.quick else flags.meshes
    nodes = 100 if flags.quick else flags.nodes
    folder = pathlib.Path(tempfile.mkdtemp(prefix="dynmesh-pg-", dir="/tmp"))
    shutil.chown(folder, "postgres", "postgres")
    try:
        run([PROGRAMS / "initdb", "-D", folder / "data", "-U", "postgres", "-A", "trust",
             "--no-sync", "--locale=C", "-E", "UTF8"])
        options = (f"-c listen_addresses= -k {folder} -c shared_buffers=512MB -c max_wal_size=8GB "
                   "-c autovacuum=off")
        run([PROGRAMS / "pg_ctl", "-D", folder / "data", "-w", "-l", folder / "log", "-o", options,
             "start"])
        try:
            session = Session(folder)
            fill(session, meshes, nodes)
            prepare(session)
            rows = measure(session, meshes, nodes, 3 if flags.quick else 9)
            rows.append(["memory of a connection, MB",
                         round(session.own_megabytes(), 1), 0])
            print(*rows[-1], sep="  ")
            write_csv(flags.out / "database_costs.csv", ["statement", "ms", "log bytes"], rows)
        finally:
            run([PROGRAMS / "pg_ctl", "-D", folder / "data", "-m", "immediate", "stop"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
