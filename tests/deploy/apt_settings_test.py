"""That the archives of the machine's apt are found in both forms that it reads."""

import pathlib
import tempfile
import unittest

import apt_settings


class AptSettings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "sources.list.d").mkdir()

    def test_lines(self):
        (self.folder / "sources.list").write_text(
            "# deb http://a/debian bookworm main\n"
            "deb-src http://b/debian bookworm main\n"
            "deb [arch=amd64 signed-by=/c.gpg] http://c/security bookworm-security main\n"
            "deb http://d/debian bookworm main contrib # the mirror\n"
            "deb http://e/else cloud-bookworm main\n"
        )
        self.assertEqual(
            apt_settings.sources("bookworm", self.folder),
            [
                "deb http://d/debian bookworm main contrib",
                "deb http://c/security bookworm-security main",
            ],
        )

    def test_stanzas(self):
        (self.folder / "sources.list.d" / "debian.sources").write_text(
            "# a comment\nTypes: deb deb-src\nURIs: http://a/debian\nSuites: bookworm-updates\n"
            " bookworm\n# between\nComponents: main\n\n\n"
            "Types: deb\nEnabled: no\nURIs: http://b/debian\nSuites: bookworm\nComponents: main\n\n"
            "Types: deb-src\nURIs: http://c/debian\nSuites: bookworm\nComponents: main\n"
        )
        self.assertEqual(
            apt_settings.sources("bookworm", self.folder),
            ["deb http://a/debian bookworm main", "deb http://a/debian bookworm-updates main"],
        )

    def test_no_archive_is_an_error(self):
        (self.folder / "sources.list").write_text("deb http://a/debian bookworm-updates main\n")
        with self.assertRaisesRegex(apt_settings.AptError, "no archive of bookworm"):
            apt_settings.sources("bookworm", self.folder)

    def test_images_that_can_be_made(self):
        self.assertEqual(apt_settings.suite_of("debian:12"), "bookworm")
        self.assertEqual(apt_settings.suite_of("debian:12-slim"), "bookworm")
        for image in ("debian", "debian:99", "ubuntu:12", "build"):
            with self.assertRaisesRegex(apt_settings.AptError, "no way"):
                apt_settings.suite_of(image)
