"""The API reference is made, and what is not documented is an error.

    reference_test.py FOLDER        works there

Exit codes: 0 good, 1 not, 77 not run, because Doxygen or Sphinx is not installed.
"""

import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

NOT_RUN = 77
SOURCE = pathlib.Path(__file__).resolve().parents[2]
WORK = pathlib.Path(sys.argv[1])
# What the script reads.
PARTS = ("core/include", "client/include", "client/python/dynmesh", "proto/codec/include",
         "deploy/docs", "deploy/install-packages", "deploy/packages.txt", "deploy/reference")


def make(source, out):
    return subprocess.run([source / "deploy/reference", out], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False, timeout=600)


class Reference(unittest.TestCase):
    def setUp(self):
        WORK.mkdir(parents=True, exist_ok=True)
        folder = tempfile.TemporaryDirectory(dir=WORK)
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"

    def copy(self, file, pattern, replacement):
        """The sources with a change of one file."""
        copy = self.folder / "source"
        for part in PARTS:
            (copy / part).parent.mkdir(parents=True, exist_ok=True)
            if (SOURCE / part).is_dir():
                shutil.copytree(SOURCE / part, copy / part)
            else:
                shutil.copy(SOURCE / part, copy / part)
        text, count = re.subn(pattern, replacement, (copy / file).read_text(), flags=re.M)
        self.assertEqual(count, 1, f"{file}: {pattern}")
        (copy / file).write_text(text)
        return copy

    def refuses(self, file, pattern, replacement, message):
        said = make(self.copy(file, pattern, replacement), self.out)
        self.assertNotEqual(said.returncode, 0, said.stdout)
        self.assertRegex(said.stdout, message)

    def test_it_has_the_whole_interface(self):
        said = make(SOURCE, self.out)
        self.assertEqual(said.returncode, 0, said.stdout)
        self.assertEqual(said.stdout.split(), [str(self.out / "cpp/html/index.html"),
                                               str(self.out / "python/html/index.html")])
        pages = "".join(path.read_text() for path in (self.out / "cpp/html").glob("class*.html"))
        for name in ("TakeBack", "CarryMomentum", "FindSimplexSlot", "StreamDiffs", "WaitForRevision"):
            self.assertIn(name, pages)
        page = (self.out / "python/html/index.html").read_text()
        for name in ("dynmesh.Mesh.apply", "dynmesh.Diff.transfer", "dynmesh.Patch.boundary_faces",
                     "dynmesh.StaleDiff", "dynmesh.open"):
            self.assertIn(f'id="{name}"', page)

    def test_a_header_without_comments_is_an_error(self):
        self.refuses("core/include/dynmesh/dynamic_mesh.h", r"^  // The features present, by id\.\n",
                     "", r"dynamic_mesh\.h:\d+: .*Features\(\).* is not documented")

    def test_a_parameter_that_no_comment_names_is_an_error(self):
        self.refuses("core/include/dynmesh/feature.h", "between the point features `p` and `q`",
                     "between the point features `p`",
                     r"feature\.h:\d+: .*Segment does not name its parameter q")

    def test_a_property_without_docstring_is_an_error(self):
        self.refuses("client/python/dynmesh/_mesh.py", r'^        """2 or 3\."""\n', "",
                     r"dynmesh\.Mesh\.dimension has no docstring")

    def test_an_argument_that_no_docstring_names_is_an_error(self):
        self.refuses("client/python/dynmesh/_server.py", r"the mesh `name`, with", "it, with",
                     r"dynmesh\.Server\.delete does not name its parameter name")

    def test_a_name_without_an_entry_is_an_error(self):
        self.refuses("deploy/docs/index.rst", r"^\.\. autoclass:: dynmesh\.StaleDiff\n", "",
                     r"index\.rst does not have dynmesh\.StaleDiff")


class Comments(unittest.TestCase):
    def test_each_goes_to_its_declaration(self):
        file = WORK / "header.h"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("""\
// The file.
//
//   code();
//   * an item
//     of two lines
#ifndef A_H_  // a guard

// Of nothing in particular.

// A type.
struct A {
  int a;  // one
  int b;  // two,
          // in two lines
  A(const A&);
  // Takes it over.
  A(A&& other) noexcept;
  friend bool operator==(const A&, const A&) = default;
};
""")
        said = subprocess.run([SOURCE / "deploy/docs/doc_comments.py", file], text=True,
                              stdout=subprocess.PIPE, check=True, timeout=60).stdout
        self.assertEqual(said, """\
/// @file
/// The file.
///
///       code();
///   * an item
///     of two lines
#ifndef A_H_  // a guard
// Of nothing in particular.

/// A type.
struct A {
  int a;  ///< one
  int b;  ///< two,
          ///< in two lines

  /// Takes it over.
  A(A&& other) noexcept;

};
""")


if __name__ == "__main__":
    absent = [] if shutil.which("doxygen") else ["doxygen"]
    if importlib.util.find_spec("sphinx") is None:
        absent.append("python3-sphinx")
    if absent:
        print(f"reference_test: not run: not installed: {', '.join(absent)}")
        sys.exit(NOT_RUN)
    unittest.main(argv=[sys.argv[0]], verbosity=2)
