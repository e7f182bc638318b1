"""Reads a Dockerfile and a .dockerignore, strictly: an unknown instruction is an error that names
the line, never skipped, so that a build from the result builds the whole image.

Known: FROM AS, WORKDIR, COPY (--from), RUN, USER, VOLUME, EXPOSE, ENTRYPOINT, CMD, HEALTHCHECK, in
shell and JSON form; comments, lines that are continued. Refused: every other instruction and flag,
variables outside of commands, wildcards, heredocs, parser directives, anything given twice.
"""

import dataclasses
import json
import re


class DockerfileError(Exception):
    pass


@dataclasses.dataclass(frozen=True)
class Copy:
    sources: tuple
    destination: str
    stage: str | None  # the stage it comes from; None: the sources


@dataclasses.dataclass(frozen=True)
class Run:
    command: tuple


@dataclasses.dataclass(frozen=True)
class WorkDir:
    path: str


@dataclasses.dataclass(frozen=True)
class HealthCheck:
    command: tuple
    interval: float  # seconds, as all that follow
    timeout: float
    start_period: float


@dataclasses.dataclass
class Stage:
    base: str
    name: str | None
    steps: list = dataclasses.field(default_factory=list)  # Copy, Run and WorkDir, in order
    user: str | None = None
    volumes: tuple = ()
    ports: tuple = ()
    entrypoint: tuple = ()
    command: tuple = ()
    health: HealthCheck | None = None


def parse(text):
    """The stages, in order."""
    stages = []
    for line, name, value in _instructions(text):
        try:
            _take(stages, name, value)
        except DockerfileError as error:
            raise DockerfileError(f"line {line}, {name}: {error}") from None
    if not stages:
        raise DockerfileError("no FROM")
    return stages


def _instructions(text):
    """Line, name and value of each, continued lines joined as Docker does: by nothing."""
    joined, first, seen = "", 0, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("#"):  # within a continued line, too
            if not seen and re.match(r"\s*#\s*[a-zA-Z]+\s*=", line):
                raise DockerfileError(f"line {number}: a parser directive")
            continue
        if not line.strip():
            if joined:
                raise DockerfileError(f"line {number}: empty, in a line that is continued")
            continue
        seen = True
        first = first if joined else number
        joined += line
        if re.search(r"\\[ \t]*$", joined):
            joined = re.sub(r"\\[ \t]*$", "", joined)
            continue
        name, _, value = joined.strip().partition(" ")
        yield first, name, value.strip()
        joined = ""
    if joined:
        raise DockerfileError(f"line {first}: continued, and then the file ends")


def _take(stages, name, value):
    if name == "FROM":
        stages.append(_from(value, {stage.name for stage in stages}))
        return
    if name not in _READERS:
        raise DockerfileError("not known")
    if not stages:
        raise DockerfileError("before the first FROM")
    if not value:
        raise DockerfileError("of nothing")
    field, read = _READERS[name]
    stage = stages[-1]
    if field == "steps":
        if stage.user is not None:
            raise DockerfileError("after USER")
        stage.steps.append(read(value, {earlier.name for earlier in stages[:-1]}))
    elif getattr(stage, field):
        raise DockerfileError("a second time")
    else:
        setattr(stage, field, read(value))


def _plain_words(value):
    """Words without substitution or expansion by Docker."""
    words = value.split()
    for word in words:
        if re.search(r"[$*?\[\]\"'\\]|<<", word):
            raise DockerfileError(f"{word!r}: no variables, wildcards, quotes or heredocs")
    return words


def _from(value, names):
    words = _plain_words(value)
    if len(words) == 1:
        return Stage(words[0], None)
    if len(words) != 3 or words[1].upper() != "AS":
        raise DockerfileError(f"{value!r} is not IMAGE [AS NAME]")
    if words[2] in names:
        raise DockerfileError(f"a second stage {words[2]!r}")
    return Stage(words[0], words[2])


