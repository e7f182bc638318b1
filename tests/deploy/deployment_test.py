"""The files by which dynmeshd is deployed, read strictly: that they parse, that what they name is
there, that every flag is one of dynmeshd's, and that nothing runs with more rights than it needs.
What says more than reading: image_test.py and systemd_test.py.

    deployment_test.py DYNMESHD
"""

import re
import sys
import unittest

import dockerfile
from apt_settings_test import AptSettings
from deployed_files import DEPLOY, SOURCE, drain_seconds, flags_in, flags_of_daemon, load_all
from dockerfile_test import DockerfileReader, IgnoreReader
from kubernetes_test import BrokenPromises, Kubernetes, pod_user

# Tests that unittest finds here.
__all__ = ["AptSettings", "BrokenPromises", "DockerfileReader", "IgnoreReader", "Kubernetes"]


def image_stages():
    return dockerfile.parse((SOURCE / "Dockerfile").read_text())


def words_of(stage):
    return [*stage.entrypoint, *stage.command]


class Compose(unittest.TestCase):
    def setUp(self):
        (self.file,) = load_all(DEPLOY / "compose.yaml")

    def test_ports_are_loopbacks(self):
        for service in self.file["services"].values():
            for port in service["ports"]:
                self.assertTrue(port.startswith("127.0.0.1:"), port)

    def test_volumes_and_files_are_there(self):
        for service in self.file["services"].values():
            for volume in service["volumes"]:
                source = volume.split(":")[0]
                if source.startswith("."):
                    self.assertTrue((DEPLOY / source).exists(), source)
                else:
                    self.assertIn(source, self.file["volumes"])

    def test_it_has_no_rights(self):
        daemon = self.file["services"]["dynmeshd"]
        self.assertTrue(daemon["read_only"])
        self.assertEqual(daemon["cap_drop"], ["ALL"])
        self.assertEqual(daemon["security_opt"], ["no-new-privileges:true"])

    def test_it_may_drain(self):
        grace = self.file["services"]["dynmeshd"]["stop_grace_period"]
        self.assertGreater(int(grace.removesuffix("s")), drain_seconds())

    def test_neither_memory_nor_logs_are_the_machines(self):
        for service in self.file["services"].values():
            self.assertIn("max-size", service["logging"]["options"])
        self.assertIn("mem_limit", self.file["services"]["dynmeshd"])

    def test_images_of_others_have_a_version(self):
        self.assertRegex(self.file["services"]["prometheus"]["image"], r":v\d+\.\d+\.\d+$")

    def test_prometheus_asks_the_port_of_the_image(self):
        (config,) = load_all(DEPLOY / "prometheus.yml")
        (job,) = config["scrape_configs"]
        (target,) = job["static_configs"][0]["targets"]
        self.assertIn(target.split(":")[0], self.file["services"])
        self.assertIn(f"0.0.0.0:{target.split(':')[1]}", words_of(image_stages()[-1]))


class Alerts(unittest.TestCase):
    def setUp(self):
        (self.file,) = load_all(DEPLOY / "alerts.yml")
        sources = (SOURCE / "server").rglob("*.cc")
        text = "".join(path.read_text() for path in sources)
        self.metrics = set(re.findall(r'"((?:dynmesh|grpc_server|process)_[a-z_]+)"', text))

    def test_prometheus_reads_them(self):
        (config,) = load_all(DEPLOY / "prometheus.yml")
        self.assertEqual(config["rule_files"], ["alerts.yml"])

    def test_each_has_what_prometheus_asks_for_and_a_sentence(self):
        (group,) = self.file["groups"]
        self.assertEqual(set(group), {"name", "rules"})
        names = [rule["alert"] for rule in group["rules"]]
        self.assertEqual(len(names), len(set(names)))
        for rule in group["rules"]:
            self.assertLessEqual({"alert", "expr", "annotations"}, set(rule))
            self.assertLessEqual(set(rule), {"alert", "expr", "for", "annotations"})
            self.assertIn("summary", rule["annotations"])
            self.assertRegex(rule.get("for", "1m"), r"^\d+[smh]$")
            for one, other in ("()", "{}", "[]"):
                self.assertEqual(rule["expr"].count(one), rule["expr"].count(other))

    def test_metrics_are_dynmeshds(self):
        self.assertIn("dynmesh_edit_seconds", self.metrics)
        texts = [rule["expr"] for rule in self.file["groups"][0]["rules"]]
        texts.append((DEPLOY / "RUNBOOK.md").read_text())
        for text in texts:
            for name in re.findall(r"\b(?:dynmesh|grpc_server|process)_[a-z_]+", text):
                self.assertIn(re.sub("_(bucket|sum|count)$", "", name), self.metrics)


class Image(unittest.TestCase):
    def setUp(self):
        self.stages = image_stages()
        self.last = self.stages[-1]

    def test_packages_come_from_the_one_list(self):
        runs = [
            [" ".join(step.command) for step in stage.steps if isinstance(step, dockerfile.Run)]
            for stage in self.stages
        ]
        self.assertFalse([run for stage in runs for run in stage if "apt-get install" in run])
        for stage, section in zip(runs, ("build", "runtime"), strict=True):
            self.assertTrue([run for run in stage if f"install-packages {section}" in run], section)

    def test_it_does_not_run_as_root(self):
        self.assertEqual(self.last.user, str(pod_user()))

    def test_flags_are_dynmeshds(self):
        words = words_of(self.last)
        self.assertLessEqual(flags_in(words), flags_of_daemon())
        self.assertEqual(self.last.volumes, (words[words.index("--data-dir") + 1],))

    def test_other_arguments_leave_the_folder_and_the_health_check(self):
        self.assertIn("--data-dir", self.last.entrypoint)
        self.assertIn("--metrics", self.last.entrypoint)

    def test_ports_are_those_listened_on(self):
        words = words_of(self.last)
        listened = [words[words.index(flag) + 1] for flag in ("--listen", "--metrics")]
        self.assertEqual([int(word.split(":")[1]) for word in listened], list(self.last.ports))
        self.assertIn(f"/127.0.0.1/{self.last.ports[1]} ", self.last.health.command[-1])


class Systemd(unittest.TestCase):
    def setUp(self):
        self.text = (DEPLOY / "dynmeshd.service").read_text()

    def test_flags_are_dynmeshds(self):
        (command,) = re.findall(r"^ExecStart=(.*)$", self.text, re.M)
        self.assertLessEqual(flags_in(command.split()), flags_of_daemon())

    def test_it_may_drain(self):
        (seconds,) = re.findall(r"^TimeoutStopSec=(\d+)$", self.text, re.M)
        self.assertGreater(int(seconds), drain_seconds())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
