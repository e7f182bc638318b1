#!/usr/bin/env python3
"""Writes the files of a folder into a C++ source, as the server's WebPage().

    embed.py OUT.cc [FOLDER]      without FOLDER: a program without a page
"""
import hashlib
import pathlib
import sys

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".woff2": "font/woff2",
    ".txt": "text/plain; charset=utf-8",
}

HEAD = """// Made by client/web/embed.py.
#include "server/http/static_files.h"

namespace dynmesh::server {
"""

TAIL = """
}  // namespace dynmesh::server
"""


def literal(data):
    """A literal of C++ with these bytes."""
    # Octal digits end after three, so what follows is never part of an escape.
    escaped = [
        chr(b) if 32 <= b < 127 and b not in b'"\\?' else f"\\{b:03o}" for b in data
    ]
    lines = ["".join(escaped[i : i + 4096]) for i in range(0, len(escaped), 4096)]
    return "\n".join(f'"{line}"' for line in lines or [""])


def source(files):
    """The C++ source for pairs of a path, from the root, and its bytes."""
    text = [HEAD]
    for i, (_, data) in enumerate(files):
        text.append(f"static constexpr char kFile{i}[] =\n{literal(data)};\n")
    text.append("absl::Span<const StaticFile> WebPage() {")
    if not files:
        text.append("  return {};")
    else:
        text.append("  static constexpr StaticFile kFiles[] = {")
        for i, (path, data) in enumerate(files):
            kind = TYPES[pathlib.PurePosixPath(path).suffix]
            tag = hashlib.sha256(data).hexdigest()[:16]
            text.append(
                f'      {{"{path}", "{kind}", "{tag}", {{kFile{i}, sizeof(kFile{i}) - 1}}}},'
            )
        text.append("  };\n  return kFiles;")
    text.append("}")
    return "\n".join(text) + TAIL


def main(out, folder=None):
    root = pathlib.Path(folder) if folder else None
    files = sorted(
        ("/" + path.relative_to(root).as_posix(), path.read_bytes())
        for path in (root.rglob("*") if root else [])
        if path.is_file()
    )
    if root and not any(path == "/index.html" for path, _ in files):
        sys.exit(f"{folder} has no index.html")
    pathlib.Path(out).write_text(source(files), encoding="ascii")


if __name__ == "__main__":
    main(*sys.argv[1:])
