// Small parts of the server: pools, queues, quotas, the gate, request ids, names, config.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/match.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "server/access/client_quotas.h"
#include "server/access/quota.h"
#include "server/base/log.h"
#include "server/base/printable.h"
#include "server/base/work_gate.h"
#include "server/base/worker_pool.h"
#include "server/calls/admission.h"
#include "server/config/config.h"
#include "server/meshes/mesh_registry.h"
#include "server/revisions/request_memory.h"
#include "tests/server/test_support.h"

namespace dynmesh::server::parts_test {
namespace {

TEST(WorkerPool, StopRunsWhatIsQueuedAndWhatThatPosts) {
  std::atomic<int> ran{0};
  WorkerPool pool(3);
  for (int i = 0; i < 50; ++i) {
    pool.Post([&] {
      ++ran;
      pool.Post([&] { ++ran; });
    });
  }
  pool.Stop();
  EXPECT_EQ(ran, 100);
  pool.Post([&] { ++ran; });
  EXPECT_EQ(ran, 100);
}

TEST(SerialQueue, TasksRunInOrderAndNeverTwoAtATime) {
  WorkerPool pool(4);
  const auto queue = SerialQueue::Create(&pool);
  std::vector<int> order;  // unguarded on purpose: the queue is the guard
  for (int i = 0; i < 1000; ++i) queue->Post([&order, i] { order.push_back(i); });
  pool.Stop();
  ASSERT_EQ(order.size(), 1000u);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(SerialQueue, RestsWhenNoTaskWaitsAndAfterATurn) {
  WorkerPool pool(2);
  const SerialQueue::Turn turn = {4, std::chrono::hours(1)};
  Mailbox<std::string> rested;
  std::string ran;  // since the last rest
  const auto rest = [&] { rested.Put(std::exchange(ran, "")); };
  const auto queue = SerialQueue::Create(&pool, turn);
  queue->OnRest(rest);
  Mailbox<int> go;
  queue->Post([&] { go.Take(); });
  for (int i = 0; i < 10; ++i) queue->Post([&, i] { ran += static_cast<char>('a' + i); });
  go.Put(0);
  EXPECT_EQ(rested.Take(), "abc");
  EXPECT_EQ(rested.Take(), "defg");
  EXPECT_EQ(rested.Take(), "hij");
  // A task posted meanwhile still runs.
  const auto other = SerialQueue::Create(&pool, turn);
  other->OnRest(rest);
  other->Post([&] {
    ran += 'y';
    other->Post([&] { ran += 'z'; });
  });
  EXPECT_EQ(rested.Take(), "yz");
  pool.Stop();
  EXPECT_EQ(rested.size(), 0u);
}

TEST(SerialQueue, ATurnEndsWhenItsTimeIsOver) {
  WorkerPool pool(1);
  const auto queue = SerialQueue::Create(&pool, {1000, std::chrono::nanoseconds(0)});
  const auto other = SerialQueue::Create(&pool);
  Mailbox<int> begun, go;
  std::string order;  // unguarded on purpose: there is one thread
  queue->Post([&] {
    begun.Put(0);
    go.Take();
  });
  begun.Take();
  for (int i = 0; i < 3; ++i) queue->Post([&] { order += 'a'; });
  other->Post([&] { order += 'b'; });
  go.Put(0);
  pool.Stop();
  EXPECT_EQ(order, "baaa");
}

TEST(SerialQueue, WhatIsWithdrawnMakesRoomAndDoesNotRun) {
  WorkerPool pool(1);
  const auto queue = SerialQueue::Create(&pool);
  Mailbox<int> begun, go, ran, withdrawn;
  queue->Post([&] {
    begun.Put(0);
    go.Take();
  });
  begun.Take();
  const int mine = 0, other = 0;
  for (int i = 0; i < 4; ++i) {
    const void* const key = i % 2 == 0 ? &mine : &other;
    EXPECT_TRUE(queue->TryPost([&, i] { ran.Put(i); }, 4, {key, [&, i] { withdrawn.Put(i); }}));
  }
  EXPECT_FALSE(queue->TryPost([] {}, 4));
  queue->Withdraw(&mine);
  EXPECT_EQ(withdrawn.Take(), 0);
  EXPECT_EQ(withdrawn.Take(), 2);
  EXPECT_EQ(queue->waiting(), 2u);
  EXPECT_TRUE(queue->TryPost([&] { ran.Put(4); }, 3));
  go.Put(0);
  for (const int i : {1, 3, 4}) EXPECT_EQ(ran.Take(), i);
  queue->Withdraw(&other);  // all have run
  EXPECT_EQ(withdrawn.size() + ran.size(), 0u);
}

// A queue whose first task waits, so that others are posted behind it.
struct HeldQueue {
  explicit HeldQueue(WorkerPool* pool) : queue(SerialQueue::Create(pool)) {
    queue->Post([this] {
      begun.Put(0);
      go.Take();
    });
    begun.Take();
  }
  const std::shared_ptr<SerialQueue> queue;
  Mailbox<int> begun, go;
};

TEST(SerialQueue, ATaskOfPostFirstRunsAheadOfThoseThatWait) {
  WorkerPool pool(2);
  HeldQueue held(&pool);
  std::string order;
  for (const char c : {'c', 'd'}) held.queue->Post([&order, c] { order += c; });
  for (const char c : {'a', 'b'}) held.queue->PostFirst([&order, c] { order += c; });
  EXPECT_EQ(held.queue->waiting(), 2u);
  held.go.Put(0);
  pool.Stop();
  EXPECT_EQ(order, "abcd");
}

TEST(SerialQueue, ADeferredTaskTakesNoThreadAndIsTheFirstAfterATaskOfPostFirst) {
  WorkerPool pool(1);
  const auto queue = SerialQueue::Create(&pool), other = SerialQueue::Create(&pool);
  std::string order;
  bool ready = false;
  Mailbox<int> tried, beside;
  queue->Post([&] {
    tried.Put(0);
    if (!ready) return queue->Defer();
    order += 'b';
  });
  tried.Take();
  queue->Post([&] { order += 'c'; });
  other->Post([&] { beside.Put(0); });
  beside.Take();  // on the only thread
  EXPECT_EQ(queue->waiting(), 2u);
  EXPECT_EQ(tried.size(), 0u);
  queue->PostFirst([&] { order += '-'; });  // in vain
  tried.Take();
  queue->PostFirst([&] {
    order += 'a';
    ready = true;
  });
  tried.Take();
  pool.Stop();
  EXPECT_EQ(order, "-abc");
}

TEST(SerialQueue, ATaskOfPostFirstThatCameWhileOneDeferredItselfCounts) {
  WorkerPool pool(2);
  const auto queue = SerialQueue::Create(&pool);
  Mailbox<int> done;
  bool ready = false;
  queue->Post([&] {
    if (ready) return done.Put(0);
    queue->PostFirst([&] { ready = true; });
    queue->Defer();
  });
  done.Take();
}

TEST(SerialQueue, RestsWhenATaskIsDeferredAndItCanBeWithdrawn) {
  WorkerPool pool(2);
  const auto queue = SerialQueue::Create(&pool);
  Mailbox<int> rested, withdrawn, ran;
  queue->OnRest([&] { rested.Put(0); });
  const int key = 0;
  queue->TryPost([&] { queue->Defer(); }, 9, {&key, [&] { withdrawn.Put(0); }});
  rested.Take();
  queue->Post([&] { ran.Put(0); });
  queue->Withdraw(&key);
  withdrawn.Take();
  queue->PostFirst([] {});
  ran.Take();
  pool.Stop();
}

TEST(ClientQuotas, EachClientHasItsOwn) {
  ClientQuotas quotas(2);
  const Share a = quotas.Take("a");
  {
    const Share again = quotas.Take("a");
    EXPECT_TRUE(a && again);
    EXPECT_FALSE(quotas.Take("a"));
    EXPECT_TRUE(quotas.Take("b"));
    EXPECT_EQ(quotas.most(), 2u);
  }
  EXPECT_EQ(quotas.most(), 1u);
  EXPECT_TRUE(quotas.Take("a"));
  ClientQuotas any(0);
  std::vector<Share> shares(5000);
  for (Share& share : shares) EXPECT_TRUE(share = any.Take("a"));
}

TEST(ClientQuotas, ForgetsClientsThatHoldNothing) {
  ClientQuotas quotas(1);
  const Share kept = quotas.Take("kept");
  for (int i = 0; i < 10'000; ++i) EXPECT_TRUE(quotas.Take(std::to_string(i)));
  EXPECT_LT(quotas.size(), 2000u);
  EXPECT_FALSE(quotas.Take("kept"));
}

TEST(Quota, GivesNoMoreThanItsLimitAndTakesBack) {
  Quota quota(10);
  Share a = quota.Take(6);
  EXPECT_TRUE(a);
  EXPECT_FALSE(quota.Take(5));
  EXPECT_FALSE(quota.Take(~std::uint64_t{0}));
  {
    const Share b = quota.Take(4);
    EXPECT_TRUE(b);
    EXPECT_EQ(quota.used(), 10u);
  }
  EXPECT_EQ(quota.used(), 6u);
  Share c = std::move(a);
  a.Release();
  EXPECT_EQ(quota.used(), 6u);
  c = Share();
  EXPECT_EQ(quota.used(), 0u);
}

TEST(OpenSends, WhoTakesNothingIsEndedOnceAndWhoIsSlowIsNot) {
  OpenSends sends;
  OpenSends::Sender idle, stuck, slow;
  int ended = 0;
  for (OpenSends::Sender* sender : {&idle, &stuck, &slow}) {
    sender->Enter(sends, [&ended] { ++ended; });
  }
  constexpr std::chrono::seconds kLimit{10};
  OpenSends::Clock::time_point now{};
  stuck.Begin(now);
  // A message takes it almost the limit, again and again.
  for (int i = 0; i < 3; ++i) {
    slow.Begin(now);
    now += kLimit - std::chrono::milliseconds(1);
    sends.EndSlow(now - kLimit);
    EXPECT_EQ(ended, i == 0 ? 0 : 1);
    slow.Done();
  }
  EXPECT_TRUE(stuck.ended());
  EXPECT_FALSE(slow.ended());
  EXPECT_FALSE(idle.ended());
  slow.Begin(now);
  slow.Leave();
  sends.EndSlow(now + kLimit);
  EXPECT_EQ(ended, 1);
}

TEST(WorkGate, ADrainWaitsForTicketsAndAdmitsNoMore) {
  WorkGate gate;
  WorkGate::Ticket ticket = gate.Enter();
  ASSERT_NE(ticket, nullptr);
  gate.Close();
  EXPECT_EQ(gate.Enter(), nullptr);
  EXPECT_FALSE(gate.WaitEmpty(absl::ZeroDuration()));
  std::thread leaver([&] { ticket.reset(); });
  EXPECT_TRUE(gate.WaitEmpty(absl::Seconds(60)));
  leaver.join();
}

Edit Labelled(Edit edit, FeatureLabel label) {
  edit.feature.label = std::move(label);
  return edit;
}

// Journals have them: without labels they are as they were before there were any.
TEST(RequestMemory, FingerprintsStay) {
  const Fingerprint f = FingerprintOf({AddPoint(1), Edit::Remove(2)});
  EXPECT_EQ(f, (Fingerprint{0xfebf9adab6a361c0, 0x8f2edbe2fed5d3cc}));
}

TEST(RequestMemory, FingerprintsTellBatchesApart) {
  const std::vector<EditBatch> batches = {
      {},
      {AddPoint(1)},
      {AddPoint(2)},
      {AddPoint(1), AddPoint(2)},
      {AddPoint(2), AddPoint(1)},
      {Edit::Remove(1)},
      {Edit::Set(AddPoint(1).feature)},
      {Edit::Add(Feature::Point(1, 0.0, 0.5))},
      {Edit::Add(Feature::Point(1, 0.5, 0.0))},
      {Edit::Add(Feature::Segment(1, 2, 3))},
      {Edit::Add(Feature::Segment(1, 3, 2))},
      {Edit::Add(Feature::SizeAt(1, 0, 0, 0.5))},
      {Edit::Add(Feature::SizeAt(1, 0, 0, 0.25))},
      {Edit::Add(Feature::SizeDisc(1, 0, 0, 0, 0.5))},
      {Edit::Add(Feature::SizeDisc(1, 0, 0, 1, 0.5))},
      {Edit::Add(Feature::SizeBox(1, 0, 0, 1, 1, 0.5))},
      {Edit::Add(Feature::SizeBox(1, 0, 0, 1, 2, 0.5))},
      {Edit::Add(Feature::Polygon(1, {{2, 3, 4}}))},
      {Edit::Add(Feature::Polygon(1, {{2, 3, 5}}))},
      {Edit::Add(Feature::Polygon(1, {{2, 3, 4, 5, 6, 7}}))},
      {Edit::Add(Feature::Polygon(1, {{2, 3, 4}, {5, 6, 7}}))},
      {Edit::Add(Feature::SizePolygon(1, {{2, 3, 4}}, 0.5))},
      {Edit::SetLabel(1, {})},
      {Edit::SetLabel(2, {})},
      {Edit::SetLabel(1, {1, ""})},
      {Edit::SetLabel(1, {-1, ""})},
      {Edit::SetLabel(1, {0, "a"})},
      {Edit::SetLabel(1, {0, "b"})},
      {Edit::SetLabel(1, {1, "a"})},
      {Edit::SetLabel(1, {0, "12345678"})},
      {Edit::SetLabel(1, {0, "12345678a"})},
      {Edit::SetLabel(1, {0, "a12345678"})},
      {Labelled(AddPoint(1), {1, ""})},
      {Labelled(AddPoint(1), {0, "a"})},
      {Labelled(AddPoint(1), {0, "b"})},
      {Labelled(AddPoint(1), {0, "a"}), AddPoint(2)},
      {AddPoint(1), Labelled(AddPoint(2), {0, "a"})},
  };
  for (std::size_t i = 0; i < batches.size(); ++i) {
    EXPECT_EQ(FingerprintOf(batches[i]), FingerprintOf(EditBatch(batches[i])));
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_NE(FingerprintOf(batches[i]), FingerprintOf(batches[k])) << i << " " << k;
    }
  }
}

TEST(MeshName, IsCheckedToTheLetter) {
  for (const char* good : {"meshes/a", "meshes/plate-2", "meshes/a0-"}) {
    EXPECT_TRUE(ParseMeshName(good).ok()) << good;
  }
  const std::string longest = "meshes/a" + std::string(62, 'b');
  EXPECT_TRUE(ParseMeshName(longest).ok());
  for (const std::string& bad :
       {std::string(""), std::string("a"), std::string("meshes/"), std::string("meshes/A"),
        std::string("meshes/1a"), std::string("meshes/-a"), std::string("meshes/a/b"),
        std::string("meshes/a_b"), std::string("Meshes/a"), longest + "b"}) {
    EXPECT_EQ(ReasonOf(ParseMeshName(bad).status()), codec::reason::kBadName) << bad;
  }
}

TEST(Config, DefaultsAreValidAndOnLoopback) {
  EXPECT_TRUE(ValidateConfig(ServerConfig()).ok());
  EXPECT_EQ(ServerConfig().listen.rfind("127.0.0.1:", 0), 0u);
  ServerConfig bad;
  bad.max_pending_edits = bad.max_batch_edits - 1;
  EXPECT_FALSE(ValidateConfig(bad).ok());
  bad = ServerConfig();
  bad.max_meshes = 0;
  EXPECT_FALSE(ValidateConfig(bad).ok());
}

TEST(LogLevel, IsNamed) {
  EXPECT_FALSE(SetLogLevel("loud").ok());
  EXPECT_TRUE(SetLogLevel("error").ok());
  EXPECT_FALSE(LogEnabled(LogLevel::kInfo));
  EXPECT_TRUE(LogEnabled(LogLevel::kError));
}

TEST(Log, MessagesThatDoNotParseDoNotFillIt) {
  for (const char* level : {"info", "debug"}) {
    ASSERT_TRUE(SetLogLevel(level).ok());
    testing::internal::CaptureStderr();
    v1::GetMeshRequest request;
    EXPECT_FALSE(request.ParseFromString("\x0a\x02\xff\xfe"));  // no UTF-8
    const std::string text = testing::internal::GetCapturedStderr();
    if (level == std::string("info")) {
      EXPECT_EQ(text, "");
    } else {
      EXPECT_TRUE(absl::StrContains(text, "level=debug event=protobuf")) << text;
    }
  }
  EXPECT_TRUE(SetLogLevel("error").ok());
}

TEST(Printable, WhatIsNoTextIsEscaped) {
  const std::pair<absl::string_view, absl::string_view> cases[] = {
      {"", ""},
      {"it's a \"name\"", "it's a \"name\""},
      {"Gr\xc3\xb6\xc3\x9f\x65 \xe2\x82\xac \xf0\x9f\x98\x80",
       "Gr\xc3\xb6\xc3\x9f\x65 \xe2\x82\xac \xf0\x9f\x98\x80"},
      {"m\xb3", "m\\xb3"},
      {absl::string_view("a\0b\n\x7f", 5), "a\\x00b\\x0a\\x7f"},
      {"\xc3", "\\xc3"},                             // cut
      {"\xc0\x80", "\\xc0\\x80"},                    // overlong
      {"\xed\xa0\x80", "\\xed\\xa0\\x80"},           // a surrogate
      {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"},  // too large
      {"\xe2\x82x", "\\xe2\\x82x"},
  };
  for (const auto& [bytes, text] : cases) EXPECT_EQ(Printable(bytes), text);
}

TEST(Log, BytesThatAreNoTextAreEscaped) {
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  Log(LogLevel::kInfo, "test", {{"mesh", "m\xb3"}});
  const std::string line = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(absl::StrContains(line, "mesh=\"m\\xb3\"")) << line;
}

TEST(Log, AClientCannotForgeALine) {
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  Log(LogLevel::kInfo, "test", {{"request_id", "a\nlevel=error event=\"forged\" {}"}, {"n", 7}});
  const std::string line = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  EXPECT_NE(line.find("event=test request_id=\"a\\nlevel=error event=\\\"forged\\\" {}\" n=7"),
            std::string::npos)
      << line;
}

}  // namespace
}  // namespace dynmesh::server::parts_test
