"""The files by which dynmeshd is deployed, read strictly: that they parse, that what they name is
there, that every flag is one of dynmeshd's, and that nothing runs with more rights than it needs.

    deployment_test.py SOURCE_FOLDER DYNMESHD
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import yaml

SOURCE = pathlib.Path(sys.argv[1])
DAEMON = pathlib.Path(sys.argv[2])
DEPLOY = SOURCE / "deploy"
MANIFESTS = sorted((DEPLOY / "kubernetes").glob("*.yaml"))


class StrictLoader(yaml.SafeLoader):
    """Refuses a key that is given twice, of which YAML would silently keep the last."""


def strict_mapping(loader, node, deep=False):
    seen = set()
    for key_node, _ in node.value:
        key = loader.construct_object(key_node, deep=True)
        if key in seen:
            raise yaml.YAMLError(f"{key!r} is given twice{key_node.start_mark}")
        seen.add(key)
    return yaml.SafeLoader.construct_mapping(loader, node, deep=True)


StrictLoader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, strict_mapping)


def load_all(path):
    return list(yaml.load_all(path.read_text(), StrictLoader))


def flags_of_daemon():
    text = subprocess.run([DAEMON, "--help"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"(--[a-z][a-z-]*)", text))


def flags_in(words):
    return {word.split("=")[0] for word in words if word.startswith("--")}


def manifest(kind):
    found = [m for path in MANIFESTS for m in load_all(path) if m["kind"] == kind]
    assert len(found) == 1, f"{len(found)} of kind {kind}"
    return found[0]


class Kubernetes(unittest.TestCase):
    def setUp(self):
        self.set = manifest("StatefulSet")
        self.pod = self.set["spec"]["template"]
        (self.container,) = self.pod["spec"]["containers"]

    def test_all_are_of_known_kinds_in_one_namespace(self):
        versions = {
            "Service": "v1",
            "StatefulSet": "apps/v1",
            "NetworkPolicy": "networking.k8s.io/v1",
        }
        for path in MANIFESTS:
            for m in load_all(path):
                self.assertEqual(m["apiVersion"], versions[m["kind"]], path)
                self.assertEqual(m["metadata"]["namespace"], "dynmesh", path)

    def test_selectors_find_the_pod(self):
        labels = self.pod["metadata"]["labels"].items()
        for selector in (
            self.set["spec"]["selector"]["matchLabels"],
            manifest("Service")["spec"]["selector"],
            manifest("NetworkPolicy")["spec"]["podSelector"]["matchLabels"],
        ):
            self.assertLessEqual(selector.items(), labels)
        self.assertEqual(self.set["spec"]["serviceName"], manifest("Service")["metadata"]["name"])

    def test_one_server_for_one_journal(self):
        self.assertEqual(self.set["spec"]["replicas"], 1)

    def test_every_flag_is_one_of_dynmeshd(self):
        self.assertLessEqual(flags_in(self.container["args"]), flags_of_daemon())

    def test_ports_are_those_listened_on(self):
        args = dict(a.split("=", 1) for a in self.container["args"])
        ports = {p["name"]: p["containerPort"] for p in self.container["ports"]}
        self.assertEqual(int(args["--listen"].rsplit(":")[-1]), ports["grpc"])
        self.assertEqual(int(args["--metrics"].rsplit(":")[-1]), ports["metrics"])
        for port in manifest("Service")["spec"]["ports"]:
            self.assertEqual(port["port"], ports[port["targetPort"]])
        allowed = {
            p["port"] for rule in manifest("NetworkPolicy")["spec"]["ingress"] for p in rule["ports"]
        }
        self.assertEqual(allowed, set(ports.values()))

    def test_what_is_mounted_is_there_and_files_lie_in_it(self):
        volumes = {v["name"] for v in self.pod["spec"]["volumes"]}
        volumes |= {v["metadata"]["name"] for v in self.set["spec"]["volumeClaimTemplates"]}
        mounts = {m["mountPath"]: m for m in self.container["volumeMounts"]}
        self.assertEqual({m["name"] for m in mounts.values()}, volumes)
        for arg in self.container["args"]:
            value = arg.split("=", 1)[1]
            if value.startswith("/"):
                self.assertTrue(any(value.startswith(path) for path in mounts), arg)
        self.assertIn("/var/lib/dynmesh", mounts)

    def test_probes_ask_what_there_is(self):
        paths = {"startupProbe": "/readyz", "livenessProbe": "/healthz", "readinessProbe": "/readyz"}
        for probe, path in paths.items():
            get = self.container[probe]["httpGet"]
            self.assertEqual((get["path"], get["port"]), (path, "metrics"))

    def test_it_has_no_rights(self):
        own, pod = self.container["securityContext"], self.pod["spec"]["securityContext"]
        self.assertTrue(pod["runAsNonRoot"] and pod["runAsUser"] > 0)
        self.assertEqual(pod["seccompProfile"], {"type": "RuntimeDefault"})
        self.assertFalse(own["allowPrivilegeEscalation"])
        self.assertTrue(own["readOnlyRootFilesystem"])
        self.assertEqual(own["capabilities"], {"drop": ["ALL"]})
        self.assertFalse(self.pod["spec"]["automountServiceAccountToken"])
        self.assertEqual(manifest("NetworkPolicy")["spec"]["egress"], [])
        self.assertNotIn("--insecure-listen", self.container["args"])


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

    def test_prometheus_asks_the_port_of_the_image(self):
        (config,) = load_all(DEPLOY / "prometheus.yml")
        (job,) = config["scrape_configs"]
        (target,) = job["static_configs"][0]["targets"]
        self.assertIn(target.split(":")[0], self.file["services"])
        self.assertIn(f"0.0.0.0:{target.split(':')[1]}", (SOURCE / "Dockerfile").read_text())


class Image(unittest.TestCase):
    def setUp(self):
        text = re.sub(r"\\\n", " ", (SOURCE / "Dockerfile").read_text())
        self.lines = [l for l in text.splitlines() if l.strip() and not l.startswith("#")]

    def test_packages_come_from_the_one_list(self):
        runs = [l for l in self.lines if l.startswith("RUN")]
        self.assertFalse([l for l in runs if "apt-get install" in l])
        self.assertTrue(any("install-packages build" in l for l in runs))
        self.assertTrue(any("install-packages runtime" in l for l in runs))

    def test_it_does_not_run_as_root(self):
        users = [l.split()[1] for l in self.lines if l.startswith("USER")]
        pod = manifest("StatefulSet")["spec"]["template"]["spec"]["securityContext"]
        self.assertEqual(users, [str(pod["runAsUser"])])

    def test_flags_are_dynmeshds(self):
        (command,) = [l for l in self.lines if l.startswith("CMD")]
        words = json.loads(command[len("CMD") :])
        self.assertLessEqual(flags_in(words), flags_of_daemon())
        volumes = [l.split()[1] for l in self.lines if l.startswith("VOLUME")]
        self.assertEqual(volumes, [words[words.index("--data-dir") + 1]])


class Systemd(unittest.TestCase):
    def setUp(self):
        self.text = (DEPLOY / "dynmeshd.service").read_text()

    def test_flags_are_dynmeshds(self):
        (command,) = re.findall(r"^ExecStart=(.*)$", self.text, re.M)
        self.assertLessEqual(flags_in(command.split()), flags_of_daemon())

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze")
    def test_systemd_finds_nothing_to_say(self):
        with tempfile.TemporaryDirectory() as folder:
            unit = pathlib.Path(folder) / "dynmeshd.service"
            unit.write_text(
                self.text.replace("/usr/local/bin/dynmeshd", str(DAEMON.resolve())).replace(
                    "Documentation=", "#Documentation="
                )
            )
            said = subprocess.run(
                ["systemd-analyze", "verify", unit], capture_output=True, text=True, check=False
            )
            self.assertEqual((said.returncode, said.stdout + said.stderr), (0, ""))
            said = subprocess.run(
                ["systemd-analyze", "security", "--offline=true", "--threshold=20", unit],
                capture_output=True,
                text=True,
                check=False,
            )
            self.assertEqual(said.returncode, 0, said.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
