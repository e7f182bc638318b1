"""RESULTS.md: remesh_table.py writes the page; others write a section each, between markers."""
from __future__ import annotations

import pathlib
import re

_SECTION = re.compile(r"<!-- (\S+): begin -->\n.*?<!-- \1: end -->\n", re.DOTALL)


def _read(path: pathlib.Path) -> str:
    return path.read_text(encoding="utf-8") if path.exists() else ""


def sections_of(path: pathlib.Path) -> str:
    """All sections with their markers; nothing if there is none."""
    return "\n".join(match.group() for match in _SECTION.finditer(_read(path)))


def put_section(path: pathlib.Path, name: str, section: str) -> None:
    """Replaces the section `name`, or appends it."""
    marked = f"<!-- {name}: begin -->\n{section}<!-- {name}: end -->\n"
    text = _read(path)
    for match in _SECTION.finditer(text):
        if match.group(1) == name:
            path.write_text(text[:match.start()] + marked + text[match.end():], encoding="utf-8")
            return
    path.write_text(text + ("\n" if text else "") + marked, encoding="utf-8")
