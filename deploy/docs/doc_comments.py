#!/usr/bin/python3
"""Doxygen's input filter: prints a header with its plain comments as Doxygen's.

A comment right above a declaration is that declaration's, one after it on the line too, and the
one at the top is the file's. Comments with an empty line below them stay plain. In the project's
style all of them are `//`, and stay so in the sources.
"""
import re
import sys

# A comment that ends a line of code. None of the headers has // in a string.
TRAILING = re.compile(r"^(?P<code>.*\S)(?P<gap> *)//(?P<text>.*)$")
ALONE = re.compile(r"^ *//(?P<text>.*)$")
LIST_ITEM = re.compile(r"^\s+(?:\d+\.|\*)\s+\S")
# What the language says of itself: comparison by members, copies and moves, without a comment.
SELF_EVIDENT = re.compile(
    r"^ *(?:friend bool operator==\(const (?P<a>\w+)&, const (?P=a)&\) = default;"
    r"|(?P<b>\w+)\((?:const (?P=b)&|(?P=b)&&)(?: \w+)?\)(?: noexcept)?;"
    r"|(?P<c>\w+)& operator=\((?:(?P=c)|const (?P=c)&|(?P=c)&&)(?: \w+)?\)(?: noexcept)?;)$")
# Lines of code that nothing is said of.
SILENT = re.compile(r"^\s*(?:#|$|public:|private:|protected:|[{}]|namespace\b|template\b)")


def marked(lines, indent):
    """The lines of a comment as Doxygen's.

    What is indented by three is code, unless a list's item begins it; Markdown wants four more.
    """
    out = []
    listed = False
    for text in lines:
        if not text.startswith("   "):
            listed = False
        elif LIST_ITEM.match(text):
            listed = True
        code = text.startswith("   ") and not listed
        out.append(f"{indent}///{'    ' if code else ''}{text}")
    return out


def convert(source):
    lines = source.split("\n")
    out = []
    at = 0
    while at < len(lines):
        line = lines[at]
        alone = ALONE.match(line)
        if alone:
            end = at
            while end < len(lines) and ALONE.match(lines[end]):
                end += 1
            texts = [ALONE.match(row)["text"] for row in lines[at:end]]
            indent = line[: len(line) - len(line.lstrip())]
            if at == 0:
                out.append("/// @file")
                out.extend(marked(texts, indent))
            elif end < len(lines) and lines[end].strip():
                out.extend(marked(texts, indent))
            else:
                out.extend(lines[at:end])
            at = end
            continue
        if SELF_EVIDENT.match(line) and not (at > 0 and ALONE.match(lines[at - 1])):
            out.append("")  # line numbers stay
            at += 1
            continue
        trailing = TRAILING.match(line)
        if trailing and not SILENT.match(line):
            out.append(f"{trailing['code']}{trailing['gap']}///<{trailing['text']}")
            column = line.index("//", len(trailing["code"]))
            at += 1
            # The comment goes on below itself.
            while at < len(lines) and ALONE.match(lines[at]) and lines[at].index("//") == column:
                out.append(" " * column + "///<" + ALONE.match(lines[at])["text"])
                at += 1
            continue
        out.append(line)
        at += 1
    return "\n".join(out)


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as header:
        print(convert(header.read()), end="")
