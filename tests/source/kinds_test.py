"""Code that has not heard of a new kind of feature does not compile.

    kinds_test.py SOURCE CXX

Two things make it so. Core, server, client and proto tell kinds apart by core/base/feature_kinds.h
or by a switch without `default`; a comparison is found here. And the compiler refuses a visit, a
question or a table that leaves a kind out; it is asked here.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

ROOTS = ("core", "server", "client", "proto")
HOMES = ("core/include/dynmesh/feature.h", "core/base/feature_kinds.h")
NAMED = re.compile(r"(\S+ )?(FeatureKind::k\w+|&Feature::kind)")
ALLOWED = re.compile(r"(case|=) FeatureKind::k\w+")
SWITCH = re.compile(r"\bswitch \(")
ADVICE = "use core/base/feature_kinds.h"

PROBE = """
#include "core/base/feature_kinds.h"
namespace dynmesh {
int Count(const Feature& f) {
  int n = 0;
  CODE
  return n;
}
}  // namespace dynmesh
"""
COMPLETE = (
    "Visit(f, [&](const ASegment&) { ++n; }, [&](const APolygon&) {}, Ignore<APoint, ASize>);",
    "if (Is<ASegment, APolygon>(f, Not<APoint, ASize>)) ++n;",
    "static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);",
)
# What is refused, and with which words.
FORGETFUL = (
    ("Visit(f, [&](const ASegment&) {}, [&](const APolygon&) {}, Ignore<APoint>);", "match"),
    ("Visit(f, [&](const APoint&) { ++n; }, [&](const auto&) {});", "would hide a new one"),
    ("if (Is<APolygon>(f, Not<APoint, ASegment>)) ++n;", "whether it is meant"),
    ("if (Is<APolygon>(f, Not<APoint, ASegment, APoint>)) ++n;", "whether it is meant"),
    ("static_assert(kAreAllKinds<APoint, ASegment, APolygon>);", "static assertion failed"),
    ("switch (f.kind) { case FeatureKind::kPoint: ++n; }", "not handled in switch"),
)


def block(text: str, start: int) -> str:
    """The block in braces that begins at or after `start`."""
    depth, begin = 0, text.find("{", start)
    for i in range(max(begin, 0), len(text)):
        depth += {"{": 1, "}": -1}.get(text[i], 0)
        if depth == 0:
            return text[begin : i + 1]
    return text[start:]


def problems(name: str, text: str) -> list[str]:
    """Comparisons of kinds, and switches with a default, with their places."""
    found = []
    if name in HOMES:
        return found
    code = re.sub(r"//[^\n]*", "", text)
    for number, line in enumerate(code.splitlines(), 1):
        if any(not ALLOWED.fullmatch(match[0]) for match in NAMED.finditer(line)):
            found.append(f"{name}:{number}: {line.strip()} ({ADVICE})")
    for match in SWITCH.finditer(code):
        body = block(code, match.end())
        if "case FeatureKind::" in body and "default:" in body:
            number = code.count("\n", 0, match.start()) + 1
            found.append(f"{name}:{number}: a default hides a new kind of feature")
    return found


def check_the_check() -> None:
    """Comparisons are noticed."""
    assert problems("a.cc", "\nif (f.kind == FeatureKind::kSize) {}") == [
        f"a.cc:2: if (f.kind == FeatureKind::kSize) {{}} ({ADVICE})"
    ]
    assert problems("a.cc", "if (FeatureKind::kSize != f.kind) {}")
    assert problems("a.cc", "std::ranges::count(features, x, &Feature::kind)")
    switch = "switch (f.kind) { case FeatureKind::kSize: { break; }"
    assert not problems("a.cc", switch + "} f.kind = FeatureKind::kPoint; default:")
    assert problems("a.cc", switch + " default: break; }") == [
        "a.cc:1: a default hides a new kind of feature"
    ]


def refused(cxx: str, root: pathlib.Path, code: str) -> str:
    """What the compiler has against the code, in a function; empty: nothing."""
    with tempfile.NamedTemporaryFile("w", suffix=".cc", encoding="utf-8") as file:
        file.write(PROBE.replace("CODE", code))
        file.flush()
        command = [cxx, "-std=c++20", "-Wall", "-Werror", "-fsyntax-only"]
        command += [f"-I{root}", f"-I{root}/core/include", file.name]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode else ""


def main() -> int:
    """1 if a new kind would not be noticed."""
    root, cxx = pathlib.Path(sys.argv[1]), sys.argv[2]
    check_the_check()
    found = [
        problem
        for top in ROOTS
        for path in sorted((root / top).rglob("*"))
        if path.suffix in (".h", ".cc")
        for problem in problems(str(path.relative_to(root)), path.read_text(encoding="utf-8"))
    ]
    if said := refused(cxx, root, "\n  ".join(COMPLETE)):
        found.append(f"refused: {said}")
    found += [
        f"not refused: {code}" for code, word in FORGETFUL if word not in refused(cxx, root, code)
    ]
    print("\n".join(found) or "a new kind of feature is a list of compile errors")
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main())
