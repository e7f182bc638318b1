// The commands of `dynmesh` against a `dynmeshd` process: output, exit codes, the drain.
#include "client/cli/remote/remote_commands.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/run_dynmesh.h"
#include "tests/support/deadline.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::cli::remote_commands_test {
namespace {

namespace fs = std::filesystem;

std::size_t Lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

// The text of `key` in the last line of JSON that has it.
std::string Value(const std::string& json, const std::string& key) {
  const std::string mark = "\"" + key + "\":";
  const std::size_t at = json.rfind(mark);
  if (at == std::string::npos) return "";
  std::size_t begin = at + mark.size();
  while (json[begin] == ' ' || json[begin] == '"') ++begin;
  return json.substr(begin, json.find_first_of(",}\"", begin) - begin);
}

// With a dynmeshd in a folder of its own.
class DaemonFixture : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name)) << text;
    return Path(name);
  }

  void StartDaemon() { ASSERT_TRUE(daemon_.Start()) << daemon_.Log(); }
  Ran Remote(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--server", daemon_.address()});
    return RunDynmesh(std::move(arguments));
  }

  test::TempFolder folder_;
  test::Daemon daemon_{folder_.path()};
};

using RemoteCommandsTest = DaemonFixture;

constexpr char kScript[] =
    "mesh dim=2 box=0,0,1,1 rho=1.4142135623730951\n"
    "add point 1 0.2 0.2\nadd point 2 0.8 0.2\nadd segment 3 1 2\ncommit\n"
    "add point 4 0.5 0.7  # above\ncommit\n"
    "move point 4 0.5 0.8\nremove 3\n";

TEST_F(RemoteCommandsTest, AMeshFromCreationToExport) {
  StartDaemon();
  const std::string script = Write("s.txt", kScript);
  const Ran created = Remote({"create", "plate", "--like", script, "--json"});
  ASSERT_EQ(created.code, kExitDone) << created.err;
  EXPECT_EQ(Value(created.out, "mesh"), "plate");
  EXPECT_EQ(Value(created.out, "revision"), "0");
  EXPECT_EQ(Value(created.out, "hash").size(), 32u);

  const Ran applied = Remote({"apply", "plate", script, "--json"});
  ASSERT_EQ(applied.code, kExitDone) << applied.err;
  EXPECT_EQ(Lines(applied.out), 4u) << applied.out;
  EXPECT_EQ(Value(applied.out, "revisions"), "3");
  EXPECT_EQ(applied.err, "") << "progress on something that is no terminal";
  const std::string hash = Value(applied.out, "hash");

  const Ran listed = Remote({"list", "--json"});
  EXPECT_EQ(Lines(listed.out), 1u);
  EXPECT_EQ(Value(listed.out, "hash"), hash);
  const Ran stats = Remote({"stats", "plate", "--json"});
  EXPECT_EQ(Value(stats.out, "revision"), "3");
  EXPECT_EQ(Value(stats.out, "features"), "3");
  EXPECT_EQ(Value(stats.out, "hash"), hash);
  const Ran watched = Remote({"watch", "plate", "--until", "3", "--json"});
  EXPECT_EQ(watched.code, kExitDone) << watched.err;
  EXPECT_EQ(Value(watched.out, "hash"), hash);
  const Ran exported = Remote({"export", "plate", "-o", Path("out.node"), "--json"});
  ASSERT_EQ(exported.code, kExitDone) << exported.err;
  EXPECT_EQ(Value(exported.out, "hash"), hash);
  EXPECT_TRUE(fs::exists(Path("out.node")));
  EXPECT_TRUE(fs::exists(Path("out.ele")));
  EXPECT_EQ(Remote({"delete", "plate"}).code, kExitDone);
  EXPECT_EQ(Remote({"list"}).out, "");
}

