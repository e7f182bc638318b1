// dynmeshd with certificates and tokens, as a process, and the commands that use it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "absl/strings/str_split.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/run_dynmesh.h"
#include "tests/support/certificates.h"

namespace dynmesh::cli {
namespace {

class SecureDaemonTest : public ::testing::Test {
 protected:
  SecureDaemonTest() { unsetenv("DYNMESH_TOKEN"); }
  ~SecureDaemonTest() override { unsetenv("DYNMESH_TOKEN"); }

  std::string Path(const std::string& file) const { return folder_.path() + "/" + file; }
  std::string Write(const std::string& file, const std::string& text) const {
    test::WriteAtOnce(Path(file), text);
    return Path(file);
  }
  // With the flags of a client that has all it needs.
  Ran Run(std::vector<std::string> arguments, const std::string& token_file) const {
    arguments.insert(
        arguments.end(),
        {"--server", daemon_.address(), "--timeout", "20s", "--tls-ca", made_.Path("ca.pem"),
         "--tls-cert", made_.Path("client.pem"), "--tls-key", made_.Path("client.key")});
    if (!token_file.empty()) arguments.insert(arguments.end(), {"--token-file", token_file});
    return RunDynmesh(arguments);
  }

  test::Certificates made_;
  test::TempFolder folder_;
  test::Daemon daemon_{folder_.path()};
};

TEST_F(SecureDaemonTest, CommandsShowCertificateAndToken) {
  made_.MakeAuthority("ca");
  made_.Make("server", "ca");
  made_.Make("client", "ca");
  // What `dynmesh token` prints: the token, a comment, the server's line.
  const auto make_token = [&](const std::string& name, const std::string& role) {
    const Ran ran = RunDynmesh({"token", name, "--role", role, "--meshes", "crack-*"});
    EXPECT_EQ(ran.code, 0) << ran.err;
    const std::vector<std::string> lines = absl::StrSplit(ran.out, '\n');
    EXPECT_GE(lines.size(), 3u) << ran.out;
    Write(name, lines[0] + "\n");
    EXPECT_EQ(lines[2].find(lines[0]), std::string::npos);  // the server never gets it
    return lines[2] + "\n";
  };
  const std::string admin = make_token("admin", "admin"), reader = make_token("reader", "read");
  const std::string tokens = Write("tokens", admin + reader);
  const std::string conf =
      Write("conf", "tls-cert = \"" + made_.Path("server.pem") + "\"\ntls-key = \"" +
                        made_.Path("server.key") + "\"\ntls-client-ca = \"" + made_.Path("ca.pem") +
                        "\"\ntokens = \"" + tokens + "\"\n");
  ASSERT_TRUE(daemon_.Start({"--config", conf})) << daemon_.Log();

  const std::vector<std::string> create = {"create", "crack-1", "--box", "0,0,1,1"};
  const Ran without = Run(create, "");
  EXPECT_EQ(without.code, 2) << without.err;
  EXPECT_NE(without.err.find("DYNMESH_TOKEN"), std::string::npos) << without.err;
  const Ran as_reader = Run(create, Path("reader"));
  EXPECT_EQ(as_reader.code, 2);
  EXPECT_NE(as_reader.err.find("role admin"), std::string::npos) << as_reader.err;
  EXPECT_EQ(Run(create, Path("admin")).code, 0);
  EXPECT_EQ(Run({"create", "plate", "--box", "0,0,1,1"}, Path("admin")).code, 2);
  EXPECT_EQ(Run({"stats", "crack-1"}, Path("reader")).code, 0);
  setenv("DYNMESH_TOKEN", test::ReadAll(Path("reader")).c_str(), 1);
  EXPECT_EQ(Run({"stats", "crack-1"}, "").code, 0);
  // Without TLS a call does not get as far as the token check.
  EXPECT_EQ(RunDynmesh({"stats", "--server", daemon_.address(), "--timeout", "5"}).code, 1);
  for (const char* wrong : {"0", "-1s", "5 apples", "soon"}) {
    EXPECT_EQ(RunDynmesh({"stats", "--server", daemon_.address(), "--timeout", wrong}).code, 2)
        << wrong;
  }
  EXPECT_EQ(Run({"stats"}, Path("none")).code, 2);
  EXPECT_EQ(Run({"stats"}, Write("spoiled", "two words")).code, 2);

  // SIGHUP reads the tokens again, and ends nothing.
  Write("tokens", admin);
  daemon_.Signal(SIGHUP);
  int code = 0;
  for (int i = 0; i < 200 && code == 0; ++i) {
    code = Run({"stats"}, "").code;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(code, 2);
  EXPECT_EQ(Run({"stats"}, Path("admin")).code, 0);
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  const std::string log = daemon_.Log();
  EXPECT_EQ(log.find(test::ReadAll(Path("admin")).substr(0, 64)), std::string::npos);
}

TEST_F(SecureDaemonTest, WhatIsNotSafeOrNotThereIsRefusedWithCodeTwo) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& words) {
    EXPECT_FALSE(daemon_.Start(arguments)) << words;
    EXPECT_EQ(daemon_.exit_code(), 2) << words;
    EXPECT_NE(daemon_.Log().find(words), std::string::npos) << daemon_.Log();
  };
  refused({"--config", Write("bad", "max-mashes = 1\n")}, "max-mashes");
  refused({"--tls-cert", Path("no.pem"), "--tls-key", Path("no.key")}, "no.pem");
  refused({"--tls-cert", Path("no.pem")}, "tls-key");
  refused({"--tokens", Write("nonsense", "lab secret read=*\n")}, "line 1");
  EXPECT_EQ(daemon_.Log().find("secret"), std::string::npos);
}

// Recovery may take long; here it waits for a file that no process writes.
TEST_F(SecureDaemonTest, EndsAtOnceWhileItStarts) {
  const std::string never = Path("never");
  ASSERT_EQ(mkfifo(never.c_str(), 0600), 0);
  ASSERT_TRUE(daemon_.Spawn({"--config", never}));
  const int writer = open(never.c_str(), O_WRONLY);  // returns when it reads
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  close(writer);
  EXPECT_EQ(daemon_.Log().find("listening"), std::string::npos) << daemon_.Log();
}

TEST_F(SecureDaemonTest, ElsewhereThanOnLoopbackOnPurposeOnly) {
  EXPECT_FALSE(daemon_.Start({}, "0.0.0.0:0"));
  EXPECT_EQ(daemon_.exit_code(), 2);
  EXPECT_NE(daemon_.Log().find("--tls-cert"), std::string::npos) << daemon_.Log();
  EXPECT_NE(daemon_.Log().find("--insecure-listen"), std::string::npos) << daemon_.Log();
}

}  // namespace
}  // namespace dynmesh::cli
