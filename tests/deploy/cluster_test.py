"""The files of deploy/cluster, read strictly: that they parse, that ports, names, flags and probes
agree with each other and with dynmeshd, and that a drain has its time.

    cluster_test.py DYNMESHD
"""

import re
import subprocess
import sys
import unittest

from deployed_files import DEPLOY, SOURCE, drain_seconds, flags_in, flags_of_daemon, load_all

CLUSTER = DEPLOY / "cluster"
NODES = ("node-a", "node-b", "node-c")
DATABASES = ("database-a", "database-b", "database-c")
POD_DATABASES = ("database-0", "database-1", "database-2")
SCRIPTS = ("start.sh", "init.sh")


def values_of(words):
    """The flags that are written --name=value, or alone."""
    pairs = (word.split("=", 1) for word in words)
    return {pair[0]: pair[1] if len(pair) == 2 else None for pair in pairs}


def hosts_of(journal):
    (hosts,) = re.fullmatch(r"postgresql://dynmesh@([^/]+)/dynmesh", journal).groups()
    return hosts.split(",")


def variables_of(script):
    """What it takes from its environment."""
    return set(re.findall(r"\$\{?([A-Z][A-Z_]+)", (CLUSTER / "postgres" / script).read_text()))


def paths_served():
    """What dynmeshd answers over HTTP."""
    text = (SOURCE / "server/http/metrics_http.cc").read_text()
    return set(re.findall(r'request\.path == "(/[a-z]+)"', text))


class Scripts(unittest.TestCase):
    def test_bash_reads_them(self):
        for script in SCRIPTS:
            path = CLUSTER / "postgres" / script
            self.assertEqual(path.stat().st_mode & 0o111, 0o111, script)
            self.assertIn("set -euo pipefail", path.read_text())
            subprocess.run(["bash", "-n", path], check=True, timeout=60)

    def test_each_primary_may_ask_each_other_server(self):
        text = (CLUSTER / "postgres/init.sh").read_text()
        self.assertIn("synchronous_standby_names = 'ANY 1 (${names#, })'", text)
        self.assertIn('"%s"\' "${nodes[@]}"', text)
        self.assertIn('application_name=$NODE_NAME', (CLUSTER / "postgres/start.sh").read_text())

    def test_connections_of_all_servers_have_room(self):
        text = (CLUSTER / "postgres/start.sh").read_text()
        most = int(re.search(r"max_connections=(\d+)", text)[1])
        header = (SOURCE / "server/journal/open_postgres.h").read_text()
        each = sum(int(n) for n in re.findall(r"(?:writing|reading)_connections = (\d+);", header))
        # One more renews leases. The rest is for standbys, copies and people.
        self.assertGreaterEqual(most, 3 * (each + 1) + 20)


class Runbook(unittest.TestCase):
    def setUp(self):
        text = (DEPLOY / "RUNBOOK.md").read_text()
        self.text = text.split("## Several servers and their database")[1].split("\n## ")[0]
        self.sources = "".join(
            path.read_text() for path in (SOURCE / "server").rglob("*") if path.is_file()
        )

    def test_what_one_sees_is_there(self):
        # Metrics are looked at by deployment_test.py.
        words = re.findall(r"`([a-z]+(?:_[a-z]+)+)`", self.text)
        events = {word for word in words if not word.startswith("dynmesh_")}
        self.assertGreater(len(events), 8)
        for event in events:
            self.assertIn(f'"{event}"', self.sources)

    def test_alerts_are_there(self):
        (file,) = load_all(DEPLOY / "alerts.yml")
        names = {rule["alert"] for rule in file["groups"][0]["rules"]}
        told = set(re.findall(r"\bDynmesh[A-Za-z]+", self.text))
        self.assertGreater(len(told), 2)
        self.assertLessEqual(told, names)

    def test_columns_are_those_of_the_schema(self):
        for column in ("address", "owner", "id"):
            self.assertRegex(self.sources, rf"\b{column} TEXT")
        self.assertIn("has been the primary", (CLUSTER / "postgres/start.sh").read_text())

    def test_what_not_copied_says_is_said(self):
        for words in ("a server uses it", "connections of dynmeshd", "has another mesh ",
                      "was read back ", "the lease of "):
            self.assertIn(words, self.sources)