TEST_F(RemoteCommandsTest, AMeshOfSpaceFromCreationToExport) {
  StartDaemon();
  const Ran created =
      Remote({"create", "room", "--dimension", "3", "--box", "0,0,0,4,4,4", "--json"});
  ASSERT_EQ(created.code, kExitDone) << created.err;
  EXPECT_EQ(Value(created.out, "dimension"), "3");
  EXPECT_EQ(Value(created.out, "rho"), "2");
  // A script without a first line has the mesh's dimension.
  const std::string edits =
      "add point 1 1 1 1\nadd point 2 3 1 1\nadd point 3 3 3 1\nadd point 4 1 3 1\n"
      "add polygon 5 1 2 3 4\ncommit\nadd size 6 box 0 0 0 1 1 1 0.5\nmove point 1 1 1.1 1\n";
  const Ran applied = Remote({"apply", "room", Write("e.txt", edits)});
  ASSERT_EQ(applied.code, kExitDone) << applied.err;
  EXPECT_NE(applied.out.find("tetrahedra"), std::string::npos);
  const std::string header = "mesh dim=3 box=0,0,0,4,4,4\n";
  const std::string whole = Write("w.txt", header + edits);
  const Ran again = Remote({"apply", "copy", whole, "--create", "--one-by-one", "--json"});
  ASSERT_EQ(again.code, kExitDone) << again.err;
  const Ran stats = Remote({"stats", "room", "--json"});
  EXPECT_EQ(Value(stats.out, "hash"), Value(again.out, "hash"));
  EXPECT_EQ(Value(stats.out, "dimension"), "3");
  EXPECT_NE(Remote({"stats", "room"}).out.find("subfacets"), std::string::npos);
  const Ran watched = Remote({"watch", "room", "--until", "2", "--json"});
  EXPECT_EQ(Value(watched.out, "hash"), Value(stats.out, "hash"));
  const Ran exported =
      Remote({"export", "room", "-o", Path("r.node"), "-o", Path("r.svg"), "--cut", "z=1.5"});
  ASSERT_EQ(exported.code, kExitDone) << exported.err;
  EXPECT_TRUE(fs::exists(Path("r.face")));
  // Not 2D, and not converted to it.
  const Ran flat = Remote({"apply", "room", Write("f.txt", kScript)});
  EXPECT_EQ(flat.code, kExitBadInput);
  EXPECT_NE(flat.err.find("2 dimensions"), std::string::npos) << flat.err;
  EXPECT_EQ(Remote({"create", "x", "--dimension", "2", "--like", whole}).code, kExitBadInput);
  EXPECT_EQ(Remote({"create", "x", "--dimension", "3", "--box", "0,0,1,1"}).code, kExitBadInput);
}

TEST_F(RemoteCommandsTest, ExportAndWatchTakePolygonsOnly) {
  StartDaemon();
  const std::string script = Write("p.txt",
                                   "mesh dim=2 box=0,0,1,1 rho=1.4142\n"
                                   "add point 1 0.2 0.2\nadd point 2 0.7 0.2\n"
                                   "add point 3 0.7 0.7\nadd point 4 0.2 0.7\n"
                                   "add polygon 9 1 2 3 4\ncommit\n");
  ASSERT_EQ(Remote({"apply", "plate", script, "--create"}).code, kExitDone);
  const auto count = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments = {"export", "plate", "-o", Path("part.node"), "--json"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const Ran ran = Remote(arguments);
    EXPECT_EQ(ran.code, kExitDone) << ran.err;
    return std::stoi(Value(ran.out, "simplices"));
  };
  const int inside = count({"--region", "7,9"});
  EXPECT_GT(inside, 1);
  EXPECT_LT(inside, count({}));
  EXPECT_EQ(count({"--region", "any"}), inside);
  ASSERT_EQ(Remote({"create", "bare", "--box", "0,0,1,1"}).code, kExitDone);
  const Ran bare = Remote({"export", "bare", "-o", Path("bare.node"), "--region", "any"});
  EXPECT_EQ(bare.code, kExitBadInput);
  EXPECT_NE(bare.err.find("the mesh has no polygons"), std::string::npos) << bare.err;
  // The help offers what there is.
  EXPECT_NE(Remote({"export", "--help"}).out.find("ID[,ID...]|any"), std::string::npos);
  EXPECT_EQ(Remote({"watch", "--help"}).out.find("|any"), std::string::npos);
  const Ran none = Remote({"export", "plate", "-o", Path("none.node"), "--region", "7"});
  EXPECT_EQ(none.code, kExitBadInput);
  EXPECT_NE(none.err.find("lies in polygon 7; the mesh has polygon(s) 9"), std::string::npos)
      << none.err;
  EXPECT_FALSE(std::filesystem::exists(Path("none.node")));
  const Ran watched = Remote(
      {"watch", "plate", "--region", "9", "--until", "1", "--json", "-o", Path("watched.node")});
  EXPECT_EQ(watched.code, kExitDone) << watched.err;
  EXPECT_EQ(Value(watched.out, "simplices"), std::to_string(inside));
  count({"--region", "9"});
  std::ostringstream part, replica;
  part << std::ifstream(Path("part.ele")).rdbuf();
  replica << std::ifstream(Path("watched.ele")).rdbuf();
  EXPECT_EQ(replica.str(), part.str());
  for (const char* bad : {"any", "0", "9,", "x", "18446744073709551615"}) {
    EXPECT_EQ(Remote({"watch", "plate", "--region", bad}).code, kExitBadInput) << bad;
  }
}

