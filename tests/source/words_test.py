"""Texts name things of the code: no sentence has "who" for one.

Looks at comments, messages and documents, that is, at whole files. What is about people, or quotes
data, stands in ALLOWED: the file and the words that the line has.
"""

import pathlib
import re
import subprocess
import sys

WORDS = re.compile(r"\b(who|whom|whoever|nobody|somebody|everybody|anybody)\b", re.IGNORECASE)
SUFFIXES = (".h", ".cc", ".py", ".md", ".proto", ".sh", ".conf", ".yml", ".yaml", ".txt", ".cmake")
SKIPPED = ("tests/fuzz/corpus/", "tests/fuzz/found/", "tests/source/")
ALLOWED = (
    ("LICENSE", "on behalf of whom"),
    ("tests/server/access/access_test.cc", '"# who'),  # a comment of a file of tokens
)


def texts(root: pathlib.Path) -> list[str]:
    """The files of the project that have texts, from the root."""
    listed = subprocess.run(
        ["git", "-C", str(root), "ls-files"], capture_output=True, text=True, check=False
    )
    if listed.returncode == 0:
        names = listed.stdout.split()
    else:  # an archive of the sources
        names = [str(p.relative_to(root)) for p in root.rglob("*") if p.is_file()]
        names = [n for n in names if not n.startswith("build")]
    scripts = [n for n in names if "." not in n.rsplit("/", 1)[-1]]
    return sorted(
        n
        for n in {*scripts, *(n for n in names if n.endswith(SUFFIXES))}
        if not n.startswith(SKIPPED) and (root / n).is_file()
    )


def problems(name: str, text: str) -> list[str]:
    """The lines of the text that have one of the words, with their places."""
    return [
        f"{name}:{number}: {line.strip()}"
        for number, line in enumerate(text.splitlines(), 1)
        if WORDS.search(line)
        and not any(name.startswith(where) and words in line for where, words in ALLOWED)
    ]


def main() -> int:
    """1 if a text has one of the words."""
    root = pathlib.Path(sys.argv[1])
    assert problems("a.h", "// The one\n// who is told\n") == ["a.h:2: // who is told"]
    assert not problems("a.h", "// whole, whose and who_\n")
    found = []
    for name in texts(root):
        found += problems(name, (root / name).read_text(encoding="utf-8", errors="replace"))
    print("\n".join(found) or "no text has one of the words")
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main())