class Compose(unittest.TestCase):
    def setUp(self):
        (self.file,) = load_all(CLUSTER / "compose.yaml")
        self.services = self.file["services"]

    def words_of(self, node):
        return [*self.services[node]["entrypoint"], *self.services[node]["command"]]

    def test_services_are_three_of_each_and_prometheus(self):
        self.assertEqual(set(self.services), {*NODES, *DATABASES, "prometheus"})

    def test_every_flag_is_one_of_dynmeshd(self):
        for node in NODES:
            words = self.words_of(node)
            self.assertEqual(words[0], "dynmeshd")
            self.assertTrue(all(word.startswith("--") for word in words[1:]), words)
            self.assertLessEqual(flags_in(words), flags_of_daemon())

    def test_a_node_is_where_its_address_says(self):
        for node in NODES:
            flags = values_of(self.words_of(node)[1:])
            self.assertEqual(flags["--node-address"], node)
            port = flags["--listen"].removeprefix("0.0.0.0:")
            # The same inside and outside: clients go where NOT_OWNER says.
            self.assertEqual(self.services[node]["ports"], [f"127.0.0.1:{port}:{port}"])
        ports = [port for node in NODES for port in self.services[node]["ports"]]
        self.assertEqual(len(set(ports)), len(NODES))

    def test_all_nodes_have_one_journal_and_one_lease(self):
        for node in NODES:
            flags = values_of(self.words_of(node)[1:])
            self.assertEqual(hosts_of(flags["--journal"]), list(DATABASES))
            self.assertEqual(flags["--lease"], "3")
            self.assertNotIn("--data-dir", flags)
            self.assertEqual(
                self.services[node]["environment"], {"PGPASSWORD": "${DATABASE_PASSWORD:?}"}
            )

    def test_the_comment_names_the_ports_and_variables(self):
        text = (CLUSTER / "compose.yaml").read_text()
        example = ",".join(
            f"{n}:{values_of(self.words_of(n)[1:])['--listen'].split(':')[1]}" for n in NODES
        )
        self.assertIn(f"--server {example}", text)
        for variable in re.findall(r"\$\{([A-Z_]+):\?\}", text):
            self.assertRegex(text, rf"#   {variable}=")

    def test_it_has_no_rights_and_may_drain(self):
        for node in NODES:
            service = self.services[node]
            self.assertTrue(service["read_only"])
            self.assertEqual(service["cap_drop"], ["ALL"])
            self.assertEqual(service["security_opt"], ["no-new-privileges:true"])
            self.assertGreater(int(service["stop_grace_period"].removesuffix("s")), drain_seconds())

    def test_databases_are_alike_but_for_their_names(self):
        for name in DATABASES:
            service = self.services[name]
            self.assertEqual(service["image"], "postgres:15")
            self.assertEqual(service["user"], "postgres")
            self.assertEqual(service["entrypoint"], ["bash", "/scripts/start.sh"])
            environment = service["environment"]
            self.assertEqual(environment["NODE_NAME"], name)
            self.assertEqual(environment["NODES"].split(), list(DATABASES))
            self.assertNotIn("ports", service)
            self.assertIn(f"{name}:/var/lib/postgresql/data", service["volumes"])
            self.assertIn(name, self.file["volumes"])
            self.assertEqual(service["healthcheck"]["test"][:2], ["CMD", "pg_isready"])
            # PGDATA is of the image.
            needed = variables_of("start.sh") | variables_of("init.sh")
            needed -= {"PGDATA", "DOMAIN", "PRIMARY_ADDRESS"}
            self.assertLessEqual(needed, set(environment))

    def test_ports_are_loopbacks_and_files_are_there(self):
        for service in self.services.values():
            for port in service.get("ports", []):
                self.assertTrue(port.startswith("127.0.0.1:"), port)
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("."):
                    self.assertTrue((CLUSTER / source).exists(), source)
                else:
                    self.assertIn(source, self.file["volumes"])
            self.assertIn("max-size", service["logging"]["options"])
        self.assertTrue((CLUSTER / self.services["node-a"]["build"] / "Dockerfile").exists())

    def test_prometheus_asks_each_node_where_it_answers(self):
        (config,) = load_all(CLUSTER / "prometheus.yml")
        (job,) = config["scrape_configs"]
        # The name that alerts.yml asks for.
        self.assertEqual(job["job_name"], "dynmeshd")
        self.assertIn(f'job="{job["job_name"]}"', (DEPLOY / "alerts.yml").read_text())
        (targets,) = job["static_configs"]
        ports = {
            node: values_of(self.words_of(node)[1:])["--metrics"].split(":")[1] for node in NODES
        }
        self.assertEqual(targets["targets"], [f"{node}:{ports[node]}" for node in NODES])
        self.assertEqual(
            self.services["prometheus"]["image"],
            load_all(DEPLOY / "compose.yaml")[0]["services"]["prometheus"]["image"],
        )


