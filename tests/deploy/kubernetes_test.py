"""What the Kubernetes manifests promise, and that each promise is looked at: every change for the
worse in WORSE makes the test fail that is named there."""

import copy
import re
import unittest

from deployed_files import DEPLOY, drain_seconds, flags_in, flags_of_daemon, load_all

DOCUMENTS = [m for path in sorted((DEPLOY / "kubernetes").glob("*.yaml")) for m in load_all(path)]


def manifest(kind, documents):
    found = [m for m in documents if m["kind"] == kind]
    assert len(found) == 1, f"{len(found)} of kind {kind}"
    return found[0]


def pod_user():
    return manifest("StatefulSet", DOCUMENTS)["spec"]["template"]["spec"]["securityContext"][
        "runAsUser"
    ]


def quantity(text):
    number, unit = re.fullmatch(r"(\d+)(Mi|Gi)", text).groups()
    return int(number) * {"Mi": 1, "Gi": 1024}[unit]


class Kubernetes(unittest.TestCase):
    documents = DOCUMENTS

    def setUp(self):
        self.set = manifest("StatefulSet", self.documents)["spec"]
        self.pod = self.set["template"]
        (self.container,) = self.pod["spec"]["containers"]
        self.service = manifest("Service", self.documents)
        self.policy = manifest("NetworkPolicy", self.documents)["spec"]
        self.arguments = dict(a.split("=", 1) for a in self.container["args"])
        self.ports = {p["name"]: p["containerPort"] for p in self.container["ports"]}

    def test_all_are_of_known_kinds_in_one_namespace(self):
        versions = {
            "Service": "v1",
            "StatefulSet": "apps/v1",
            "NetworkPolicy": "networking.k8s.io/v1",
        }
        for m in self.documents:
            self.assertEqual(m["apiVersion"], versions[m["kind"]])
            self.assertEqual(m["metadata"]["namespace"], "dynmesh")

    def test_keys_are_those_that_are_looked_at(self):
        known = {
            "Service": (self.service["spec"], "clusterIP selector ports"),
            "set": (self.set, "serviceName replicas selector template volumeClaimTemplates"),
            "policy": (self.policy, "podSelector policyTypes ingress egress"),
            "pod": (
                self.pod["spec"],
                "automountServiceAccountToken terminationGracePeriodSeconds securityContext"
                " containers volumes",
            ),
            "container": (
                self.container,
                "name image imagePullPolicy command args ports securityContext resources startupProbe"
                " livenessProbe readinessProbe volumeMounts",
            ),
        }
        for what, (mapping, keys) in known.items():
            self.assertEqual(set(mapping), set(keys.split()), what)

    def test_selectors_find_the_pod(self):
        labels = self.pod["metadata"]["labels"]
        self.assertTrue(labels)
        self.assertEqual(self.set["selector"], {"matchLabels": labels})
        self.assertEqual(self.service["spec"]["selector"], labels)
        self.assertEqual(self.policy["podSelector"], {"matchLabels": labels})
        self.assertEqual(self.set["serviceName"], self.service["metadata"]["name"])
        # So that a StatefulSet's pods have names.
        self.assertEqual(self.service["spec"]["clusterIP"], "None")

    def test_one_server_for_one_journal(self):
        self.assertEqual(self.set["replicas"], 1)

    def test_every_flag_is_one_of_dynmeshd(self):
        self.assertEqual(self.container["command"], ["dynmeshd"])
        self.assertLessEqual(flags_in(self.container["args"]), flags_of_daemon())

    def test_ports_are_those_listened_on(self):
        self.assertEqual(set(self.ports), {"grpc", "metrics"})
        for flag, port in {"--listen": "grpc", "--metrics": "metrics"}.items():
            self.assertEqual(int(self.arguments[flag].rsplit(":")[-1]), self.ports[port])
        for port in self.service["spec"]["ports"]:
            self.assertEqual(port["port"], self.ports[port["targetPort"]])
        notes = self.pod["metadata"]["annotations"]
        self.assertEqual(notes["prometheus.io/port"], str(self.ports["metrics"]))

    def test_what_is_mounted_is_there_and_files_lie_in_it(self):
        volumes = [v["name"] for v in self.pod["spec"]["volumes"]]
        volumes += [v["metadata"]["name"] for v in self.set["volumeClaimTemplates"]]
        mounts = {m["mountPath"]: m for m in self.container["volumeMounts"]}
        self.assertEqual(sorted(m["name"] for m in mounts.values()), sorted(volumes))
        for flag, value in self.arguments.items():
            if value.startswith("/"):
                self.assertTrue(any(f"{value}/".startswith(f"{path}/") for path in mounts), flag)

    def test_meshes_outlive_the_pod(self):
        (claim,) = self.set["volumeClaimTemplates"]
        self.assertEqual(claim["spec"]["accessModes"], ["ReadWriteOnce"])
        self.assertGreaterEqual(quantity(claim["spec"]["resources"]["requests"]["storage"]), 1024)
        mount = {"name": claim["metadata"]["name"], "mountPath": self.arguments["--data-dir"]}
        self.assertIn(mount, self.container["volumeMounts"])

    def test_volumes_are_secrets_and_a_small_one_in_memory(self):
        for volume in self.pod["spec"]["volumes"]:
            (kind,) = set(volume) - {"name"}
            if kind == "secret":
                self.assertEqual(volume["secret"]["defaultMode"], 0o440)
                mounts = {m["name"]: m for m in self.container["volumeMounts"]}
                self.assertTrue(mounts[volume["name"]]["readOnly"])
            else:
                self.assertEqual(kind, "emptyDir")
                self.assertEqual(volume["emptyDir"]["medium"], "Memory")
                self.assertLessEqual(quantity(volume["emptyDir"]["sizeLimit"]), 256)

    def test_probes_ask_what_there_is(self):
        paths = {"startup": "/readyz", "liveness": "/healthz", "readiness": "/readyz"}
        for probe, path in paths.items():
            asked = self.container[f"{probe}Probe"]["httpGet"]
            self.assertEqual(asked, {"path": path, "port": "metrics"})

    def test_probes_have_patience(self):
        start, alive = self.container["startupProbe"], self.container["livenessProbe"]
        # Long enough to recover the largest possible mesh without being killed.
        self.assertGreaterEqual(start["periodSeconds"] * start["failureThreshold"], 1800)
        self.assertGreaterEqual(alive["periodSeconds"] * alive.get("failureThreshold", 3), 30)
        self.assertGreaterEqual(alive["timeoutSeconds"], 5)
        self.assertLessEqual(self.container["readinessProbe"]["periodSeconds"], 10)

    def test_it_may_drain(self):
        self.assertGreater(self.pod["spec"]["terminationGracePeriodSeconds"], drain_seconds())

    def test_it_has_no_rights(self):
        user = self.pod["spec"]["securityContext"]["runAsUser"]
        self.assertGreater(user, 0)
        # Nothing more in either: what stands at the container overrides the pod's.
        self.assertEqual(
            self.pod["spec"]["securityContext"],
            {
                "runAsNonRoot": True,
                **{"runAsUser": user, "runAsGroup": user, "fsGroup": user},
                "seccompProfile": {"type": "RuntimeDefault"},
            },
        )
        self.assertEqual(
            self.container["securityContext"],
            {
                "allowPrivilegeEscalation": False,
                "readOnlyRootFilesystem": True,
                "capabilities": {"drop": ["ALL"]},
            },
        )
        self.assertIs(self.pod["spec"]["automountServiceAccountToken"], False)

    def test_its_memory_is_bounded(self):
        resources = self.container["resources"]
        asked, limit = resources["requests"]["memory"], resources["limits"]["memory"]
        self.assertLessEqual(quantity(asked), quantity(limit))
        self.assertIn("cpu", resources["requests"])

    def test_only_who_should_reaches_it(self):
        self.assertEqual(self.policy["policyTypes"], ["Ingress", "Egress"])
        self.assertEqual(self.policy["egress"], [])
        peers = {}
        for rule in self.policy["ingress"]:
            (port,) = rule["ports"]
            (peers[port["port"]],) = rule["from"]
            self.assertEqual(port["protocol"], "TCP")
        # One entry with two selectors is "and"; two entries would be "or".
        clients = {
            "namespaceSelector": {},
            "podSelector": {"matchLabels": {"dynmesh-client": "true"}},
        }
        monitoring = {
            "namespaceSelector": {"matchLabels": {"kubernetes.io/metadata.name": "monitoring"}}
        }
        self.assertEqual(peers, {self.ports["grpc"]: clients, self.ports["metrics"]: monitoring})

    def test_only_who_may_is_let_in(self):
        for flag in ("--tls-cert", "--tls-key", "--tokens"):
            self.assertIn(flag, self.arguments)
        self.assertNotIn("--insecure-listen", flags_in(self.container["args"]))