TEST_F(RemoteCommandsTest, ApplyingAgainWithTheSamePrefixRepeatsNothing) {
  StartDaemon();
  const std::string script = Write("s.txt", kScript);
  const Ran first =
      Remote({"apply", "plate", script, "--create", "--request-prefix", "p", "--json"});
  ASSERT_EQ(first.code, kExitDone) << first.err;
  const Ran again =
      Remote({"apply", "plate", script, "--request-prefix", "p", "--one-by-one", "--json"});
  ASSERT_EQ(again.code, kExitDone) << again.err;
  EXPECT_EQ(Value(again.out, "replayed"), "3");
  EXPECT_EQ(Value(again.out, "hash"), Value(first.out, "hash"));
  EXPECT_NE(Value(again.out, "p50_microseconds"), "");
  EXPECT_EQ(Value(Remote({"stats", "plate", "--json"}).out, "revision"), "3");
}

// The server is killed in the middle, and is back at its address with its journal.
TEST_F(RemoteCommandsTest, ApplyWithAPrefixAndWatchGoOnAfterARestart) {
  const std::vector<std::string> flags = {"--data-dir", Path("data")};
  ASSERT_TRUE(daemon_.Start(flags)) << daemon_.Log();
  constexpr int kBatches = 300;
  std::string text = "mesh dim=2 box=0,0,1,1 rho=1.4142135623730951\n";
  for (int i = 1; i <= kBatches; ++i) {
    absl::StrAppend(&text, "add point ", i, " ", 0.003 * i, " ", 0.1 + 0.003 * (i * 7 % kBatches),
                    "\ncommit\n");
  }
  const std::string script = Write("long.txt", text);
  client::ClientOptions own;
  own.own_connection = true;
  for (const std::string mesh : {"streamed", "one-by-one"}) {
    SCOPED_TRACE(mesh);
    ASSERT_EQ(Remote({"create", mesh, "--like", script}).code, kExitDone);
    const auto client = client::MeshClient::Connect(daemon_.address(), own);
    const auto watch = client->Watch(mesh, {}, nullptr);
    std::vector<std::string> apply = {"apply", mesh, script, "--request-prefix", "p", "--quiet"};
    if (mesh == "one-by-one") apply.push_back("--one-by-one");
    Ran applied;
    std::thread applying([&] { applied = Remote(apply); });
    // In this thread: a server ends with the thread that started it.
    EXPECT_TRUE(watch->WaitForRevision(20, absl::Minutes(1)));
    daemon_.End(SIGKILL);
    EXPECT_TRUE(daemon_.Start(flags, daemon_.address().c_str())) << daemon_.Log();
    applying.join();
    EXPECT_EQ(applied.code, kExitDone) << applied.err;
    EXPECT_TRUE(watch->WaitForRevision(kBatches, absl::Minutes(1)));
    EXPECT_EQ(Value(Remote({"stats", mesh, "--json"}).out, "revision"), std::to_string(kBatches));
  }
}

// The server starts two seconds after the command. It has no journal: the mesh is made anew.
TEST_F(RemoteCommandsTest, ApplyWithAPrefixWaitsForAServerThatIsNotThereYet) {
  StartDaemon();
  const std::string address = daemon_.address();
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  const std::string script = Write("s.txt", kScript);
  const Ran without = RunDynmesh({"apply", "m", script, "--create", "--server", address});
  EXPECT_EQ(without.code, kExitFailed) << without.err;
  for (const std::string mesh : {"streamed", "one-by-one"}) {
    SCOPED_TRACE(mesh);
    std::vector<std::string> apply = {"apply", mesh,       script, "--create", "--request-prefix",
                                      "p",     "--server", address};
    if (mesh == "one-by-one") apply.push_back("--one-by-one");
    Ran applied;
    std::thread applying([&] { applied = RunDynmesh(apply); });
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_TRUE(daemon_.Start({}, address.c_str())) << daemon_.Log();
    applying.join();
    EXPECT_EQ(applied.code, kExitDone) << applied.err;
    EXPECT_EQ(daemon_.End(SIGTERM), 0);
  }
}