class Kubernetes(unittest.TestCase):
    def setUp(self):
        self.documents = [
            m for path in sorted((CLUSTER / "kubernetes").glob("*.yaml")) for m in load_all(path)
        ]
        self.by_name = {(m["kind"], m["metadata"]["name"]): m for m in self.documents}
        self.sets = {
            name: self.by_name["StatefulSet", name]["spec"] for name in ("dynmeshd", "database")
        }
        self.containers = {
            name: the_set["template"]["spec"]["containers"][0]
            for name, the_set in self.sets.items()
        }
        self.flags = values_of(self.containers["dynmeshd"]["args"])

    def test_all_are_of_known_kinds_in_one_namespace(self):
        versions = {
            "Service": "v1",
            "StatefulSet": "apps/v1",
            "NetworkPolicy": "networking.k8s.io/v1",
            "PodDisruptionBudget": "policy/v1",
        }
        self.assertEqual(len(self.by_name), len(self.documents))
        for m in self.documents:
            self.assertEqual(m["apiVersion"], versions[m["kind"]])
            self.assertEqual(m["metadata"]["namespace"], "dynmesh")

    def test_selectors_find_the_pods(self):
        for name, the_set in self.sets.items():
            labels = the_set["template"]["metadata"]["labels"]
            self.assertEqual(labels, {"app": name})
            self.assertEqual(the_set["selector"], {"matchLabels": labels})
            self.assertEqual(the_set["serviceName"], name)
            service = self.by_name["Service", name]["spec"]
            self.assertEqual(service["selector"], labels)
            self.assertEqual(service["clusterIP"], "None")
            self.assertIs(service["publishNotReadyAddresses"], True)
            budget = self.by_name["PodDisruptionBudget", name]["spec"]
            self.assertEqual(budget["selector"], {"matchLabels": labels})
            self.assertEqual(budget["maxUnavailable"], 1)
            policy = self.by_name["NetworkPolicy", name]["spec"]
            self.assertEqual(policy["podSelector"], {"matchLabels": labels})
            self.assertEqual(policy["policyTypes"], ["Ingress", "Egress"])
            self.assertEqual(the_set["replicas"], 3)
        entry = self.by_name["Service", "dynmeshd-any"]["spec"]
        self.assertEqual(entry["selector"], {"app": "dynmeshd"})
        self.assertNotIn("publishNotReadyAddresses", entry)

    def test_every_flag_is_one_of_dynmeshd(self):
        container = self.containers["dynmeshd"]
        self.assertEqual(container["command"], ["dynmeshd"])
        self.assertLessEqual(flags_in(container["args"]), flags_of_daemon())
        self.assertNotIn("--insecure-listen", self.flags)

    def test_the_node_address_is_the_pods_name_in_its_service(self):
        host, port = self.flags["--node-address"].rsplit(":", 1)
        service = self.sets["dynmeshd"]["serviceName"]
        self.assertEqual(host, f"$(POD_NAME).{service}.dynmesh.svc.cluster.local")
        self.assertEqual(port, self.flags["--listen"].rsplit(":", 1)[1])
        names = {e["name"]: e["valueFrom"] for e in self.containers["dynmeshd"]["env"]}
        self.assertEqual(names["POD_NAME"], {"fieldRef": {"fieldPath": "metadata.name"}})
        # The certificate covers what clients and servers ask for.
        text = (CLUSTER / "kubernetes/dynmeshd.yaml").read_text()
        self.assertIn(f"# *.{service}.dynmesh.svc.cluster.local", text)
        self.assertIn("# dynmeshd-any.dynmesh.svc.cluster.local", text)

    def test_the_journal_names_every_database(self):
        environment = {e["name"]: e.get("value") for e in self.containers["database"]["env"]}
        domain = environment["DOMAIN"]
        self.assertEqual(domain, f".{self.sets['database']['serviceName']}")
        pods = [f"database-{i}" for i in range(self.sets["database"]["replicas"])]
        self.assertEqual(tuple(pods), POD_DATABASES)
        self.assertEqual(hosts_of(self.flags["--journal"]), [pod + domain for pod in pods])
        self.assertEqual(environment["NODES"].split(), pods)
        self.assertIn(environment["PRIMARY"], pods)
        needed = variables_of("start.sh") | variables_of("init.sh")
        self.assertLessEqual(needed - {"PRIMARY_ADDRESS"}, set(environment))

    def test_ports_agree(self):
        for name, container in self.containers.items():
            ports = {p["name"]: p["containerPort"] for p in container["ports"]}
            for service in (s for (kind, _), s in self.by_name.items() if kind == "Service"):
                if service["spec"]["selector"] != {"app": name}:
                    continue
                for port in service["spec"]["ports"]:
                    self.assertEqual(port["port"], ports[port["targetPort"]])
            allowed = {
                port["port"]
                for rule in self.by_name["NetworkPolicy", name]["spec"]["ingress"]
                for port in rule["ports"]
            }
            self.assertEqual(allowed, set(ports.values()))
        grpc, metrics = (self.flags[f].rsplit(":", 1)[1] for f in ("--listen", "--metrics"))
        ports = {p["name"]: str(p["containerPort"]) for p in self.containers["dynmeshd"]["ports"]}
        self.assertEqual(ports, {"grpc": grpc, "metrics": metrics})
        notes = self.sets["dynmeshd"]["template"]["metadata"]["annotations"]
        self.assertEqual(
            notes, {"prometheus.io/scrape": "true", "prometheus.io/port": metrics}
        )

    def test_the_servers_reach_what_they_ask(self):
        def reached(name):
            rules = self.by_name["NetworkPolicy", name]["spec"]["egress"]
            return {
                (next(iter(peer.values()))["matchLabels"].get("app", "names"), port["port"])
                for rule in rules
                for peer in rule["to"]
                for port in rule["ports"]
            }

        self.assertEqual(
            reached("dynmeshd"), {("dynmeshd", 7878), ("database", 5432), ("names", 53)}
        )
        self.assertEqual(reached("database"), {("database", 5432), ("names", 53)})

    def test_probes_ask_what_there_is(self):
        container = self.containers["dynmeshd"]
        paths = {"startup": "/readyz", "liveness": "/healthz", "readiness": "/readyz"}
        for probe, path in paths.items():
            asked = container[f"{probe}Probe"]["httpGet"]
            self.assertEqual(asked, {"path": path, "port": "metrics"})
            self.assertIn(path, paths_served())
            command = self.containers["database"][f"{probe}Probe"]["exec"]["command"]
            self.assertEqual(command[0], "pg_isready")
        for name in self.containers:
            alive = self.containers[name]["livenessProbe"]
            self.assertGreaterEqual(alive["periodSeconds"] * alive.get("failureThreshold", 3), 30)

    def test_it_may_drain(self):
        pod = self.sets["dynmeshd"]["template"]["spec"]
        self.assertGreater(pod["terminationGracePeriodSeconds"], drain_seconds())

    def test_secrets_are_those_that_the_comment_makes(self):
        text = (CLUSTER / "kubernetes/dynmeshd.yaml").read_text()
        made = {}
        commands = "\n".join(
            line.removeprefix("#").strip() for line in text.splitlines() if line.startswith("#")
        ).replace("\\\n", " ")
        for words in (line.split() for line in commands.splitlines()):
            if "create" in words and "namespace" not in words:
                name = words[words.index("create") + (3 if "secret" in words else 2)]
                keys = {word.split("=")[1] for word in words if word.startswith("--from-")}
                made[name] = keys
        self.assertEqual(
            set(made),
            {"dynmesh-tls", "dynmesh-tokens", "dynmesh-database", "dynmesh-postgres"},
        )
        for name, the_set in self.sets.items():
            for variable in self.containers[name]["env"]:
                source = variable.get("valueFrom", {}).get("secretKeyRef")
                if source:
                    self.assertIn(source["key"], made[source["name"]])
            for volume in the_set["template"]["spec"]["volumes"]:
                if "secret" in volume:
                    self.assertIn(volume["secret"]["secretName"], made)
                if "configMap" in volume:
                    self.assertIn(volume["configMap"]["name"], made)
        for flag in ("--tls-cert", "--tls-key", "--node-ca"):
            folder, file = self.flags[flag].rsplit("/", 1)
            self.assertEqual(folder, "/etc/dynmesh/tls")
            self.assertIn(file, made["dynmesh-tls"])

    def test_what_is_mounted_is_there(self):
        for name, the_set in self.sets.items():
            volumes = {v["name"] for v in the_set["template"]["spec"]["volumes"]}
            volumes |= {v["metadata"]["name"] for v in the_set.get("volumeClaimTemplates", [])}
            mounts = self.containers[name]["volumeMounts"]
            self.assertEqual({m["name"] for m in mounts}, volumes)
            for mount in mounts:
                if "subPath" in mount:
                    self.assertIn(mount["subPath"], SCRIPTS)
        paths = [m["mountPath"] for m in self.containers["dynmeshd"]["volumeMounts"]]
        for flag, value in self.flags.items():
            if value.startswith("/"):
                self.assertTrue(any(f"{value}/".startswith(f"{p}/") for p in paths), flag)

    def test_it_has_no_rights_and_bounded_memory(self):
        for name, the_set in self.sets.items():
            pod = the_set["template"]["spec"]
            user = pod["securityContext"]["runAsUser"]
            self.assertGreater(user, 0)
            self.assertEqual(
                pod["securityContext"],
                {
                    "runAsNonRoot": True,
                    **{"runAsUser": user, "runAsGroup": user, "fsGroup": user},
                    "seccompProfile": {"type": "RuntimeDefault"},
                },
            )
            self.assertEqual(
                self.containers[name]["securityContext"],
                {
                    "allowPrivilegeEscalation": False,
                    "readOnlyRootFilesystem": True,
                    "capabilities": {"drop": ["ALL"]},
                },
            )
            self.assertIs(pod["automountServiceAccountToken"], False)
            self.assertIn("memory", self.containers[name]["resources"]["limits"])
            self.assertIn("cpu", self.containers[name]["resources"]["requests"])

    def test_images_are_ours_and_the_official_one(self):
        one_server = load_all(DEPLOY / "kubernetes/dynmeshd.yaml")
        (ours,) = [
            m["spec"]["template"]["spec"]["containers"][0]["image"]
            for m in one_server
            if m["kind"] == "StatefulSet"
        ]
        self.assertEqual(self.containers["dynmeshd"]["image"], ours)
        self.assertEqual(self.containers["database"]["image"], "postgres:15")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
