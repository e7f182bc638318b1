// The guarantees of a journal by itself.
#include "tests/server/journal/journal_contract.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/server/journal/told.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;
using Request = Journal::Request;

TEST_P(JournalTest, KeepsWhatItWasTold) {
  Open();
  const auto a = journal_->Create("a", "about a");
  const auto b = journal_->Create("b", std::string("\0b", 2));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE(absl::IsAlreadyExists(journal_->Create("a", "").status()));
  EXPECT_TRUE(journal_->Append(*a, Entry{1, "one"}, Request{"r1", "A1"}).ok());
  EXPECT_TRUE(journal_->Append(*a, Entry{2, std::string("t\0o", 3)}, std::nullopt).ok());
  EXPECT_TRUE(journal_->Append(*b, std::nullopt, Request{"r1", ""}).ok());
  for (int i = 0; i < 2; ++i) {
    const auto meshes = journal_->List();
    ASSERT_TRUE(meshes.ok());
    ASSERT_EQ(meshes->size(), 2u);
    EXPECT_EQ((*meshes)[0].id, "a");
    EXPECT_EQ((*meshes)[0].key, *a);
    EXPECT_EQ((*meshes)[0].description, "about a");
    EXPECT_EQ((*meshes)[1].description, std::string("\0b", 2));
    EXPECT_EQ(Told(*journal_, *a), std::string("?r1=A1 1:one 2:t\0o ", 19));
    EXPECT_EQ(Told(*journal_, *b), "?r1= ");
    Open();
  }
}

TEST_P(JournalTest, TakesRevisionsInOrderOnly) {
  Open();
  const auto key = *journal_->Create("a", "");
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(key, Entry{2, "x"}, Request{"r", ""})));
  EXPECT_TRUE(journal_->Append(key, Entry{1, "x"}, std::nullopt).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(key, Entry{1, "y"}, std::nullopt)));
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Compact(key, 2, {"s"})));
  EXPECT_EQ(Told(*journal_, key), "1:x ");
}

TEST_P(JournalTest, ASnapshotTakesThePlaceOfEntriesNotOfRequests) {
  Open();
  const auto key = *journal_->Create("a", "");
  for (const std::uint64_t r : {1u, 2u, 3u}) {
    ASSERT_TRUE(journal_->Append(key, Entry{r, "e"}, Request{absl::StrCat("r", r), "A"}).ok());
  }
  ASSERT_TRUE(journal_->Compact(key, 3, {"p0", "p1"}).ok());
  EXPECT_EQ(Told(*journal_, key), "?r1=A ?r2=A ?r3=A @3:p0 @3:p1 ");
  ASSERT_TRUE(journal_->Append(key, Entry{4, "f"}, std::nullopt).ok());
  Open();
  EXPECT_EQ(Told(*journal_, key), "?r1=A ?r2=A ?r3=A @3:p0 @3:p1 4:f ");
  ASSERT_TRUE(journal_->Compact(key, 4, {"q"}).ok());
  EXPECT_EQ(Told(*journal_, key), "?r1=A ?r2=A ?r3=A @4:q ");
}

TEST_P(JournalTest, ForgetsTheOldestRequests) {
  JournalBackend::Options options;
  options.remembered_requests = 2;
  Open(options);
  const auto key = *journal_->Create("a", "");
  for (const char* id : {"r1", "r2", "r3"}) {
    ASSERT_TRUE(journal_->Append(key, std::nullopt, Request{id, "A"}).ok());
  }
  EXPECT_EQ(Told(*journal_, key), "?r2=A ?r3=A ");
}

TEST_P(JournalTest, TheOldestOfManyRequestsGoByTheHundredth) {
  JournalBackend::Options options;
  options.remembered_requests = 400;
  Open(options);
  const auto key = *journal_->Create("a", "");
  const auto told = [&] {
    std::vector<std::string> ids;
    Journal::Visitor visitor;
    visitor.request = [&](const Request& r) {
      ids.push_back(r.id);
      return absl::OkStatus();
    };
    visitor.snapshot = [](std::uint64_t, const std::string&) { return absl::OkStatus(); };
    visitor.entry = [](const Entry&) { return absl::OkStatus(); };
    EXPECT_TRUE(journal_->Read(key, visitor).ok());
    return ids;
  };
  int last = 0;
  for (const int count : {399, 1, 3, 2, 7, 500}) {
    std::vector<Request> requests;
    for (int i = 0; i < count; ++i) requests.push_back({absl::StrCat("r", ++last), "A"});
    ASSERT_TRUE(journal_->Append(key, {}, requests).ok());
    const std::vector<std::string> ids = told();
    const auto least = static_cast<std::size_t>(std::min(last, 400));
    EXPECT_GE(ids.size(), least);
    EXPECT_LT(ids.size(), least + 5);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      EXPECT_EQ(ids[i], absl::StrCat("r", last - static_cast<int>(ids.size() - 1 - i)));
    }
  }
}

