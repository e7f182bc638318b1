// TLS over real connections: authorities, identities, and new files without a restart.
#include "server/access/tls.h"

#include <gtest/gtest.h>

#include "tests/server/server_fixture.h"
#include "tests/support/certificates.h"

namespace dynmesh::server::tls_test {
namespace {

using absl::StatusCode;

class TlsTest : public ServerFixture {
 protected:
  static void SetUpTestSuite() {
    made_ = new test::Certificates;
    for (const char* authority : {"ca", "stranger"}) made_->MakeAuthority(authority);
    for (const char* name : {"server", "second", "client"}) made_->Make(name, "ca");
    made_->Make("late", "ca", -1);
    made_->Make("intruder", "stranger");
  }
  static void TearDownTestSuite() { delete made_; }

  // The files that the server reads: copies, so that a test may replace them.
  TlsFiles Files(const std::string& name, bool mutual = false) {
    Use(name);
    if (mutual) test::WriteAtOnce(Path("ca"), made_->Certificate("ca"));
    return {Path("cert"), Path("key"), mutual ? Path("ca") : ""};
  }
  std::string Path(const std::string& file) const { return folder_.path() + "/" + file; }
  void Use(const std::string& name) {
    test::WriteAtOnce(Path("cert"), made_->Certificate(name));
    test::WriteAtOnce(Path("key"), made_->Key(name));
  }
  void Start(const TlsFiles& files) {
    ServerConfig config;
    config.tls = files;
    StartServer(config);
  }
  // Of a new connection.
  absl::Status Try(const std::string& authority, const std::string& identity = "") const {
    client::ClientOptions options;
    options.own_connection = true;
    options.timeout = absl::Seconds(20);
    if (!authority.empty()) options.tls_ca = made_->Certificate(authority);
    if (!identity.empty()) {
      options.tls_certificate = made_->Certificate(identity);
      options.tls_key = made_->Key(identity);
    }
    return client::MeshClient::Connect(server_->address(), options)->GetStats().status();
  }

