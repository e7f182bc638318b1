"""What the tests of deployment share: where things are, and strict reading of them."""

import functools
import pathlib
import re
import subprocess
import sys
import tomllib

import yaml

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEPLOY = SOURCE / "deploy"
DAEMON = pathlib.Path(sys.argv[1])


class StrictLoader(yaml.SafeLoader):
    """Refuses a key that is given twice, of which YAML would silently keep the last."""


def strict_mapping(loader, node, deep=False):
    seen = set()
    for key_node, _ in node.value:
        if key_node.tag == "tag:yaml.org,2002:merge":
            continue  # what it brings may be given again
        key = loader.construct_object(key_node, deep=True)
        if key in seen:
            raise yaml.YAMLError(f"{key!r} is given twice{key_node.start_mark}")
        seen.add(key)
    return yaml.SafeLoader.construct_mapping(loader, node, deep=True)


StrictLoader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, strict_mapping)


def load_all(path):
    return list(yaml.load_all(path.read_text(), StrictLoader))


@functools.cache
def flags_of_daemon():
    text = subprocess.run([DAEMON, "--help"], capture_output=True, text=True, check=True,
                          timeout=60).stdout
    return set(re.findall(r"(--[a-z][a-z-]*)", text))


def flags_in(words):
    return {word.split("=")[0] for word in words if word.startswith("--")}


def drain_seconds():
    """What dynmeshd takes at most, by default, to end."""
    time = tomllib.loads((DEPLOY / "dynmeshd.conf").read_text())["drain-timeout"]
    return int(time.removesuffix("s"))
