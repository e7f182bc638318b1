"""What the machine's own apt knows about where Debian's packages come from."""

import pathlib
import re
import subprocess

_CODE_NAMES = {"12": "bookworm"}  # of the releases an image may start from


class AptError(Exception):
    pass


def suite_of(image):
    """The suite of an official image of Debian: `debian:12` or `debian:12-slim`."""
    found = re.fullmatch(r"debian:(\w+)(-slim)?", image)
    if not found or found[1] not in _CODE_NAMES:
        raise AptError(f"no way to make {image}; known: debian:{', '.join(_CODE_NAMES)}")
    return _CODE_NAMES[found[1]]


def sources(suite, folder=pathlib.Path("/etc/apt")):
    """Lines `deb URI SUITE COMPONENT...` for the suite, its updates and its security fixes, the
    suite's first. Other archives that the machine has are left out: an image has Debian's only."""
    suites = (suite, f"{suite}-updates", f"{suite}-security")
    files = [folder / "sources.list", *sorted((folder / "sources.list.d").glob("*"))]
    found = []
    for file in files:
        if file.suffix == ".list" and file.is_file():
            found += _lines(file.read_text())
        elif file.suffix == ".sources":
            found += _stanzas(file.read_text())
    lines = sorted(
        {
            (suites.index(name), f"deb {uri} {name} {' '.join(components)}")
            for uri, name, components in found
            if name in suites
        }
    )
    if not lines or lines[0][0] != 0:
        raise AptError(f"the machine's apt has no archive of {suite} in {folder}")
    return [line for _, line in lines]


def _lines(text):
    for line in text.splitlines():
        line = re.sub(r"\[[^\]]*\]|#.*", " ", line)
        if (words := line.split())[:1] == ["deb"]:
            yield words[1], words[2], words[3:]


def _stanzas(text):
    for stanza in re.split(r"\n\s*\n", re.sub(r"^#.*\n", "", text, flags=re.M)):
        # A line that begins with a blank goes on with the one before.
        fields = dict(re.findall(r"^([\w-]+):((?:.*)(?:\n[ \t].*)*)", stanza, re.M))
        fields = {key.lower(): value.split() for key, value in fields.items()}
        if "deb" not in fields.get("types", ()) or fields.get("enabled") == ["no"]:
            continue
        for uri in fields["uris"]:
            for suite in fields["suites"]:
                yield uri, suite, fields.get("components", [])


def settings():
    """How to reach the archives: proxies, and whether their dates count. Lines of apt.conf."""
    dump = subprocess.run(["apt-config", "dump"], capture_output=True, text=True, check=True,
                          timeout=60).stdout
    wanted = r'Acquire::(\w+::Proxy(::\S+)?|Check-Valid-Until|Check-Date) "[^"]+";'
    return [line for line in dump.splitlines() if re.fullmatch(wanted, line)]


def proxy():
    """The proxy of apt for HTTP, for programs that do not ask apt; None if it has none."""
    for line in settings():
        if found := re.fullmatch(r'Acquire::http::Proxy "([^"]+)";', line):
            return None if found[1] == "DIRECT" else found[1]
    return None