  static test::Certificates* made_;
  test::TempFolder folder_;
};
test::Certificates* TlsTest::made_ = nullptr;

TEST_F(TlsTest, OnlyThoseWhoTrustTheAuthorityAndSpeakTlsConnect) {
  Start(Files("server"));
  EXPECT_TRUE(Try("ca").ok()) << Text(Try("ca"));
  EXPECT_EQ(Try("stranger").code(), StatusCode::kUnavailable);
  EXPECT_EQ(Try("").code(), StatusCode::kUnavailable);  // plaintext
  EXPECT_TRUE(Try("ca").ok());
}

TEST_F(TlsTest, AnExpiredCertificateIsRefused) {
  Start(Files("late"));
  EXPECT_EQ(Try("ca").code(), StatusCode::kUnavailable);
}

// When it is loaded, when a new one is and, for one that ends in two days, while it is used.
TEST_F(TlsTest, TheLogWarnsOfCertificatesThatAreNotValidOrSoonNoMore) {
  const auto told = [&](const std::function<void()>& act) {
    EXPECT_TRUE(SetLogLevel("warning").ok());
    testing::internal::CaptureStderr();
    act();
    EXPECT_TRUE(SetLogLevel("error").ok());
    return testing::internal::GetCapturedStderr();
  };
  const std::string file = " file=" + Path("cert") + " until=";
  const std::string late = told([&] { Start(Files("late")); });
  EXPECT_NE(late.find("event=certificate_expired" + file), std::string::npos) << late;
  const std::string soon = told([&] {
    Use("server");
    EXPECT_TRUE(Try("ca").ok());
  });
  EXPECT_NE(soon.find("event=certificate_ends_soon" + file), std::string::npos) << soon;
  EXPECT_EQ(soon.find("event=certificate_expired"), std::string::npos) << soon;
  // Without a connection, at the latest after a look.
  EXPECT_TRUE(SetLogLevel("warning").ok());
  testing::internal::CaptureStderr();
  Use("late");
  std::string expired;
  Eventually([&] {
    expired += testing::internal::GetCapturedStderr();
    const bool is_told = expired.find("event=certificate_expired" + file) != std::string::npos;
    testing::internal::CaptureStderr();
    return is_told;
  });
  expired += testing::internal::GetCapturedStderr();
  EXPECT_TRUE(SetLogLevel("error").ok());
  EXPECT_NE(expired.find("event=certificate_expired" + file), std::string::npos) << expired;
}

TEST_F(TlsTest, TheAuthorityOfClientsIsWatchedToo) {
  EXPECT_TRUE(SetLogLevel("warning").ok());
  testing::internal::CaptureStderr();
  Start(Files("server", /*mutual=*/true));
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(SetLogLevel("error").ok());
  EXPECT_NE(log.find("event=certificate_ends_soon file=" + Path("ca") + " "), std::string::npos)
      << log;
}

TEST_F(TlsTest, WhenACertificateEndsIsKnown) {
  const TlsFiles files = Files("server");
  const auto end = EndOfCertificate(files.certificate);
  ASSERT_TRUE(end.ok()) << end.status();
  EXPECT_GT(*end, absl::Now());
  EXPECT_LT(*EndOfCertificate(Files("late").certificate), absl::Now());
  for (const std::string& none : {files.key, Path("none")}) {
    EXPECT_TRUE(absl::IsInvalidArgument(EndOfCertificate(none).status())) << none;
  }
}

TEST_F(TlsTest, WithAnAuthorityForClientsTheyMustShowACertificate) {
  Start(Files("server", /*mutual=*/true));
  EXPECT_TRUE(Try("ca", "client").ok()) << Text(Try("ca", "client"));
  EXPECT_EQ(Try("ca").code(), StatusCode::kUnavailable);
  EXPECT_EQ(Try("ca", "intruder").code(), StatusCode::kUnavailable);
  EXPECT_EQ(Try("ca", "late").code(), StatusCode::kUnavailable);
  EXPECT_TRUE(Try("ca", "client").ok());
}

TEST_F(TlsTest, NewConnectionsSeeANewCertificateAndOldOnesGoOn) {
  Start(Files("server"));
  client::ClientOptions options;
  options.tls_ca = made_->Certificate("ca");
  const auto old = client::MeshClient::Connect(server_->address(), options);
  ASSERT_TRUE(old->GetStats().ok());
  Use("intruder");  // of another authority, to be distinguishable
  EXPECT_EQ(Try("ca").code(), StatusCode::kUnavailable);
  EXPECT_TRUE(Try("stranger").ok());
  Use("second");
  EXPECT_TRUE(Try("ca").ok());
  EXPECT_TRUE(old->GetStats().ok());
}

TEST_F(TlsTest, BadNewFilesLeaveTheOldOnes) {
  EXPECT_TRUE(SetLogLevel("off").ok());
  Start(Files("server"));
  ASSERT_TRUE(Try("ca").ok());
  for (const char* file : {"cert", "key"}) {
    test::WriteAtOnce(Path(file), "garbage");
    EXPECT_TRUE(Try("ca").ok()) << file;
    std::filesystem::remove(Path(file));
    EXPECT_TRUE(Try("ca").ok()) << file;
    Use("server");
  }
  // The key of another certificate: as between two renames.
  test::WriteAtOnce(Path("key"), made_->Key("intruder"));
  EXPECT_TRUE(Try("ca").ok());
  test::WriteAtOnce(Path("cert"), made_->Certificate("intruder"));
  EXPECT_TRUE(Try("stranger").ok());
}

TEST_F(TlsTest, AnExpiredCertificateDoesNotReplaceAValidOne) {
  Start(Files("server"));
  ASSERT_TRUE(Try("ca").ok());
  EXPECT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  Use("late");
  EXPECT_TRUE(Try("ca").ok()) << Text(Try("ca"));
  EXPECT_TRUE(Try("ca").ok());
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(SetLogLevel("error").ok());
  EXPECT_NE(log.find("event=certificate_expired file=" + Path("cert") + " until="),
            std::string::npos)
      << log;
  EXPECT_NE(log.find("the former certificate stays in use while it is valid"), std::string::npos)
      << log;
  EXPECT_EQ(log.find("tls_reloaded"), std::string::npos) << log;
  Use("intruder");  // a valid one does
  EXPECT_TRUE(Try("stranger").ok());
}

TEST_F(TlsTest, AnExpiredCertificateReplacesAnExpiredOne) {
  EXPECT_TRUE(SetLogLevel("off").ok());
  Start(Files("late"));
  EXPECT_EQ(Try("ca").code(), StatusCode::kUnavailable);
  testing::internal::CaptureStderr();
  EXPECT_TRUE(SetLogLevel("info").ok());
  Use("late");
  EXPECT_EQ(Try("ca").code(), StatusCode::kUnavailable);
  EXPECT_TRUE(SetLogLevel("error").ok());
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("event=tls_reloaded"), std::string::npos) << log;
}

TEST_F(TlsTest, FilesThatAreBadAtTheStartAreNamed) {
  const TlsFiles good = Files("server", true);
  const auto error = [&](TlsFiles files) {
    ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.tls = files;
    const auto server = Server::Start(
        config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o, nullptr); });
    EXPECT_EQ(server.status().code(), StatusCode::kInvalidArgument);
    return std::string(server.status().message());
  };
  test::WriteAtOnce(Path("garbage"), "garbage");
  test::WriteAtOnce(Path("other"), made_->Key("second"));
  // The chain's second certificate is cut short.
  test::WriteAtOnce(Path("chain"),
                    made_->Certificate("server") + made_->Certificate("ca").substr(0, 300));
  for (const std::string& bad : {Path("none"), Path("garbage"), folder_.path()}) {
    EXPECT_NE(error({bad, good.key, ""}).find("tls-cert: " + bad), std::string::npos) << bad;
    EXPECT_NE(error({good.certificate, bad, ""}).find("tls-key: " + bad), std::string::npos);
    EXPECT_NE(error({good.certificate, good.key, bad}).find("tls-client-ca: " + bad),
              std::string::npos);
  }
  EXPECT_NE(error({good.certificate, Path("other"), ""}).find("does not belong"),
            std::string::npos);
  EXPECT_NE(error({Path("chain"), good.key, ""}).find("chain"), std::string::npos);
}

}  // namespace
}  // namespace dynmesh::server::tls_test
