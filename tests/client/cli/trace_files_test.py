"""The files of `dynmesh replay --trace`: the graph is one that Graphviz reads, and says what the JSON says.

    trace_files_test.py DYNMESH
"""

import collections
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

DYNMESH = sys.argv[1]
HEADER = "mesh dim=2 box=0,0,1,1"
SCRIPT = HEADER + """
add point 1 0.3 0.4
add point 2 0.7 0.45
add point 3 0.5 0.8
add segment 4 1 2
commit
move point 3 0.5 0.6
commit
"""
COLORS = {"kept": "#eeeeee", "rerun": "#ffc266", "added": "#a6d9a0", "removed": "#f2a6a6"}
TOKEN = re.compile(r'\s*(?:("(?:[^"\\]|\\.)*")|(->)|([A-Za-z0-9_.#]+)|([{}\[\];=,]))')


class Graph:
    """What a text in Graphviz's language holds; the part of the language that is used here."""

    def __init__(self, text):
        self.tokens, at = [], 0
        text = text.rstrip()
        while at < len(text):
            match = TOKEN.match(text, at)
            if match is None:
                raise ValueError(f"no token: {text[at:at + 40]!r}")
            self.tokens.append(match[0].strip())
            at = match.end()
        self.next = 0
        self.nodes, self.edges, self.boxes = {}, [], []
        self.expect("digraph")
        self.take()
        self.statements(None)
        if self.next != len(self.tokens):
            raise ValueError("text after the graph")

    def take(self):
        self.next += 1
        return self.tokens[self.next - 1]

    def peek(self):
        return self.tokens[self.next]

    def expect(self, token):
        found = self.take()
        if found != token:
            raise ValueError(f"{found} instead of {token}")

    def statements(self, box):
        self.expect("{")
        while self.peek() != "}":
            name = self.take()
            if name == "subgraph":
                self.boxes.append(self.take())
                self.statements(self.boxes[-1])
                continue
            if self.peek() == "=":
                self.take()
                self.take()
            elif self.peek() == "->":
                self.take()
                self.edges.append((name, self.take(), self.attributes()))
            else:
                attributes = self.attributes()
                if name not in ("node", "edge"):
                    if name in self.nodes:
                        raise ValueError(f"two nodes {name}")
                    self.nodes[name] = {**attributes, "box": box}
            self.expect(";")
        self.expect("}")

    def attributes(self):
        found = {}
        if self.peek() != "[":
            return found
        self.take()
        while self.peek() != "]":
            key = self.take()
            self.expect("=")
            found[key] = self.take().strip('"')
            if self.peek() == ",":
                self.take()
        self.take()
        return found


def run(folder, *arguments):
    return subprocess.run([DYNMESH, "replay", "s.dynmesh", *arguments], cwd=folder, text=True,
                          capture_output=True, check=False, timeout=600)


class TraceFiles(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "s.dynmesh").write_text(SCRIPT)

    def trace(self, *arguments):
        done = run(self.folder, "--trace", "t.json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder / "t.json").read_text())

    def test_json_is_read_back_the_same(self):
        trace = self.trace()
        self.assertEqual(json.loads(json.dumps(trace)), trace)
        self.assertEqual(trace["dimension"], 2)
        fates = collections.Counter(o["fate"] for o in trace["operations"])
        self.assertEqual(set(fates), set(COLORS), "a moved point has all four")
        positions = [tuple(v["position"]) for v in trace["vertices"] if v["input"]]
        for position in ((0.3, 0.4), (0.7, 0.45), (0.5, 0.8), (0.5, 0.6)):
            self.assertIn(position, positions)
        for i, operation in enumerate(trace["operations"]):
            for v in operation["item"] + operation["reads"]:
                self.assertLess(v, len(trace["vertices"]))
            for request in operation["requests"]:
                self.assertTrue(i < request < len(trace["operations"]))
            self.assertEqual(operation["fate"] == "rerun",
                             "because" in operation or "because_of_input" in operation)

    def check_graph(self, operations):
        """The graph of the present script, against its operations."""
        self.assertEqual(run(self.folder, "--trace", "t.dot").returncode, 0)
        graph = Graph((self.folder / "t.dot").read_text())
        maker = {}
        for i, operation in enumerate(operations):
            for output in operation["made"] + operation.get("made_before", []):
                if output["what"] == "vertex":
                    maker.setdefault(output["vertices"][0], i)
        reads = [(maker[v], i) for i, operation in enumerate(operations)
                 for v in operation["reads"] if maker.get(v, i) != i]
        changed = {i for i, o in enumerate(operations) if o["fate"] != "kept"}
        drawn = changed | {made for made, i in reads if i in changed}
        drawn = drawn if changed else set(range(len(operations)))
        self.assertEqual(set(graph.nodes), {"input", *(f"o{i}" for i in drawn)})
        for i in drawn:
            node = graph.nodes[f"o{i}"]
            self.assertEqual(node["fillcolor"], COLORS[operations[i]["fate"]])
            self.assertTrue(node["label"].startswith(operations[i]["procedure"]))
        times = {i: (o["bucket"], o["round"], o.get("step")) for i, o in enumerate(operations)}
        self.assertEqual(len(graph.boxes), len({times[i] for i in drawn}))
        for i in drawn:
            self.assertEqual({times[k] for k in drawn
                              if graph.nodes[f"o{k}"]["box"] == graph.nodes[f"o{i}"]["box"]},
                             {times[i]})
        found = collections.defaultdict(list)
        for start, end, attributes in graph.edges:
            kind = attributes.get("style", "cause" if "penwidth" in attributes else "request")
            found[kind].append((start, end))

        def named(pairs):
            return sorted((f"o{a}", f"o{b}") for a, b in pairs if a in drawn and b in drawn)

        self.assertEqual(sorted(found["dotted"]), named(reads))
        self.assertEqual(sorted(found["request"]), named(
            (i, r) for i, o in enumerate(operations) for r in o["requests"]))
        self.assertEqual(sorted(found["cause"]), sorted(
            (f"o{o['because']}" if "because" in o else "input", f"o{i}")
            for i, o in enumerate(operations) if o["fate"] == "rerun"))
        return found

    def test_the_graph_says_what_the_json_says(self):
        found = self.check_graph(self.trace()["operations"])
        self.assertTrue(found["dotted"] and found["request"] and found["cause"])

    def test_a_script_without_revisions_has_a_trace(self):
        (self.folder / "s.dynmesh").write_text(HEADER + "\n")
        operations = self.trace()["operations"]
        self.assertEqual({o["fate"] for o in operations}, {"kept"})
        self.check_graph(operations)

    def test_a_trace_that_is_too_large_is_refused(self):
        done = run(self.folder, "--trace", "t.json", "--trace-limit", "10")
        self.assertEqual(done.returncode, 1)
        self.assertIn("--trace: the trace has more than 10 operations", done.stderr)
        self.assertIn("with --trace-limit", done.stderr)
        self.assertFalse((self.folder / "t.json").exists())

    def test_other_files_are_refused_before_the_first_revision(self):
        done = run(self.folder, "--trace", "t.svg")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn(".dot or .json", done.stderr)

    def test_quadtrees_have_none(self):
        (self.folder / "s.dynmesh").write_text(
            SCRIPT.replace(HEADER, HEADER + " kind=quadtree").replace("add segment 4 1 2\n", ""))
        done = run(self.folder, "--trace", "t.json")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("of kind delaunay: others have no trace", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
