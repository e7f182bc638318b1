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


def comment_block(lines, at):
    """The comment whose first line is `at`, converted, and the line behind it."""
    end = at
    while end < len(lines) and ALONE.match(lines[end]):
        end += 1
    belongs = at == 0 or (end < len(lines) and lines[end].strip() != "")
    if not belongs:
        return lines[at:end], end
    indent = lines[at][: len(lines[at]) - len(lines[at].lstrip())]
    return marked([ALONE.match(line)["text"] for line in lines[at:end]], indent), end


def trailing_comment(lines, at, found):
    """The same for one that begins behind code; it may go on below itself."""
    out = [f"{found['code']}{found['gap']}///<{found['text']}"]
    column = len(found["code"]) + len(found["gap"])
    at += 1
    while at < len(lines) and ALONE.match(lines[at]) and lines[at].index("//") == column:
        out.append(" " * column + "///<" + ALONE.match(lines[at])["text"])
        at += 1
    return out, at


def convert(source):
    lines = source.split("\n")
    out = []
    at = 0
    told = False  # by a comment right above
    if ALONE.match(lines[0]):
        out.append("/// @file")
        # Messages name lines: an empty one below makes up for it.
        empty = next((i for i, line in enumerate(lines) if not line), None)
        if empty is not None:
            del lines[empty]
    while at < len(lines):
        line = lines[at]
        trailing = TRAILING.match(line)
        above, told = told, False
        if ALONE.match(line):
            block, at = comment_block(lines, at)
            out.extend(block)
            told = True
        elif trailing and not SILENT.match(line):
            block, at = trailing_comment(lines, at, trailing)
            out.extend(block)
        else:
            out.append("" if SELF_EVIDENT.match(line) and not above else line)
            at += 1
    return "\n".join(out)


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as header:
        print(convert(header.read()), end="")
