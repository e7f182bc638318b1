// The command line and the configuration file of dynmeshd.
#include "server/flags.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>

#include "tests/support/certificates.h"
#include "tests/support/source_path.h"

namespace dynmesh::server::flags_test {
namespace {

const std::string kExample = test::SourcePath("deploy/dynmeshd.conf");

struct Parsed {
  std::unique_ptr<CLI::App> app = std::make_unique<CLI::App>();
  std::unique_ptr<Flags> flags = std::make_unique<Flags>();
  std::optional<int> code;
  std::string error;
};

Parsed Parse(std::vector<const char*> arguments) {
  Parsed parsed;
  arguments.insert(arguments.begin(), "dynmeshd");
  AddFlags(*parsed.app, *parsed.flags);
  testing::internal::CaptureStderr();
  parsed.code = ParseFlags(*parsed.app, static_cast<int>(arguments.size()), arguments.data());
  parsed.error = testing::internal::GetCapturedStderr();
  return parsed;
}

Parsed ParseFile(const std::string& text, std::vector<const char*> arguments = {}) {
  const test::TempFolder folder;
  const std::string path = folder.path() + "/conf";
  std::ofstream(path) << text;
  arguments.insert(arguments.end(), {"--config", path.c_str()});
  return Parse(arguments);
}

TEST(Flags, TheExampleHasEveryOptionAtItsDefault) {
  const Parsed bare = Parse({});
  const Parsed example = Parse({"--config", kExample.c_str()});
  ASSERT_FALSE(bare.code.has_value()) << bare.error;
  ASSERT_FALSE(example.code.has_value()) << example.error;
  int options = 0;
  for (const CLI::Option* option : bare.app->get_options()) {
    if (!option->get_configurable()) continue;
    const std::string name = option->get_single_name();
    const CLI::Option* const given = example.app->get_option("--" + name);
    ASSERT_EQ(given->count(), 1u) << name << " is not in the example";
    const std::string value = given->results().front();
    const std::string expected = option->get_default_str();
    const bool flag = option->get_items_expected_max() == 0;
    EXPECT_EQ(value, flag ? "false" : expected) << name;
    ++options;
  }
  EXPECT_GT(options, 25);
  // And the server gets its defaults.
  const ServerConfig &a = bare.flags->config, &b = example.flags->config;
  EXPECT_EQ(a.listen, b.listen);
  EXPECT_EQ(a.tls.enabled(), b.tls.enabled());
  EXPECT_EQ(a.tokens_file, b.tokens_file);
  EXPECT_EQ(bare.flags->data_dir, example.flags->data_dir);
  EXPECT_EQ(bare.flags->journal, example.flags->journal);
  EXPECT_EQ(a.history_bytes, b.history_bytes);
  EXPECT_EQ(a.journal_history_bytes, b.journal_history_bytes);
  EXPECT_EQ(a.idle_timeout, b.idle_timeout);
  EXPECT_EQ(a.batch_timeout, b.batch_timeout);
  EXPECT_EQ(a.send_timeout, b.send_timeout);
  EXPECT_EQ(a.compact_bytes, b.compact_bytes);
  EXPECT_EQ(a.compact_operations, b.compact_operations);
  EXPECT_EQ(a.drain_timeout, b.drain_timeout);
  EXPECT_EQ(a.max_requests_per_second, b.max_requests_per_second);
  EXPECT_EQ(a.insecure_listen, b.insecure_listen);
  EXPECT_TRUE(ValidateConfig(b).ok());
}

TEST(Flags, TheFileIsReadAndTheCommandLineGoesBeforeIt) {
  const Parsed p = ParseFile("max-meshes = 7\nmax-watchers = 8\nlisten = \"127.0.0.1:1\"\n",
                             {"--max-watchers", "9"});
  ASSERT_FALSE(p.code.has_value()) << p.error;
  EXPECT_EQ(p.flags->config.max_meshes, 7u);
  EXPECT_EQ(p.flags->config.max_watchers, 9u);
  EXPECT_EQ(p.flags->config.listen, "127.0.0.1:1");
}

TEST(Flags, WhatIsWrongIsNamed) {
  for (const auto& [text, word] :
       {std::pair{"max-mashes = 7\n", "max-mashes"}, std::pair{"[lab]\nmax-meshes = 7\n", "[lab]"},
        std::pair{"max-meshes = many\n", "max-meshes"}}) {
    const Parsed p = ParseFile(text);
    EXPECT_EQ(p.code, 2) << text;
    EXPECT_NE(p.error.find(word), std::string::npos) << p.error;
  }
  const Parsed none = Parse({"--config", "/no/such/file"});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.error.find("/no/such/file"), std::string::npos) << none.error;
}

// CLI11 would take -1 for 2^64 - 1, 0x10 for 16 and 1e3 for 1.
TEST(Flags, NumbersOutOfTheirRangeAreRefusedWithKeyValueAndLine) {
  const Parsed bare = Parse({});
  int numbers = 0;
  for (const CLI::Option* option : bare.app->get_options()) {
    if (option->get_type_name() != "UINT" && option->get_type_name() != "FLOAT") continue;
    const std::string key = option->get_single_name();
    for (const std::string value : {"-1", "many", "nan", "1e300", "99999999999999999999", "0x10"}) {
      if (option->get_type_name() == "FLOAT" && value == "0x10") continue;
      const Parsed flag = Parse({("--" + key + "=" + value).c_str()});
      EXPECT_EQ(flag.code, 2) << key << "=" << value;
      const std::string named = " level=error event=bad_option key=" + key + " value=" + value;
      EXPECT_NE(flag.error.find(named + " message=\"is not a "), std::string::npos) << flag.error;
      EXPECT_EQ(std::count(flag.error.begin(), flag.error.end(), '\n'), 1) << flag.error;
      const Parsed file =
          ParseFile("# " + key + " = 7\n\nlisten = \"localhost:0\"\n" + key + " = " + value + "\n");
      EXPECT_EQ(file.code, 2) << key << "=" << value;
      EXPECT_NE(file.error.find(named + " file="), std::string::npos) << file.error;
      EXPECT_NE(file.error.find("conf line=4 message="), std::string::npos) << file.error;
    }
    ++numbers;
  }
  EXPECT_GT(numbers, 25);
}

TEST(Flags, TimesHaveUnitsOrAreSeconds) {
  for (const auto& [text, time] :
       {std::pair{"8", absl::Seconds(8)}, std::pair{"8s", absl::Seconds(8)},
        std::pair{"0.5", absl::Milliseconds(500)}, std::pair{"500ms", absl::Milliseconds(500)},
        std::pair{"1h30m", absl::Minutes(90)}, std::pair{"0", absl::ZeroDuration()},
        std::pair{"24h", absl::Hours(24)}}) {
    const Parsed flag = Parse({(std::string("--send-timeout=") + text).c_str()});
    ASSERT_FALSE(flag.code.has_value()) << flag.error;
    EXPECT_EQ(flag.flags->config.send_timeout, time) << text;
    const Parsed file = ParseFile(std::string("send-timeout = ") + text + "\n");
    ASSERT_FALSE(file.code.has_value()) << file.error;
    EXPECT_EQ(file.flags->config.send_timeout, time) << text;
  }
  const Parsed bare = Parse({});
  int times = 0;
  for (const CLI::Option* option : bare.app->get_options()) {
    if (option->get_type_name() != "TIME") continue;
    const std::string key = option->get_single_name();
    EXPECT_FALSE(Parse({("--" + key + "=2s").c_str()}).code.has_value()) << key;
    for (const std::string value : {"-1", "-1s", "25h", "8x", "s", "1e300", "nan", "inf", "8s8"}) {
      const Parsed bad = Parse({("--" + key + "=" + value).c_str()});
      EXPECT_EQ(bad.code, 2) << key << "=" << value;
      EXPECT_NE(bad.error.find(" event=bad_option key=" + key + " value=" + value +
                               " message=\"is not a time from "),
                std::string::npos)
          << bad.error;
      EXPECT_NE(bad.error.find("to 24h: give seconds, or a unit, as 8s, 500ms or 10m"),
                std::string::npos)
          << bad.error;
    }
    ++times;
  }
  EXPECT_EQ(times, 11);
}

TEST(Flags, LimitsOfRangesAreTaken) {
  EXPECT_FALSE(Parse({"--drain-timeout=0", "--send-timeout=0", "--max-watchers=0",
                      "--max-memory-bytes=1000000000000000", "--max-message-bytes=2147483647",
                      "--max-requests-per-second=0.5"})
                   .code.has_value());
  EXPECT_EQ(Parse({"--max-meshes=0"}).code, 2);
  EXPECT_EQ(Parse({"--idle-timeout=86401"}).code, 2);
  EXPECT_EQ(Parse({"--writer-threads=1025"}).code, 2);
}

TEST(Flags, AllErrorsAreInTheFormOfTheLog) {
  for (const Parsed& p :
       {Parse({"--max-mashes", "7"}), Parse({"extra"}), Parse({"--log-level", "loud"}),
        Parse({"--config", "/no/such/file"}), ParseFile("\nmax-mashes = 7\n"),
        ParseFile("log-level = \"loud\"\n"), ParseFile("max-meshes = 1\nmax-meshes = 2\n")}) {
    EXPECT_EQ(p.code, 2);
    EXPECT_EQ(p.error.find("time="), 0u) << p.error;
    EXPECT_NE(p.error.find(" level=error event=bad_option "), std::string::npos) << p.error;
    EXPECT_EQ(std::count(p.error.begin(), p.error.end(), '\n'), 1) << p.error;
  }
  EXPECT_NE(ParseFile("\nmax-mashes = 7\n").error.find("key=max-mashes file="), std::string::npos);
  EXPECT_NE(ParseFile("\nmax-mashes = 7\n").error.find(" line=2 "), std::string::npos);
}

TEST(Flags, ExposureIsRefusedUnlessOnPurpose) {
  for (const char* local :
       {"127.0.0.1:1", "127.1.2.3:0", "localhost:9", "[::1]:7", "unix:/tmp/socket"}) {
    EXPECT_TRUE(IsLoopback(local)) << local;
  }
  for (const char* open : {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "127.evil.example:1", "host:1",
                           "localhost.example:1", "dns:///127.0.0.1:1"}) {
    EXPECT_FALSE(IsLoopback(open)) << open;
  }
  ServerConfig config;
  config.listen = "0.0.0.0:7878";
  const std::string error(ValidateConfig(config).message());
  EXPECT_NE(error.find("--tls-cert"), std::string::npos) << error;
  EXPECT_NE(error.find("--insecure-listen"), std::string::npos) << error;
  config.insecure_listen = true;
  EXPECT_TRUE(ValidateConfig(config).ok());
  config.insecure_listen = false;
  config.tls.certificate = "a";
  EXPECT_FALSE(ValidateConfig(config).ok());
  config.tls.key = "b";
  EXPECT_TRUE(ValidateConfig(config).ok());
  config.tls = {"", "", "c"};
  config.listen = "127.0.0.1:0";
  EXPECT_FALSE(ValidateConfig(config).ok());
}

TEST(Flags, ANodesAddressIsOneThatAClientCanBeGiven) {
  ServerConfig config;
  for (const char* good :
       {"", "a.example", "a.example:7878", "10.0.0.1:1", "[::1]:7878", "[::1]"}) {
    config.node_address = good;
    EXPECT_TRUE(ValidateConfig(config).ok()) << good;
  }
  for (const char* bad : {":7878", "a b", "http://a", "a,b", "a\n"}) {
    config.node_address = bad;
    const absl::Status refused = ValidateConfig(config);
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << bad;
    EXPECT_NE(refused.message().find("node-address"), std::string::npos) << refused;
  }
  config.node_address = "";
  for (const absl::Duration bad : {absl::ZeroDuration(), absl::Hours(2), -absl::Seconds(1)}) {
    config.lease = bad;
    EXPECT_TRUE(absl::IsInvalidArgument(ValidateConfig(config)));
  }
}

}  // namespace
}  // namespace dynmesh::server::flags_test