def _copy(value, names):
    words, stage = _plain_words(value), None
    while words and words[0].startswith("--"):
        flag, _, stage_of_flag = words.pop(0).partition("=")
        if flag != "--from" or stage is not None:
            raise DockerfileError(f"flag {flag!r}")
        stage = stage_of_flag
        if stage not in names:
            raise DockerfileError(f"no stage {stage!r} before")
    if len(words) < 2:
        raise DockerfileError(f"{value!r} is not SOURCE... DESTINATION")
    *sources, destination = words
    if len(sources) > 1 and not destination.endswith("/"):
        raise DockerfileError(f"of many to {destination!r}, which is no folder")
    for source in sources:
        if ".." in source.split("/"):
            raise DockerfileError(f"from outside, {source!r}")
    return Copy(tuple(sources), destination, stage)


def _run(value, _):
    if value.startswith("--"):
        raise DockerfileError(f"flag {value.split()[0]!r}")
    if re.search(r"(?<!<)<<(?!<)", value):
        raise DockerfileError("a heredoc")
    return Run(_command(value))


def _work_dir(value, _):
    (path,) = _plain_words(value)
    if not path.startswith("/"):
        raise DockerfileError(f"{path!r} is relative")
    return WorkDir(path)


def _command(value):
    """JSON form or, through a shell, the shell form. Invalid JSON is an error here; Docker would
    give it to the shell."""
    if not value.startswith("["):
        return ("/bin/sh", "-c", value)
    try:
        words = json.loads(value)
    except json.JSONDecodeError as error:
        raise DockerfileError(f"JSON: {error}") from None
    if not words or not all(isinstance(word, str) for word in words):
        raise DockerfileError("JSON of other than words")
    return tuple(words)


def _user(value):
    (user,) = _plain_words(value)
    return user


def _volumes(value):
    words = tuple(_command(value)) if value.startswith("[") else tuple(_plain_words(value))
    if not all(word.startswith("/") for word in words):
        raise DockerfileError(f"{value!r} is relative")
    return words


def _ports(value):
    words = _plain_words(value)
    if not all(word.isdigit() for word in words):
        raise DockerfileError(f"{value!r} are not numbers of TCP ports")
    return tuple(int(word) for word in words)


def _seconds(text):
    found = re.fullmatch(r"(\d+)(ms|s|m|h)", text)
    if not found:
        raise DockerfileError(f"{text!r} is no time")
    return int(found[1]) * {"ms": 0.001, "s": 1, "m": 60, "h": 3600}[found[2]]


def _health(value):
    times = {"--interval": 30, "--timeout": 30, "--start-period": 0}  # Docker's defaults
    while value.startswith("--"):
        flag, _, value = value.partition(" ")
        name, _, time = flag.partition("=")
        if name not in times:
            raise DockerfileError(f"flag {name!r}")
        times[name] = _seconds(time)
        value = value.strip()
    name, _, value = value.partition(" ")
    if name != "CMD" or not value.strip():
        raise DockerfileError("without CMD")
    return HealthCheck(_command(value.strip()), *times.values())


_READERS = {
    "WORKDIR": ("steps", _work_dir),
    "COPY": ("steps", _copy),
    "RUN": ("steps", _run),
    "USER": ("user", _user),
    "VOLUME": ("volumes", _volumes),
    "EXPOSE": ("ports", _ports),
    "ENTRYPOINT": ("entrypoint", _command),
    "CMD": ("command", _command),
    "HEALTHCHECK": ("health", _health),
}


def read_ignore(text):
    """A function that returns whether a .dockerignore excludes a path of the sources."""
    rules = []
    for line in text.splitlines():
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        negated = line.startswith("!")
        pattern = line.removeprefix("!").strip().strip("/")
        # Everything in a matching folder matches.
        rules.append((re.compile(_ignore_pattern(pattern) + r"(/.*)?"), negated))

    def ignored(path):
        answer = False
        for pattern, negated in rules:  # the last that matches decides
            if pattern.fullmatch(path):
                answer = not negated
        return answer

    return ignored


def _ignore_pattern(pattern):
    """As a regular expression: ** is any number of folders; *, ? and [...] stay within one name."""
    out = ""
    for token in re.findall(r"\*\*/|\*\*|\*|\?|\[[^\]]*\]|.", pattern):
        known = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
        if token in known:
            out += known[token]
        else:
            out += token if token.startswith("[") and len(token) > 1 else re.escape(token)
    return out
