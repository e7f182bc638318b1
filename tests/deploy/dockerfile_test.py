"""That the reader of the Dockerfile reads what is there and refuses the rest."""

import unittest

from dockerfile import Copy, DockerfileError, HealthCheck, Run, WorkDir, parse, read_ignore


class DockerfileReader(unittest.TestCase):
    def refuses(self, text, reason):
        with self.assertRaisesRegex(DockerfileError, reason):
            parse(text)

    def step(self, line):
        (stage,) = parse("FROM debian:12\n" + line)
        (step,) = stage.steps
        return step

    def test_stages_have_names_and_bases(self):
        first, second = parse("FROM debian:12 AS build\nFROM debian:12-slim\n")
        self.assertEqual((first.base, first.name), ("debian:12", "build"))
        self.assertEqual((second.base, second.name), ("debian:12-slim", None))

    def test_an_instruction_that_is_not_known_is_refused_with_its_line(self):
        for line in ("ENV A=b", "ADD a b", "ARG A", "SHELL ['x']", "ONBUILD RUN a", "LABEL a=b",
                     "STOPSIGNAL 9", "run true", "RUNN true", "RUN\ttrue"):
            self.refuses(f"FROM a\n\n# b\n{line}\n", "^line 4, .*not known")

    def test_a_flag_that_is_not_known_is_refused(self):
        for line in ("COPY --chown=1:1 a b", "COPY --link a b", "RUN --mount=type=cache x",
                     "HEALTHCHECK --retries=1 CMD true"):
            self.refuses("FROM a\n" + line, "flag")
        self.refuses("FROM --platform=x a", "is not IMAGE")

    def test_commands_have_shell_and_json_form(self):
        self.assertEqual(self.step("RUN a && b"), Run(("/bin/sh", "-c", "a && b")))
        self.assertEqual(self.step('RUN ["a", "b c"]'), Run(("a", "b c")))
        (stage,) = parse('FROM a\nENTRYPOINT ["x"]\nCMD y "z"\n')
        self.assertEqual(stage.entrypoint, ("x",))
        self.assertEqual(stage.command, ("/bin/sh", "-c", 'y "z"'))

    def test_json_that_is_none_is_refused(self):
        for value in ('["a",]', "['a']", '["a"', "[]", "[1]", '["a"] b'):
            self.refuses(f"FROM a\nCMD {value}\n", "JSON")

    def test_lines_are_continued_over_comments(self):
        text = "RUN a \\\n  # not this\n && b \\  \n && c"
        self.assertEqual(self.step(text), Run(("/bin/sh", "-c", "a  && b  && c")))
        self.assertEqual(self.step("RUN a#b"), Run(("/bin/sh", "-c", "a#b")))
        self.refuses("FROM a\nRUN b \\\n", "the file ends")
        self.refuses("FROM a\nRUN b \\\n\n c\n", "empty")

    def test_a_backslash_within_a_line_stays(self):
        self.assertEqual(self.step('RUN ["a\\\\r", "b"]'), Run(("a\\r", "b")))

    def test_comments_and_empty_lines_are_none(self):
        (stage,) = parse("# a\n\nFROM b\n  # RUN c\n\n")
        self.assertEqual(stage.steps, [])

    def test_heredocs_are_refused(self):
        for line in ("RUN <<EOF", "RUN cat <<-'EOF' > a", "RUN a 3<<EOF"):
            self.refuses("FROM a\n" + line, "heredoc")
        self.refuses("FROM a\nCOPY <<EOF /b", "heredoc")

    def test_parser_directives_are_refused(self):
        self.refuses("# escape=`\nFROM a\n", "directive")
        self.refuses("# x\n#syntax = b/c\nFROM a\n", "directive")
        parse("FROM a\n# later=it is a comment\n")

    def test_copies(self):
        self.assertEqual(self.step("COPY a b c/"), Copy(("a", "b"), "c/", None))
        stages = parse("FROM a AS b\nFROM c\nCOPY --from=b /d e\n")
        self.assertEqual(stages[1].steps, [Copy(("/d",), "e", "b")])
        self.refuses("FROM a\nCOPY --from=b c d\n", "no stage")
        self.refuses("FROM a AS b\nCOPY --from=b c d\n", "no stage")
        self.refuses("FROM a\nCOPY b c d\n", "no folder")
        self.refuses("FROM a\nCOPY b\n", "is not SOURCE")
        self.refuses("FROM a\nCOPY ../b c\n", "outside")
        self.refuses("FROM a\nCOPY *.h c/\n", "wildcards")

    def test_variables_are_refused_but_in_commands(self):
        for line in ("WORKDIR $A", "COPY $A b", "USER ${A}", "VOLUME /$A", "EXPOSE $A"):
            self.refuses("FROM a\n" + line, "variables")
        self.refuses("FROM $A", "variables")
        self.assertEqual(self.step("RUN echo $A"), Run(("/bin/sh", "-c", "echo $A")))

    def test_settings(self):
        (stage,) = parse(
            "FROM a\nWORKDIR /b\nUSER 7\nVOLUME /c /d\nEXPOSE 1 23\n"
            'HEALTHCHECK --interval=1m --timeout=500ms CMD ["e"]\n'
        )
        self.assertEqual(stage.steps, [WorkDir("/b")])
        self.assertEqual((stage.user, stage.volumes, stage.ports), ("7", ("/c", "/d"), (1, 23)))
        self.assertEqual(stage.health, HealthCheck(("e",), 60, 0.5, 0))
        self.refuses("FROM a\nEXPOSE 1/udp\n", "TCP")
        self.refuses("FROM a\nHEALTHCHECK NONE\n", "without CMD")
        self.refuses("FROM a\nHEALTHCHECK --timeout=5 CMD b\n", "no time")

    def test_what_would_override_silently_is_refused(self):
        for line in ("CMD a", "ENTRYPOINT a", "USER 1", "EXPOSE 1", "VOLUME /a",
                     "HEALTHCHECK CMD a"):
            self.refuses(f"FROM a\n{line}\n{line}\n", "second time")
        self.refuses("FROM a AS b\nFROM a AS b\n", "a second stage")
        self.refuses("FROM a\nUSER 1\nRUN b\n", "after USER")

    def test_nothing_stands_before_from(self):
        self.refuses("RUN a\n", "before the first FROM")
        self.refuses("# nothing\n", "no FROM")
        self.refuses("FROM a\nRUN \n", "of nothing")


class IgnoreReader(unittest.TestCase):
    def test_folders_take_what_is_in_them(self):
        ignored = read_ignore("# a comment\nbuild\n/out/\n")
        for path in ("build", "build/a/b", "out/a"):
            self.assertTrue(ignored(path), path)
        for path in ("deploy/build", "build.txt", "a comment", "outer"):
            self.assertFalse(ignored(path), path)

    def test_stars_stay_within_a_name_but_for_two(self):
        ignored = read_ignore("*.log\n**/cache\na/**/z\n")
        for path in ("b.log", "cache", "x/y/cache/c", "a/z", "a/b/c/z"):
            self.assertTrue(ignored(path), path)
        for path in ("x/b.log", "xcache", "b/z", "blog"):
            self.assertFalse(ignored(path), path)

    def test_the_last_rule_that_matches_decides(self):
        ignored = read_ignore("*.md\n!README.md\n")
        self.assertTrue(ignored("a.md"))
        self.assertFalse(ignored("README.md"))


if __name__ == "__main__":
    unittest.main()