GONE = object()
POD = "spec.template.spec."
CONTAINER = POD + "containers.0."
# Test that has to fail; kind, path and new value of what breaks it.
WORSE = [
    ("keys_are", "StatefulSet", POD + "hostNetwork", True),
    ("keys_are", "StatefulSet", POD + "hostPID", True),
    ("keys_are", "StatefulSet", POD + "initContainers", [{"name": "a"}]),
    ("every_flag", "StatefulSet", CONTAINER + "command", ["sh"]),
    ("keys_are", "StatefulSet", CONTAINER + "lifecycle", {}),
    ("keys_are", "Service", "spec.type", "LoadBalancer"),
    ("keys_are", "Service", "spec.externalIPs", ["192.0.2.1"]),
    ("all_are", "StatefulSet", "apiVersion", "apps/v1beta1"),
    ("all_are", "NetworkPolicy", "metadata.namespace", "default"),
    ("selectors", "StatefulSet", "spec.selector.matchLabels.app", "other"),
    ("selectors", "StatefulSet", "spec.serviceName", "other"),
    ("selectors", "Service", "spec.selector", {}),
    ("selectors", "Service", "spec.clusterIP", "192.0.2.1"),
    ("selectors", "NetworkPolicy", "spec.podSelector", {}),
    ("selectors", "NetworkPolicy", "spec.podSelector.matchLabels.app", "other"),
    ("one_server", "StatefulSet", "spec.replicas", 2),
    ("every_flag", "StatefulSet", CONTAINER + "args.0", "--listens=0.0.0.0:7878"),
    ("ports_are", "StatefulSet", CONTAINER + "args.0", "--listen=0.0.0.0:7879"),
    ("ports_are", "StatefulSet", CONTAINER + "ports.1.containerPort", 9179),
    ("ports_are", "Service", "spec.ports.0.port", 7879),
    ("ports_are", "StatefulSet", "spec.template.metadata.annotations", {"prometheus.io/port": "1"}),
    ("what_is_mounted", "StatefulSet", CONTAINER + "volumeMounts.1.name", "other"),
    ("what_is_mounted", "StatefulSet", CONTAINER + "args.3", "--tls-cert=/etc/other/tls.crt"),
    ("meshes_outlive", "StatefulSet", "spec.volumeClaimTemplates", []),
    ("meshes_outlive", "StatefulSet", "spec.volumeClaimTemplates.0.metadata.name", "other"),
    ("meshes_outlive", "StatefulSet", "spec.volumeClaimTemplates.0.spec.accessModes", GONE),
    (
        "meshes_outlive",
        "StatefulSet",
        "spec.volumeClaimTemplates.0.spec.accessModes",
        ["ReadWriteMany"],
    ),
    (
        "meshes_outlive",
        "StatefulSet",
        "spec.volumeClaimTemplates.0.spec.resources.requests.storage",
        "1Mi",
    ),
    ("meshes_outlive", "StatefulSet", CONTAINER + "volumeMounts.0.mountPath", "/var/lib/other"),
    ("meshes_outlive", "StatefulSet", CONTAINER + "volumeMounts.0.readOnly", True),
    ("meshes_outlive", "StatefulSet", CONTAINER + "args.2", "--data-dir=/tmp"),
    ("volumes_are", "StatefulSet", POD + "volumes.0", {"name": "tls", "hostPath": {"path": "/"}}),
    ("volumes_are", "StatefulSet", POD + "volumes.1.secret.defaultMode", 0o444),
    ("volumes_are", "StatefulSet", POD + "volumes.2.emptyDir", {}),
    ("volumes_are", "StatefulSet", CONTAINER + "volumeMounts.1.readOnly", GONE),
    ("probes_ask", "StatefulSet", CONTAINER + "startupProbe", GONE),
    ("probes_ask", "StatefulSet", CONTAINER + "livenessProbe", GONE),
    ("probes_ask", "StatefulSet", CONTAINER + "readinessProbe", GONE),
    ("probes_ask", "StatefulSet", CONTAINER + "livenessProbe.httpGet.path", "/readyz"),
    ("probes_ask", "StatefulSet", CONTAINER + "readinessProbe.httpGet.path", "/healthz"),
    ("probes_ask", "StatefulSet", CONTAINER + "startupProbe.httpGet.port", "grpc"),
    ("probes_have", "StatefulSet", CONTAINER + "startupProbe.failureThreshold", 3),
    ("probes_have", "StatefulSet", CONTAINER + "livenessProbe.failureThreshold", 1),
    ("probes_have", "StatefulSet", CONTAINER + "livenessProbe.timeoutSeconds", GONE),
    ("probes_have", "StatefulSet", CONTAINER + "readinessProbe.periodSeconds", 600),
    ("it_may_drain", "StatefulSet", POD + "terminationGracePeriodSeconds", 20),
    ("it_has_no", "StatefulSet", POD + "securityContext.runAsNonRoot", GONE),
    ("it_has_no", "StatefulSet", POD + "securityContext.runAsNonRoot", False),
    ("it_has_no", "StatefulSet", POD + "securityContext.runAsUser", 0),
    ("it_has_no", "StatefulSet", POD + "securityContext.runAsGroup", 0),
    ("it_has_no", "StatefulSet", POD + "securityContext.seccompProfile.type", "Unconfined"),
    ("it_has_no", "StatefulSet", POD + "automountServiceAccountToken", GONE),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.runAsUser", 0),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.privileged", True),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.readOnlyRootFilesystem", GONE),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.readOnlyRootFilesystem", False),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.allowPrivilegeEscalation", GONE),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.capabilities.add", ["SYS_ADMIN"]),
    ("it_has_no", "StatefulSet", CONTAINER + "securityContext.capabilities.drop", []),
    ("its_memory", "StatefulSet", CONTAINER + "resources.limits", GONE),
    ("its_memory", "StatefulSet", CONTAINER + "resources.limits.memory", GONE),
    ("its_memory", "StatefulSet", CONTAINER + "resources.limits.memory", "512Mi"),
    ("its_memory", "StatefulSet", CONTAINER + "resources.requests", GONE),
    ("only_who_should", "NetworkPolicy", "spec.policyTypes", ["Ingress"]),
    ("only_who_should", "NetworkPolicy", "spec.egress", [{}]),
    ("only_who_should", "NetworkPolicy", "spec.ingress", [{}]),
    ("only_who_should", "NetworkPolicy", "spec.ingress.0.from", GONE),
    ("only_who_should", "NetworkPolicy", "spec.ingress.0.from", []),
    ("only_who_should", "NetworkPolicy", "spec.ingress.0.from.0.podSelector", GONE),
    (
        "only_who_should",
        "NetworkPolicy",
        "spec.ingress.0.from",
        [
            {"namespaceSelector": {}},
            {"podSelector": {"matchLabels": {"dynmesh-client": "true"}}},
        ],
    ),
    ("only_who_should", "NetworkPolicy", "spec.ingress.0.ports", GONE),
    ("only_who_should", "NetworkPolicy", "spec.ingress.1.from.0.namespaceSelector", {}),
    ("only_who_should", "NetworkPolicy", "spec.ingress.1.ports.0.port", 7878),
    ("only_who_may", "StatefulSet", CONTAINER + "args.3", "--log-level=info"),
    ("only_who_may", "StatefulSet", CONTAINER + "args.5", "--insecure-listen=true"),
]


def changed(kind, path, value):
    """The manifests, with that at `path` of the one of `kind`."""
    documents = copy.deepcopy(DOCUMENTS)
    place = manifest(kind, documents)
    *steps, last = [int(step) if step.isdigit() else step for step in path.split(".")]
    for step in steps:
        place = place[step]
    if value is GONE:
        del place[last]
    else:
        place[last] = value
    return documents


class BrokenPromises(unittest.TestCase):
    def test_the_test_named_notices(self):
        for test, *change in WORSE:
            with self.subTest(test=test, change=change):
                broken = type("Broken", (Kubernetes,), {"documents": changed(*change)})
                result = unittest.TestResult()
                unittest.defaultTestLoader.loadTestsFromTestCase(broken).run(result)
                failed = [case.id().rsplit(".")[-1] for case, _ in result.failures + result.errors]
                self.assertTrue([f for f in failed if f.startswith(f"test_{test}")], failed)
                # The promise is what is broken, not the reading of the manifests.
                self.assertLess(len(failed), result.testsRun / 2, failed)

    def test_every_test_is_named(self):
        names = [name for name in dir(Kubernetes) if name.startswith("test_")]
        for name in names:
            self.assertTrue([w for w in WORSE if name.startswith(f"test_{w[0]}")], name)
