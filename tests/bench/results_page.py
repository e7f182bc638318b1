"""RESULTS.md: remesh_table.py writes the page, dihedral_table.py a section of it, between markers."""
from __future__ import annotations

import pathlib

_BEGIN, _END = "<!-- dihedral_table.py: begin -->\n", "<!-- dihedral_table.py: end -->\n"


def _split(path: pathlib.Path) -> tuple[str, str, str]:
    """What stands before the section, the section with its markers, and what stands behind."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    if _BEGIN not in text:
        return text + "\n" if text else "", "", ""
    head, rest = text.split(_BEGIN, 1)
    section, tail = rest.split(_END, 1)
    return head, _BEGIN + section + _END, tail


def section_of(path: pathlib.Path) -> str:
    """The section with its markers; nothing if there is none."""
    return _split(path)[1]


def put_section(path: pathlib.Path, section: str) -> None:
    head, _, tail = _split(path)
    path.write_text(f"{head}{_BEGIN}{section}{_END}{tail}", encoding="utf-8")
