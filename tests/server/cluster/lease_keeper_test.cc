// Leases are renewed until the keeper is stopped, and given up once, after the last renewal.
#include "server/cluster/lease_keeper.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/base/log.h"

namespace dynmesh::server::lease_keeper_test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

// A database that counts its calls, and can be made to fail or to hang.
class LeaseKeeperTest : public ::testing::Test {
 protected:
  LeaseKeeperTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }

  LeaseKeeper::Calls Calls() {
    return {[this] {
              std::unique_lock lock(mutex_);
              ++renewals_;
              changed_.notify_all();
              changed_.wait(lock, [this] { return !hangs_; });
              EXPECT_EQ(given_up_, 0) << "a renewal after the end";
              return answer_;
            },
            [this] {
              const std::lock_guard lock(mutex_);
              ++given_up_;
              return absl::UnavailableError("gone");
            }};
  }
  void Set(bool hangs, const absl::Status& answer) {
    const std::lock_guard lock(mutex_);
    hangs_ = hangs;
    answer_ = answer;
    changed_.notify_all();
  }
  // False after a minute.
  bool WaitForRenewals(int more) {
    std::unique_lock lock(mutex_);
    const int until = renewals_ + more;
    return changed_.wait_for(lock, std::chrono::minutes(1), [&] { return renewals_ >= until; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  int renewals_ = 0, given_up_ = 0;
  bool hangs_ = false;
  absl::Status answer_;
};

TEST_F(LeaseKeeperTest, RenewsAtOnceAndAgain) {
  LeaseKeeper keeper(milliseconds(3), Calls());
  EXPECT_TRUE(WaitForRenewals(5));
}

TEST_F(LeaseKeeperTest, AFailedRenewalIsRepeatedAndAllowsNoReads) {
  answer_ = absl::UnavailableError("no connection");
  LeaseKeeper keeper(milliseconds(3), Calls());
  ASSERT_TRUE(WaitForRenewals(3));
  EXPECT_FALSE(keeper.MayAnswerReads());
  EXPECT_LT(keeper.Age().count(), 0);
}

TEST_F(LeaseKeeperTest, ReadsAreAnsweredAfterARenewalAndNotAfterTheEnd) {
  LeaseKeeper keeper(hours(10), Calls());
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!keeper.MayAnswerReads() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  EXPECT_TRUE(keeper.MayAnswerReads());
  EXPECT_GE(keeper.Age().count(), 0);
  keeper.Stop();
  EXPECT_FALSE(keeper.MayAnswerReads());
  keeper.Stop();
  EXPECT_EQ(renewals_, 1);
  EXPECT_EQ(given_up_, 1);
}

TEST_F(LeaseKeeperTest, ARenewalUnderWayIsWaitedForAtTheEnd) {
  hangs_ = true;
  LeaseKeeper keeper(hours(10), Calls());
  {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(
        changed_.wait_for(lock, std::chrono::minutes(1), [this] { return renewals_ == 1; }));
  }
  std::thread stop([&keeper] { keeper.Stop(); });
  Set(false, absl::OkStatus());
  stop.join();
  EXPECT_FALSE(keeper.MayAnswerReads()) << "its answer came after the end";
  EXPECT_EQ(given_up_, 1);
}

}  // namespace
}  // namespace dynmesh::server::lease_keeper_test
