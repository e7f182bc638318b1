"""What systemd-analyze says about the unit: that it is understood, and how exposed it is.

    systemd_test.py DYNMESHD

Exit codes: 0 good, 1 not, 77 not run, because systemd-analyze is not installed.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from deployed_files import DAEMON, DEPLOY

NOT_RUN = 77
# What it may find missing. The service listens, logs through a socket, and has the system's files;
# access to the port depends on the site, not on the unit.
LEFT_OPEN = {
    *("RootDirectory=/RootImage=", "PrivateMounts=", "PrivateNetwork=", "IPAddressDeny="),
    *("RestrictAddressFamilies=~AF_UNIX", "RestrictAddressFamilies=~AF_(INET|INET6)"),
    "DeviceAllow=",  # of its own making: the clock, to be read, with ProtectClock
    "SystemCallFilter=~@resources",  # of these setpriority alone
}


def analyze(text, *arguments):
    """Exit code and all that systemd-analyze says about a unit with what it names in place."""
    text = text.replace("/usr/local/bin/dynmeshd", str(DAEMON.resolve()))
    text = text.replace("Documentation=", "#Documentation=")  # where nothing is installed
    with tempfile.TemporaryDirectory() as folder:
        unit = pathlib.Path(folder) / "dynmeshd.service"
        unit.write_text(text)
        command = ["systemd-analyze", *arguments, unit]
        said = subprocess.run(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
            timeout=120
        )
    return said.returncode, said.stdout


def left_open(text):
    """What is not protected, and how exposed systemd calls the unit."""
    code, said = analyze(text, "security", "--offline=true", "--no-pager")
    assert code == 0, said
    assert "✓" in said, said
    return set(re.findall(r"^✗ (\S+)", said, re.M)), said.strip().splitlines()[-1]


class Systemd(unittest.TestCase):
    def setUp(self):
        self.text = (DEPLOY / "dynmeshd.service").read_text()

    def test_it_finds_nothing_to_say(self):
        self.assertEqual(analyze(self.text, "verify"), (0, ""))

    def test_it_would_say_so(self):
        for good, bad in (("ProtectHome=", "ProtectHomes="), ("RestartSec=2", "RestartSec=two")):
            self.assertIn(good, self.text)
            _, said = analyze(self.text.replace(good, bad), "verify")
            self.assertIn("dynmeshd.service", said)

    def test_it_is_open_where_it_has_to_be(self):
        found, exposure = left_open(self.text)
        print(exposure)
        self.assertLessEqual(found, LEFT_OPEN)

    def test_a_thread_may_give_way_and_no_more(self):
        filters = re.findall(r"^SystemCallFilter=(.*)$", self.text, re.M)
        self.assertEqual(
            filters, ["@system-service", "~@privileged @resources", "setpriority"]
        )

    def test_a_protection_that_is_gone_is_found(self):
        for key in ("User", "CapabilityBoundingSet", "MemoryDenyWriteExecute", "ProtectHome",
                    "ProtectProc", "RestrictNamespaces", "SystemCallFilter", "UMask"):
            text, count = re.subn(rf"(?m)^{key}=.*\n", "", self.text)
            self.assertTrue(count, key)
            self.assertFalse(left_open(text)[0] <= LEFT_OPEN, key)


if __name__ == "__main__":
    if shutil.which("systemd-analyze") is None:
        print("systemd_test: not run: systemd-analyze is not installed")
        sys.exit(NOT_RUN)
    unittest.main(argv=sys.argv[:1], verbosity=2)
