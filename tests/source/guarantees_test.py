#!/usr/bin/env python3
"""Every promise of docs/guarantees.md names tests that exist, in the file that its link leads to.

    guarantees_test.py ROOT
"""
import pathlib
import re
import sys

LINK = re.compile(r"\[`(\w+)\.(\w+)`\]\(\.\./([\w./]+)\)")
CASE = r"\b(?:TYPED_)?TEST(?:_F|_P)?\(\s*{}\s*,\s*{}\s*\)"


def faults(root):
    """Texts that say what is wrong."""
    lines = (root / "docs/guarantees.md").read_text(encoding="utf-8").splitlines()
    seen = 0
    for line in lines:
        links = LINK.findall(line)
        is_row = line.startswith("| ") and not line.startswith("| promise")
        if is_row and not links:
            yield f"no test: {line}"
        seen += is_row
        for suite, name, path in links:
            file = root / path
            if not file.is_file():
                yield f"{suite}.{name}: there is no {path}"
            elif not re.search(CASE.format(suite, name), file.read_text(encoding="utf-8")):
                yield f"{suite}.{name}: {path} has no such test"
        for link in re.findall(r"\]\(([^)]*)\)", line):
            if not link.startswith("http") and not (root / "docs" / link.split("#")[0]).exists():
                yield f"there is no {link}"
    if seen < 10:
        yield "docs/guarantees.md has no rows"


def main(root):
    found = list(faults(pathlib.Path(root)))
    for text in found:
        print(text, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