TEST_P(JournalTest, ADeletedMeshIsGoneAndItsKeyStaysItsOwn) {
  Open();
  const auto key = *journal_->Create("a", "old");
  ASSERT_TRUE(journal_->Append(key, Entry{1, "x"}, Request{"r", "A"}).ok());
  ASSERT_TRUE(journal_->Delete(key).ok());
  EXPECT_TRUE(absl::IsNotFound(journal_->Delete(key)));
  EXPECT_TRUE(journal_->List()->empty());
  const auto next = *journal_->Create("a", "new");
  EXPECT_NE(next, key);
  EXPECT_TRUE(absl::IsNotFound(journal_->Append(key, Entry{1, "x"}, std::nullopt)));
  EXPECT_TRUE(absl::IsNotFound(journal_->Compact(key, 1, {"x"})));
  EXPECT_EQ(Told(*journal_, next), "");
}

TEST_P(JournalTest, ManyWritersAtOnceLoseNothing) {
  Open();
  constexpr int kWriters = 8, kEach = 20;
  std::vector<Journal::Key> keys;
  for (int w = 0; w < kWriters; ++w) keys.push_back(*journal_->Create(absl::StrCat("m", w), ""));
  std::vector<std::thread> threads;
  for (int w = 0; w < kWriters; ++w) {
    threads.emplace_back([&, w] {
      for (std::uint64_t r = 1; r <= kEach; ++r) {
        EXPECT_TRUE(journal_->Append(keys[w], Entry{r, absl::StrCat(w)}, std::nullopt).ok());
        // An error of one caller does not affect others.
        EXPECT_TRUE(absl::IsFailedPrecondition(
            journal_->Append(keys[w], Entry{r + 5, "no"}, std::nullopt)));
      }
    });
  }
  for (std::thread& t : threads) t.join();
  Open();
  for (int w = 0; w < kWriters; ++w) {
    std::string expected;
    for (int r = 1; r <= kEach; ++r) absl::StrAppend(&expected, r, ":", w, " ");
    EXPECT_EQ(Told(*journal_, keys[w]), expected);
  }
}

TEST_P(JournalTest, BatchesAreAppendedTogetherOrNotAtAll) {
  Open();
  const auto key = *journal_->Create("a", "");
  const std::vector<Entry> three = {{1, "one"}, {2, ""}, {3, "three"}};
  const std::vector<Request> two = {{"r1", "A1"}, {std::string("\0r", 2), ""}};
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(key, {{1, "one"}, {3, "three"}}, two)));
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(key, {{2, "two"}}, two)));
  EXPECT_EQ(Told(*journal_, key), "");
  const std::uint64_t before = journal_->counts().syncs;
  ASSERT_TRUE(journal_->Append(key, three, two).ok());
  EXPECT_EQ(journal_->counts().syncs, before + 1);
  EXPECT_EQ(Told(*journal_, key), std::string("?r1=A1 ?\0r= 1:one 2: 3:three ", 29));
  ASSERT_TRUE(journal_->Append(key, {}, std::vector<Request>{{"r3", "A3"}}).ok());
  ASSERT_TRUE(journal_->Append(key, {{4, "four"}}, std::vector<Request>()).ok());
  EXPECT_EQ(ToldPast(*journal_, key, 2, 4), "1:one 2: 3:three 4:four ");
}

TEST_P(JournalTest, LargeDataComesBackAsItWas) {
  Open();
  const auto key = *journal_->Create("a", "");
  std::string all;
  for (int i = 0; i < 3'000'000; ++i) all += static_cast<char>(i * 7 + i / 256);
  ASSERT_TRUE(journal_->Append(key, {{1, all}, {2, "small"}}, std::vector<Request>()).ok());
  for (std::uint64_t r = 3; r <= 300; ++r) Append(key, r, absl::StrCat("e", r));
  std::string expected = absl::StrCat("1:", all, " 2:small ");
  for (int r = 3; r <= 300; ++r) absl::StrAppend(&expected, r, ":e", r, " ");
  EXPECT_TRUE(Told(*journal_, key) == expected);
  ASSERT_TRUE(journal_->Compact(key, 300, {all, "", all}).ok());
  Open();
  EXPECT_TRUE(Told(*journal_, key) == absl::StrCat("@300:", all, " @300: @300:", all, " "));
}

}  // namespace
}  // namespace dynmesh::server