// A batch that takes longer than the server has for its end.
TEST_F(RemoteCommandsTest, WhatADrainInterruptsSaysSoAndHowToGoOn) {
  std::string text = "mesh dim=2 box=0,0,1,1 rho=1.4142135623730951\nadd point 1 .5 .5\ncommit\n";
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.01, 0.99);
  for (int i = 2; i <= 300'000; ++i) {
    absl::StrAppend(&text, "add point ", i, " ", unit(random), " ", unit(random), "\n");
  }
  const std::string script = Write("long.dynmesh", text);
  ASSERT_TRUE(daemon_.Start({"--drain-timeout", "0"})) << daemon_.Log();
  const auto client = client::MeshClient::Connect(daemon_.address());
  ASSERT_TRUE(client->CreateMesh("m", {}).ok());
  Ran applied;
  std::thread applying([&] { applied = Remote({"apply", "m", script}); });
  test::WaitUntil("the first batch", [&] { return client->GetMesh("m")->revision >= 1; });
  daemon_.End(SIGTERM);
  applying.join();
  EXPECT_EQ(applied.code, kExitFailed) << applied.err;
  EXPECT_NE(applied.err.find("long.dynmesh:4: "), std::string::npos) << applied.err;
  EXPECT_NE(applied.err.find("DRAINING"), std::string::npos) << applied.err;
  EXPECT_NE(applied.err.find("; 1 of 2 batches are known to be applied. With --request-prefix"),
            std::string::npos)
      << applied.err;
}

TEST_F(RemoteCommandsTest, ErrorsNameTheLineAndHaveTheirExitCodes) {
  StartDaemon();
  const std::string bad = Write("bad.txt",
                                "mesh dim=2 box=0,0,1,1 rho=1.5\n"
                                "add point 1 0.2 0.2\ncommit\n"
                                "add point 2 0.3 0.3\nremove 77\ncommit\n"
                                "add point 5 0.4 0.4\n");
  for (const char* way : {"--quiet", "--one-by-one"}) {
    const Ran ran = Remote({"apply", way[2] == 'q' ? "q" : "o", bad, "--create", way});
    EXPECT_EQ(ran.code, kExitBadInput);
    EXPECT_NE(ran.err.find("bad.txt:5: "), std::string::npos) << ran.err;
    EXPECT_NE(ran.err.find("77"), std::string::npos) << ran.err;
    EXPECT_EQ(Value(Remote({"stats", way[2] == 'q' ? "q" : "o", "--json"}).out, "revision"), "1");
  }
  // With the reason by which the runbook is sorted.
  const Ran none = Remote({"delete", "none"});
  EXPECT_EQ(none.code, kExitBadInput);
  EXPECT_NE(none.err.find(" (MESH_NOT_FOUND)\n"), std::string::npos) << none.err;
  EXPECT_EQ(Remote({"stats", "none"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"watch", "none"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"create", "Plate", "--box", "0,0,1,1"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"create", "plate"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"export", "q", "-o", Path("out.xyz")}).code, kExitBadInput);
  EXPECT_EQ(Remote({"apply", "q", Path("absent.txt")}).code, kExitBadInput);
  EXPECT_EQ(RunDynmesh({"list", "--nonsense"}).code, kExitBadInput);
  EXPECT_EQ(RunDynmesh({}).code, kExitBadInput);
  const std::string live = daemon_.address();
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  const Ran unreachable = RunDynmesh({"list", "--server", live});
  EXPECT_EQ(unreachable.code, kExitFailed);
  EXPECT_NE(unreachable.err, "");
}

