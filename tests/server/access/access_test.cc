// Access control: the table of tokens, patterns, rates, and the effect of a changed file.
#include "server/access/access.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "server/access/certificate_watch.h"
#include "server/base/log.h"
#include "server/base/memory_guard.h"
#include "server/base/process.h"
#include "tests/server/test_support.h"
#include "tests/support/certificates.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::access_test {
namespace {

std::string HexOf(const std::string& token) { return codec::ToHex(codec::HashToken(token)); }

// The definition, slowly: every * tried with every length.
bool NaiveMatches(absl::string_view pattern, absl::string_view text) {
  if (pattern.empty()) return text.empty();
  if (pattern[0] != '*') {
    return !text.empty() && text[0] == pattern[0] &&
           NaiveMatches(pattern.substr(1), text.substr(1));
  }
  for (std::size_t n = 0; n <= text.size(); ++n) {
    if (NaiveMatches(pattern.substr(1), text.substr(n))) return true;
  }
  return false;
}

TEST(TokenHash, IsSha256) {
  // FIPS 180-2, appendix B.1.
  EXPECT_EQ(HexOf("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(codec::TokenHashFromHex(HexOf("abc")), codec::HashToken("abc"));
  EXPECT_FALSE(codec::TokenHashFromHex(HexOf("abc").substr(1)).has_value());
  EXPECT_FALSE(codec::TokenHashFromHex(std::string(64, 'g')).has_value());
  EXPECT_EQ(codec::RandomToken().size(), 64u);
  EXPECT_NE(codec::RandomToken(), codec::RandomToken());
}

TEST(CertificateWatch, TellsAtOnceAndThenNowAndAgain) {
  using Finding = CertificateWatch::Finding;
  const absl::Time from = absl::FromUnixSeconds(1'000'000'000);
  const absl::Time until = from + absl::Hours(24 * 90);
  CertificateWatch watch;
  EXPECT_EQ(watch.Due(from), std::nullopt);  // none is in use
  watch.Use("cert.pem", {from, until});
  EXPECT_EQ(watch.Due(from - absl::Seconds(1)), Finding::kNotValidYet);
  EXPECT_EQ(watch.Due(from), std::nullopt);
  EXPECT_EQ(watch.Due(until - absl::Hours(24 * 14)), std::nullopt);
  int told = 0;
  for (absl::Time now = until - absl::Hours(24 * 14) + absl::Seconds(1); now < until;
       now += absl::Minutes(1)) {
    const auto finding = watch.Due(now);
    if (!finding.has_value()) continue;
    EXPECT_EQ(finding, Finding::kEndsSoon);
    ++told;
  }
  EXPECT_EQ(told, 14);  // once a day
  EXPECT_EQ(watch.Due(until), Finding::kExpired);
  EXPECT_EQ(watch.Due(until + absl::Minutes(59)), std::nullopt);
  EXPECT_EQ(watch.Due(until + absl::Minutes(60)), Finding::kExpired);
  EXPECT_EQ(watch.Due(from - absl::Hours(1)), Finding::kNotValidYet);  // the clock was set back
  watch.Use("cert.pem", {from, until + absl::Hours(24 * 90)});
  EXPECT_EQ(watch.Due(until), std::nullopt);
}

TEST(Pattern, MatchesAsItsDefinitionSays) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937 random(seed);
  const auto draw = [&](const char* letters, int count, std::size_t most) {
    std::string word;
    for (std::size_t n = random() % (most + 1); n > 0; --n) {
      word += letters[random() % static_cast<unsigned>(count)];
    }
    return word;
  };
  int matched = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string pattern = draw("ab*", 3, 6), text = draw("ab", 2, 7);
    const bool expected = NaiveMatches(pattern, text);
    matched += expected ? 1 : 0;
    ASSERT_EQ(MatchesPattern(pattern, text), expected) << pattern << " " << text << " " << seed;
  }
  EXPECT_GT(matched, 1000);
}

TEST(TokenTable, RolesIncludeThoseBelow) {
  const auto table =
      TokenTable::Parse("# who\nlab " + HexOf("t") + " edit=crack-* read=*  # of the lab\n\n");
  ASSERT_TRUE(table.ok()) << Text(table.status());
  EXPECT_EQ(table->Find(codec::HashToken("u")), nullptr);
  const auto lab = table->Find(codec::HashToken("t"));
  ASSERT_NE(lab, nullptr);
  EXPECT_EQ(lab->name, "lab");
  EXPECT_TRUE(lab->Allows(Role::kEdit, "crack-1"));
  EXPECT_TRUE(lab->Allows(Role::kRead, "crack-1"));
  EXPECT_FALSE(lab->Allows(Role::kAdmin, "crack-1"));
  EXPECT_TRUE(lab->Allows(Role::kRead, "plate"));
  EXPECT_FALSE(lab->Allows(Role::kEdit, "plate"));
  EXPECT_FALSE(lab->Allows(Role::kEdit, ""));
  EXPECT_TRUE(lab->AllowsSome(Role::kRead));
  EXPECT_TRUE(lab->AllowsSome(Role::kEdit));
  EXPECT_FALSE(lab->AllowsSome(Role::kAdmin));
}

TEST(TokenTable, BadLinesAreNamedAndNotRepeated) {
  const std::string secret = "swordfish-in-clear";
  const std::string good = "a " + HexOf("a") + " read=*\n";
  for (const std::string& bad :
       {"b " + secret + " read=*", "b " + HexOf("b"), "b " + HexOf("b") + " write=*",
        "b " + HexOf("b") + " read", "b " + HexOf("b") + " read=", "b " + HexOf("b") + " read=M",
        "a " + HexOf("b") + " read=*", "b " + HexOf("a") + " read=*"}) {
    const auto table = TokenTable::Parse(good + bad);
    ASSERT_FALSE(table.ok()) << bad;
    EXPECT_NE(Text(table.status()).find("line 2"), std::string::npos) << Text(table.status());
    EXPECT_EQ(Text(table.status()).find(secret), std::string::npos) << Text(table.status());
  }
}

TEST(RateBucket, GivesItsRateAndSaysHowLongToWait) {
  absl::Time now = absl::UnixEpoch();
  RateBucket bucket(10, now);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(bucket.Take(now), absl::ZeroDuration()) << i;
  const absl::Duration wait = bucket.Take(now);
  EXPECT_EQ(wait, absl::Milliseconds(100));
  EXPECT_NE(bucket.Take(now + wait * 0.9), absl::ZeroDuration());
  EXPECT_EQ(bucket.Take(now + wait * 1.01), absl::ZeroDuration());
  now += absl::Hours(1);  // no more than a second's worth is saved up
  int taken = 0;
  while (bucket.Take(now) == absl::ZeroDuration()) ++taken;
  EXPECT_EQ(taken, 10);
  // A clock that is set back does not block a client for long.
  now -= absl::Hours(2);
  EXPECT_NE(bucket.Take(now), absl::ZeroDuration());
  EXPECT_EQ(bucket.Take(now + absl::Seconds(1)), absl::ZeroDuration());
}

TEST(RateLimit, ForgetsClientsAtRestAndIsBounded) {
  const absl::Time start = absl::UnixEpoch();
  RateLimit limit(1, 2000);
  for (int i = 0; i < 10'000; ++i) limit.BucketOf(std::to_string(i), start)->Take(start);
  EXPECT_LE(limit.clients(), 2001u);
  limit.BucketOf("new", start + absl::Hours(1));
  EXPECT_LT(limit.clients(), 10u);
  EXPECT_EQ(RateLimit(0).BucketOf("any", start), nullptr);
}

class AccessTest : public ::testing::Test {
 protected:
  AccessTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }
  void Tokens(const std::string& text) { test::WriteAtOnce(path_, text); }
  absl::StatusOr<Pass> Admit(const std::string& token, const char* address = "ipv4:10.0.0.1") {
    header_ = "Bearer " + token;
    return access_->Admit({header_, address});
  }

  test::TempFolder folder_;
  const std::string path_ = folder_.path() + "/tokens";
  std::string header_;
  std::unique_ptr<Access> access_;
};

TEST_F(AccessTest, WithoutAFileEverybodyMayDoEverything) {
  access_ = *Access::Create("", 0);
  const auto pass = access_->Admit({std::nullopt, "ipv4:10.0.0.1"});
  ASSERT_TRUE(pass.ok());
  EXPECT_TRUE(pass->Check(Role::kAdmin, "meshes/m").ok());
  EXPECT_TRUE(access_->Open(*pass, Role::kEdit, "m", nullptr).ok());
}

TEST_F(AccessTest, AnEmptyFileLetsNobodyIn) {
  EXPECT_EQ(Access::Create(path_, 0).status().code(), absl::StatusCode::kInvalidArgument);
  Tokens("# none yet\n");
  access_ = *Access::Create(path_, 0);
  EXPECT_EQ(ReasonOf(access_->Admit({std::nullopt, ""}).status()), codec::reason::kTokenMissing);
  EXPECT_EQ(ReasonOf(Admit("").status()), codec::reason::kTokenUnknown);
  header_ = "Basic abc";
  EXPECT_EQ(ReasonOf(access_->Admit({header_, ""}).status()), codec::reason::kTokenUnknown);
}

TEST_F(AccessTest, AChangedFileIsReadAndABadOneStaysUnused) {
  Tokens("a " + HexOf("a") + " read=*\n");
  access_ = *Access::Create(path_, 0);
  EXPECT_TRUE(Admit("a").ok());
  Tokens("b " + HexOf("b") + " read=*\n");
  access_->Reload();
  EXPECT_EQ(ReasonOf(Admit("a").status()), codec::reason::kTokenUnknown);
  EXPECT_TRUE(Admit("b").ok());
  Tokens("nonsense\n");
  access_->Reload();
  EXPECT_TRUE(Admit("b").ok());
  std::filesystem::remove(path_);
  access_->Reload();
  EXPECT_TRUE(Admit("b").ok());
}

TEST_F(AccessTest, AFileThatIsBeingWrittenIsNotRead) {
  Tokens("a " + HexOf("a") + " read=*\n");
  access_ = *Access::Create(path_, 0);
  const absl::Time start = absl::UnixEpoch();
  const auto look = [&](int milliseconds) {
    access_->ReloadIfChanged(start + absl::Milliseconds(milliseconds));
  };
  look(0);
  Tokens("");
  look(100);
  look(1000);
  EXPECT_TRUE(Admit("a").ok());
  Tokens("a " + HexOf("a") + " read=*\nb " + HexOf("b") + " read=*\n");
  look(1100);
  look(2000);
  EXPECT_TRUE(Admit("a").ok());
  EXPECT_EQ(ReasonOf(Admit("b").status()), codec::reason::kTokenUnknown);
  look(2100);
  EXPECT_TRUE(Admit("b").ok());
  Tokens("");
  access_->Reload();
  EXPECT_EQ(ReasonOf(Admit("a").status()), codec::reason::kTokenUnknown);
}

TEST_F(AccessTest, StreamsEndWithTheirRights) {
  const std::string other = "b " + HexOf("b") + " edit=*\n";
  Tokens("a " + HexOf("a") + " edit=*\n" + other);
  access_ = *Access::Create(path_, 0);
  int edits = 0, reads = 0, others = 0, closed = 0;
  const Pass pass = *Admit("a");
  const auto open = [&](const Pass& p, Role role, int* count) {
    return access_->Open(p, role, "m", [count](const std::string&) { ++*count; });
  };
  const auto editing = open(pass, Role::kEdit, &edits);
  const auto reading = open(pass, Role::kRead, &reads);
  const auto beside = open(*Admit("b"), Role::kEdit, &others);
  open(pass, Role::kEdit, &closed)->Close();
  Tokens("a " + HexOf("a") + " read=m\n" + other);
  access_->Reload();
  EXPECT_EQ(edits, 1);
  EXPECT_EQ(reads, 0);
  // An older pass has the token's present rights.
  EXPECT_EQ(ReasonOf(open(pass, Role::kEdit, &closed).status()), codec::reason::kRoleMissing);
  Tokens(other);
  access_->Reload();
  EXPECT_EQ(reads, 1);
  EXPECT_EQ(ReasonOf(open(pass, Role::kRead, &closed).status()), codec::reason::kTokenUnknown);
  EXPECT_EQ(others, 0);
  EXPECT_EQ(closed, 0);
}

TEST_F(AccessTest, EachTokenAndEachAddressHasARateOfItsOwn) {
  Tokens("a " + HexOf("a") + " read=*\nb " + HexOf("b") + " read=*\n");
  access_ = *Access::Create(path_, 0.001);
  EXPECT_TRUE(Admit("a").ok());
  EXPECT_TRUE(Admit("b").ok());
  const absl::Status refused = Admit("a", "ipv4:10.0.0.2").status();
  EXPECT_EQ(ReasonOf(refused), codec::reason::kRateLimit);
  EXPECT_TRUE(codec::GetServiceError(refused)->retry_after.has_value());
  EXPECT_EQ(codec::GetServiceError(refused)->metadata["client"], "token a");
  const absl::Status unknown = Admit("wrong").status();
  EXPECT_EQ(ReasonOf(unknown), codec::reason::kTokenUnknown);
  EXPECT_EQ(codec::GetServiceError(unknown)->metadata["client"].find("address "), 0u);
  EXPECT_EQ(ReasonOf(Admit("guess").status()), codec::reason::kRateLimit);
  EXPECT_EQ(ReasonOf(Admit("guess", "ipv4:10.0.0.2").status()), codec::reason::kTokenUnknown);
}

TEST(MemoryGuard, HasWhatItsControlGroupAndThoseAboveLeaveIt) {
  test::TempFolder folder;
  const std::string own = folder.path() + "/own", groups = folder.path() + "/groups";
  const auto write = [&](const std::string& path, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::ofstream(path) << text << "\n";
  };
  const std::uint64_t machine = AvailableBytes(own, groups);  // no cgroup files
  EXPECT_GT(machine, 3'000'000u);
  write(own, "0::/system.slice/dynmeshd.service");
  write(groups + "/system.slice/dynmeshd.service/memory.max", "max");
  EXPECT_EQ(AvailableBytes(own, groups), machine);
  write(groups + "/system.slice/memory.max", "3000000");
  EXPECT_EQ(AvailableBytes(own, groups), 3'000'000u);
  write(groups + "/system.slice/dynmeshd.service/memory.max", "2000000");
  EXPECT_EQ(AvailableBytes(own, groups), 2'000'000u);
  // As in a container: its root is its own group, and its path is the host's.
  write(own, "0::/elsewhere");
  write(groups + "/memory.max", "1000000");
  EXPECT_EQ(AvailableBytes(own, groups), 1'000'000u);
  write(own, "8:pids:/\n4:memory:/a/b");
  EXPECT_EQ(AvailableBytes(own, groups), machine);
  write(groups + "/memory/a/memory.limit_in_bytes", "1500000");
  EXPECT_EQ(AvailableBytes(own, groups), 1'500'000u);
}

TEST(MemoryGuard, TellsBothSidesOfItsLimit) {
  EXPECT_GT(ResidentBytes(), std::uint64_t{1} << 20);
  EXPECT_GE(AvailableBytes(), ResidentBytes());
  const std::uint64_t before = ResidentBytes();
  constexpr std::size_t kMore = 64 << 20;
  const std::vector<char> more(kMore, 'x');
  EXPECT_GT(ResidentBytes(), before + kMore / 2) << more[kMore / 2];
  EXPECT_TRUE(MemoryGuard(0).CheckRoom().ok());
  const MemoryGuard full(1);
  EXPECT_EQ(ReasonOf(full.CheckRoom()), codec::reason::kMemoryLimit);
  EXPECT_TRUE(*full.full());
}

}  // namespace
}  // namespace dynmesh::server::access_test
