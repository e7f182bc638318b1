// Bytes of diffs that watches share: the same messages as each watch would encode, once, bounded.
#include "server/calls/shared_events.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "proto/codec/mesh_codec.h"
#include "server/revisions/diff_algebra.h"
#include "tests/server/test_support.h"

namespace dynmesh::server::shared_events_test {
namespace {

constexpr std::size_t kFragment = 2'000;

std::string Bytes(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  EXPECT_TRUE(buffer.Dump(&slices).ok());
  for (const grpc::Slice& s : slices) {
    bytes.append(reinterpret_cast<const char*>(s.begin()), s.size());
  }
  return bytes;
}

class SharedEventsTest : public ::testing::Test {
 protected:
  std::shared_ptr<const MeshDiff> Diff(int points) {
    EditBatch batch;
    for (int i = 0; i < points; ++i) batch.push_back(AddPoint(++last_));
    auto diff = fake_.Apply(batch, {});
    EXPECT_TRUE(diff.ok()) << Text(diff.status());
    return std::make_shared<const MeshDiff>(*std::move(diff));
  }
  static std::vector<std::string> Encoded(const std::shared_ptr<const MeshDiff>& diff) {
    codec::DiffFragmenter fragments(diff, /*omit_columns=*/false, kFragment);
    std::vector<std::string> all;
    v1::WatchEvent event;
    while (fragments.Next(event.mutable_diff())) all.push_back(event.SerializeAsString());
    return all;
  }

  FakeDynamicMesh fake_{MeshOptions(), nullptr};
  FeatureId last_ = 0;
};

TEST_F(SharedEventsTest, AreTheMessagesOfTheDiff) {
  SharedEvents events(/*bytes=*/8 << 20, /*most_messages=*/1'000);
  for (const int points : {1, 3, 200}) {
    const auto diff = Diff(points);
    const auto found = events.Find(diff, kFragment);
    ASSERT_NE(found, nullptr);
    std::vector<std::string> all;
    for (const grpc::ByteBuffer& e : *found) all.push_back(Bytes(e));
    EXPECT_EQ(all, Encoded(diff));
    EXPECT_EQ(all.size() > 1, points == 200);
  }
}

TEST_F(SharedEventsTest, ADiffIsEncodedOnceForManyThreads) {
  SharedEvents events;
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
  for (int i = 0; i < 20; ++i) diffs.push_back(Diff(2));
  std::vector<std::vector<const grpc::ByteBuffer*>> found(4);
  std::vector<std::thread> threads;
  for (auto& mine : found) {
    threads.emplace_back([&] {
      for (const auto& diff : diffs) mine.push_back(events.Find(diff, kFragment)->data());
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(events.encoded(), diffs.size());
  for (const auto& mine : found) EXPECT_EQ(mine, found[0]);
}

TEST_F(SharedEventsTest, TheOldestAreDroppedAndAreWholeForTheWatchThatHasThem) {
  const auto first = Diff(2);
  SharedEvents events(/*bytes=*/4 * ByteSize(*first));
  const auto held = events.Find(first, kFragment);
  for (int i = 0; i < 50; ++i) {
    events.Find(Diff(2), kFragment);  // such a diff is gone when its address is used again
    EXPECT_LE(events.held_bytes(), 4 * ByteSize(*first) + 1'000);
  }
  EXPECT_EQ(Bytes(held->front()), Encoded(first).front());
  EXPECT_EQ(events.encoded(), 51u);
  const auto again = events.Find(first, kFragment);
  EXPECT_EQ(events.encoded(), 52u);
  EXPECT_EQ(Bytes(again->front()), Encoded(first).front());
}

TEST_F(SharedEventsTest, ALargeDiffIsNotKept) {
  const auto diff = Diff(200);
  const std::size_t messages = Encoded(diff).size();
  ASSERT_GT(messages, 1u);
  SharedEvents events(/*bytes=*/1 << 20, /*most_messages=*/messages - 1);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(events.Find(diff, kFragment), nullptr);
  EXPECT_EQ(events.encoded(), 1u);
  EXPECT_LT(events.held_bytes(), 1'000u);
  EXPECT_NE(events.Find(Diff(1), kFragment), nullptr);
}

}  // namespace
}  // namespace dynmesh::server::shared_events_test