TEST_F(RemoteCommandsTest, AFileIsLoadedAsOneRevisionAndKept) {
  const std::vector<std::string> keep = {"--data-dir", Path("data")};
  ASSERT_TRUE(daemon_.Start(keep)) << daemon_.Log();
  std::string edits = "mesh dim=2 box=0,0,1,1 rho=1.4142135623730951\n";
  std::string nodes = "3000 2 0 0\n";
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.01, 0.99);
  for (int i = 1; i <= 3000; ++i) {
    const std::string place = absl::StrCat(unit(random), " ", unit(random));
    absl::StrAppend(&edits, "add point ", i, " ", place, "\n");
    absl::StrAppend(&nodes, i, " ", place, "\n");
  }
  const std::string script = Write("points.dynmesh", edits), file = Write("points.node", nodes);
  const Ran loaded = Remote({"load", "a", script, "--create", "--request-id", "l1", "--json"});
  ASSERT_EQ(loaded.code, kExitDone) << loaded.err;
  EXPECT_EQ(Lines(loaded.out), 1u);
  EXPECT_EQ(loaded.err, "") << "progress on something that is no terminal";
  EXPECT_EQ(Value(loaded.out, "event"), "loaded");
  EXPECT_EQ(Value(loaded.out, "revision"), "1");
  EXPECT_EQ(Value(loaded.out, "features"), "3000");
  const Ran applied = Remote({"apply", "b", script, "--create", "--quiet", "--json"});
  ASSERT_EQ(applied.code, kExitDone) << applied.err;
  EXPECT_EQ(Value(loaded.out, "hash"), Value(applied.out, "hash"));
  // Again, over a restart.
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  ASSERT_TRUE(daemon_.Start(keep)) << daemon_.Log();
  const Ran again = Remote({"load", "a", script, "--request-id", "l1", "--json"});
  ASSERT_EQ(again.code, kExitDone) << again.err;
  EXPECT_EQ(Value(again.out, "event"), "replayed");
  EXPECT_EQ(Value(again.out, "hash"), Value(loaded.out, "hash"));
  // Another kind of file, text for people.
  ASSERT_EQ(Remote({"create", "c", "--box", "0,0,1,1"}).code, kExitDone);
  const Ran of_nodes = Remote({"load", "c", file, "--expected-revision", "0"});
  ASSERT_EQ(of_nodes.code, kExitDone) << of_nodes.err;
  EXPECT_NE(of_nodes.out.find("revision 1: 3000 features loaded in "), std::string::npos);
  EXPECT_NE(of_nodes.out.find(Value(loaded.out, "hash")), std::string::npos) << of_nodes.out;
}

TEST_F(RemoteCommandsTest, ALoadPreparesItsInputAsMeshDoes) {
  StartDaemon();
  // Two tetrahedra that cross: four faces of each.
  const std::string off = Write("crossed.off",
                                "OFF\n8 8 0\n0 0 0\n4 0 0\n0 4 0\n0 0 4\n"
                                "1 1 -1\n1.5 1 3\n1 1.5 3\n1.2 1.1 3\n"
                                "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
                                "3 4 6 5\n3 4 5 7\n3 4 7 6\n3 5 6 7\n");
  const Ran exact = Remote({"load", "m", off, "--create", "--exact"});
  EXPECT_EQ(exact.code, kExitBadInput);
  EXPECT_EQ(Value(Remote({"stats", "m", "--json"}).out, "revision"), "0");
  const Ran loaded = Remote({"load", "m", off, "--json"});
  ASSERT_EQ(loaded.code, kExitDone) << loaded.err;
  EXPECT_NE(loaded.err.find("crossed.off: mended: "), std::string::npos) << loaded.err;
  const Ran made = RunDynmesh({"mesh", off, "--surroundings", "-o", Path("m.vtu"), "--json"});
  ASSERT_EQ(made.code, kExitDone) << made.err;
  EXPECT_EQ(Value(loaded.out, "hash"), Value(made.out, "hash"));
}

