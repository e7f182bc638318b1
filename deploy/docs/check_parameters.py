#!/usr/bin/python3
"""Every parameter of a function is named in its comment.

    check_parameters.py FOLDER      of Doxygen's XML

Comments are prose: Doxygen's own check asks for a @param each. Prints what is missing, as a compiler
does, and ends with 1 then.
"""
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree


def missing(member):
    """Names of the parameters that the comment does not have."""
    text = " ".join(
        word for part in ("briefdescription", "detaileddescription")
        for word in member.find(part).itertext())
    named = set(re.findall(r"\w+", text))
    names = [parameter.findtext("declname") or parameter.findtext("defname")
             for parameter in member.iter("param")]
    return [name for name in names if name and name not in named]


def main():
    wrong = 0
    seen = set()
    for file in sorted(pathlib.Path(sys.argv[1]).glob("*.xml")):
        for member in ElementTree.parse(file).iter("memberdef"):
            if member.get("kind") not in ("function", "define") or member.get("id") in seen:
                continue
            seen.add(member.get("id"))
            if member.get("prot") == "private" or "operator" in member.findtext("name"):
                continue
            where = member.find("location")
            for name in missing(member):
                wrong += 1
                print(f"{where.get('file')}:{where.get('line')}: error: the comment of "
                      f"{member.findtext('name')} does not name its parameter {name}",
                      file=sys.stderr)
    if not seen:
        print(f"{sys.argv[1]}: error: no function", file=sys.stderr)
    sys.exit(1 if wrong or not seen else 0)


if __name__ == "__main__":
    main()
