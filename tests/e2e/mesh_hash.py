#!/usr/bin/env python3
"""Ids and hash of meshes by the comment in mesh.proto alone: no package, no code of the project.

    mesh_hash.py PROTO              the two meshes of that comment, as it has them
    mesh_hash.py PROTO FILE...      and snapshots, as GetSnapshot sent them: SnapshotChunks, each after
                                    a byte 0 and its length in 4 bytes, big-endian, as gRPC frames them
Prints the hash of each; fails if a chunk, an id or a region says otherwise."""
import struct
import sys

M = (1 << 64) - 1


def mix_a(z):
    z = z + 0x9E3779B97F4A7C15 & M
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & M
    z = (z ^ z >> 27) * 0x94D049BB133111EB & M
    return z ^ z >> 31


def mix_b(z):
    z = z + 0xD1B54A32D192ED03 & M
    z = (z ^ z >> 33) * 0xFF51AFD7ED558CCD & M
    z = (z ^ z >> 33) * 0xC4CEB9FE1A85EC53 & M
    return z ^ z >> 33


def chain(h, words):
    for w in words:
        h = mix_a(h ^ w)
    return h


def words_hash(words):
    lo = 0x589965CC75374CC3
    for w in words:
        lo = mix_b(lo ^ w)
    return chain(0x8EBC6AF09C88C6E3, words), lo


def bits(x):
    return struct.unpack("<Q", struct.pack("<d", x + 0.0))[0]


def vertex_id(xs, salt=0):
    return chain(mix_a(0xA0761D6478BD642F ^ salt), map(bits, xs)) or 1


def region_id(polygons):
    return polygons[0] if len(polygons) == 1 else chain(mix_a(0xE7037ED1A0B428DB), polygons) | 1 << 63


def mesh_hash(vertices, simplices, subsegments, subfacets):
    """Rows: (coordinates, containing dimension, owner), (ids, region), (ids, owner), (ids, owner)."""
    rows = [words_hash([1, len(xs), *map(bits, xs), cd, owner]) for xs, cd, owner in vertices]
    rows += [words_hash([2, len(ids), *ids] + [r] * (r != 0)) for ids, r in simplices]
    rows += [words_hash([3, *sorted(ids), owner]) for ids, owner in subsegments]
    rows += [words_hash([4, *sorted(ids), owner]) for ids, owner in subfacets]
    return "%016x%016x" % tuple(sum(column) & M for column in zip(*rows))


# ---- a snapshot's bytes: just enough of protobuf -------------------------------------------------
def varint(data, at):
    value = shift = 0
    while True:
        value |= (data[at] & 127) << shift
        at, shift = at + 1, shift + 7
        if data[at - 1] < 128:
            return value, at


def fields(data):
    """By number: a list of the values, a number (of varints) or bytes."""
    found, at = {}, 0
    while at < len(data):
        key, at = varint(data, at)
        value, start = varint(data, at)
        if key & 7 == 0:
            at = start
        elif key & 7 == 1:
            value, at = data[at:at + 8], at + 8
        else:
            value, at = data[start:start + value], start + value
        found.setdefault(key >> 3, []).append(value)
    return found


def column(message, number, kind):
    """A packed column: "Q" or "d" of 8 bytes each, "v" of varints."""
    data, values, at = b"".join(message.get(number, [])), [], 0
    if kind != "v":
        return list(struct.unpack("<%d%s" % (len(data) // 8, kind), data))
    while at < len(data):
        value, at = varint(data, at)
        values.append(value)
    return values


def rows(flat, n):
    return [tuple(flat[i:i + n]) for i in range(0, len(flat), n)]


def read(data):
    """The mesh, in the form for mesh_hash, and the hash in the last chunk."""
    mesh, told, at = ([], [], [], []), "", 0
    while at < len(data):
        size = struct.unpack(">I", data[at + 1:at + 5])[0]
        chunk, at = fields(data[at + 5:at + 5 + size]), at + 5 + size
        part = lambda number: fields(b"".join(chunk.get(number, [])))
        d = chunk[1][0]
        v, s, e, f = part(4), part(5), part(6), part(12)
        places = rows(column(v, 2, "d"), d)
        mesh[0].extend(zip(places, b"".join(v.get(3, [])), column(v, 4, "v")))
        # If two vertices would have the same id, one has the next salt.
        for vertex, xs in zip(column(v, 1, "Q"), places):
            assert vertex in (vertex_id(xs), vertex_id(xs, 1)), "id %x is not that of %s" % (vertex, xs)
        for region in map(fields, s.get(3, [])):
            assert column(region, 1, "Q") == [region_id(column(region, 2, "v"))], "a region's id"
        ids = rows(column(s, 1, "Q"), d + 1)
        mesh[1].extend(zip(ids, column(s, 2, "Q") or [0] * len(ids)))
        mesh[2].extend(zip(rows(column(e, 1, "Q"), 2), column(e, 2, "v")))
        mesh[3].extend(zip(rows(column(f, 1, "Q"), 3), column(f, 2, "v")))
        told = b"".join(chunk.get(8, [])).decode()
    return mesh, told


# ---- the meshes of mesh.proto -----------------------------------------------------------------------
def plane():
    a, b, c, d = points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, -0.0)]
    v = {p: vertex_id(p) for p in points}
    return ([(a, 0, 1), (b, 0, 2), (c, 0, 3), (d, 1, 4)],
            [(least_first(v[a], v[d], v[c]), region_id([7, 9])), (least_first(v[d], v[b], v[c]), 7)],
            [((v[a], v[d]), 4), ((v[d], v[b]), 4)], [])


def space():
    a, b, c, d, e = points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0),
                              (0.25, 0.25, -1.5)]
    v = {p: vertex_id(p) for p in points}
    return ([(a, 0, 1), (b, 0, 2), (c, 0, 3), (d, 0, 4), (e, 3, 0)],
            [(canonical(v[a], v[b], v[c], v[d]), 20), (canonical(v[a], v[c], v[b], v[e]), 0)],
            [((v[a], v[b]), 20), ((v[b], v[c]), 20), ((v[c], v[a]), 20)], [((v[a], v[b], v[c]), 20)])


def least_first(*ids):
    at = ids.index(min(ids))
    return ids[at:] + ids[:at]


def canonical(*ids):
    """Of a tetrahedron: the least first, the next least second; the other two by the sign."""
    ids, even = list(ids), True
    for to in (0, 1):
        at = ids.index(min(ids[to:]))
        if at != to:
            ids[to], ids[at], even = ids[at], ids[to], not even
    return tuple(ids if even else ids[:2] + ids[:1:-1])


def main(proto, *files):
    text = open(proto).read()
    for name, mesh in (("plane", plane()), ("space", space())):
        mine = mesh_hash(*mesh)
        assert mine in text, "%s does not say %s of its mesh in %s" % (proto, mine, name)
        print(mine, name)
    for file in files:
        mesh, told = read(open(file, "rb").read())
        mine = mesh_hash(*mesh)
        assert mine == told, "%s: %s is not %s" % (file, mine, told)
        print(mine, *map(len, mesh))


if __name__ == "__main__":
    main(*sys.argv[1:])