TEST_F(RemoteCommandsTest, ALoadThatIsRefusedSaysWhere) {
  StartDaemon();
  const std::string header = "mesh dim=2 box=0,0,1,1 rho=1.5\n";
  const std::string bad = Write(
      "bad.dynmesh", header + "add point 1 0.2 0.2\nadd point 2 0.3 0.3\nadd point 7 0.2 0.2\n");
  const Ran refused = Remote({"load", "m", bad, "--create"});
  EXPECT_EQ(refused.code, kExitBadInput);
  EXPECT_NE(refused.err.find("bad.dynmesh:4: "), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("(DUPLICATE_POINT)"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("`dynmesh delete m` deletes it"), std::string::npos) << refused.err;
  EXPECT_EQ(Value(Remote({"stats", "m", "--json"}).out, "revision"), "0");
  const std::string good = Write("good.dynmesh", header + "add point 1 0.2 0.2\n");
  EXPECT_EQ(Remote({"load", "m", good, "--expected-revision", "3"}).code, kExitFailed);
  EXPECT_EQ(Remote({"load", "none", good}).code, kExitBadInput);
  EXPECT_EQ(Remote({"load", "m", Path("absent.node")}).code, kExitBadInput);
  const std::string space =
      Write("s.dynmesh", "mesh dim=3 box=0,0,0,1,1,1\nadd point 1 .2 .2 .2\n");
  const Ran flat = Remote({"load", "m", space});
  EXPECT_EQ(flat.code, kExitBadInput);
  EXPECT_NE(flat.err.find("3 dimensions"), std::string::npos) << flat.err;
  EXPECT_EQ(Remote({"load", "room", space, "--create"}).code, kExitDone);
  EXPECT_EQ(Remote({"load", "m", good}).code, kExitDone);
}

TEST_F(RemoteCommandsTest, StatsAreWatchedAsOftenAsAsked) {
  StartDaemon();
  const std::string script = Write("s.txt", kScript);
  ASSERT_EQ(Remote({"apply", "plate", script, "--create"}).code, kExitDone);
  ASSERT_EQ(Remote({"create", "room", "--box", "0,0,1,1"}).code, kExitDone);
  const Ran json = Remote({"stats", "--watch", "0.05", "--count", "3", "--json"});
  ASSERT_EQ(json.code, kExitDone) << json.err;
  ASSERT_EQ(Lines(json.out), 3u) << json.out;
  EXPECT_NE(json.out.find("\"mesh\": \"plate\", \"revision\": 3"), std::string::npos) << json.out;
  EXPECT_EQ(Value(json.out, "mesh"), "room");
  // No rate before there are two samples of a mesh; none of these changes.
  const std::string first = json.out.substr(0, json.out.find('\n'));
  EXPECT_EQ(Value(first, "edits_per_second"), "null");
  EXPECT_EQ(std::stod(Value(json.out, "edits_per_second")), 0);

  const Ran table = Remote({"stats", "plate", "--watch=0.05", "--count", "2"});
  ASSERT_EQ(table.code, kExitDone) << table.err;
  EXPECT_EQ(table.out.find("mesh "), 0u) << table.out;
  EXPECT_EQ(Lines(table.out), 5u) << table.out;  // twice a head and a row, a line between
  EXPECT_EQ(table.out.find("room"), std::string::npos) << table.out;
  EXPECT_EQ(table.out.find('\033'), std::string::npos) << table.out;

  EXPECT_EQ(Remote({"stats", "--watch", "no", "--count", "1"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"stats", "--watch", "0", "--count", "1"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"stats", "--count", "1"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"stats", "none", "--watch", "--count", "1"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"stats", "x.node", "--watch"}).code, kExitBadInput);
  EXPECT_EQ(Remote({"stats", "--watch", "--count", "1", "--tls-ca", "none"}).code, kExitBadInput);
}

TEST_F(RemoteCommandsTest, WatchedStatsEndWellWithASignal) {
  StartDaemon();
  for (const int signal : {SIGINT, SIGTERM}) {
    // Sent to this thread: others of this process do not block it.
    const pthread_t self = pthread_self();
    std::thread later([self, signal] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      pthread_kill(self, signal);
    });
    const Ran ran = Remote({"stats", "--watch", "0.02"});
    later.join();
    EXPECT_EQ(ran.code, kExitDone) << ran.err;
    EXPECT_GE(Lines(ran.out), 2u);
  }
}

TEST_F(RemoteCommandsTest, TheDaemonSaysThatItsMeshesAreInMemoryAndDrainsOnSigterm) {
  StartDaemon();
  const std::string script = Write("s.txt", kScript);
  ASSERT_EQ(Remote({"apply", "plate", script, "--create"}).code, kExitDone);
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  const std::string log = daemon_.Log();
  EXPECT_NE(log.find("meshes live in memory only"), std::string::npos) << log;
  EXPECT_NE(log.find("event=mesh_created mesh=plate"), std::string::npos) << log;
  EXPECT_NE(log.find("event=drained complete=1"), std::string::npos) << log;
}

TEST_F(RemoteCommandsTest, TheDaemonRefusesBadFlags) {
  const auto exit_code = [](const char* flag, const char* value) {
    const pid_t pid = fork();
    if (pid == 0) {
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execl(DYNMESHD_BINARY, "dynmeshd", flag, value, static_cast<char*>(nullptr));
      _exit(127);
    }
    return WEXITSTATUS(test::WaitForEnd(pid));
  };
  EXPECT_EQ(exit_code("--no-such-flag", "1"), 2);
  EXPECT_EQ(exit_code("--max-meshes", "0"), 2);
  EXPECT_EQ(exit_code("--log-level", "loud"), 2);
}

}  // namespace
}  // namespace dynmesh::cli::remote_commands_test
