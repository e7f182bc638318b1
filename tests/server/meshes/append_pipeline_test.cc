// What an AppendPipeline gives back, and when.
#include "server/meshes/append_pipeline.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace dynmesh::server {
namespace {

class AppendPipelineTest : public ::testing::Test {
 protected:
  // A batch that made the next revision.
  void AddBatch(const std::string& request_id = "", std::size_t rows = 0) {
    HeldEdit edit = Held(request_id);
    edit.unwritten = true;
    edit.answer.from_revision = revision_;
    edit.answer.to_revision = ++revision_;
    auto diff = std::make_shared<MeshDiff>();
    diff->removed_vertices.resize(rows);
    edit.outcome = EditOutcome{std::move(diff)};
    pipeline_.Add(std::move(edit));
  }
  // An empty batch, to be written for its request_id.
  void AddEmpty(const std::string& request_id) {
    HeldEdit edit = Held(request_id);
    edit.unwritten = true;
    edit.answer.from_revision = edit.answer.to_revision = revision_;
    edit.outcome = EditOutcome{std::make_shared<MeshDiff>()};
    pipeline_.Add(std::move(edit));
  }
  void AddRefusal() {
    HeldEdit edit = Held("");
    edit.outcome = absl::NotFoundError("no such feature");
    pipeline_.Add(std::move(edit));
  }
  // The number of each that was added, in the order of what was given back.
  static std::vector<std::string> Numbers(const std::vector<HeldEdit>& edits) {
    std::vector<std::string> numbers;
    for (const HeldEdit& edit : edits) numbers.push_back(edit.job->call_id);
    return numbers;
  }
  using Strings = std::vector<std::string>;

  AppendPipeline pipeline_{{8, 100'000}};

 private:
  HeldEdit Held(const std::string& request_id) {
    const auto job = std::make_shared<EditJob>();
    job->request_id = request_id;
    job->call_id = std::to_string(added_++);
    return HeldEdit(job);
  }

  std::uint64_t revision_ = 0;
  int added_ = 0;
};

TEST_F(AppendPipelineTest, WhatIsAddedDuringAFlightIsTheNext) {
  EXPECT_TRUE(pipeline_.empty());
  AddBatch();
  AddBatch();
  const auto first = pipeline_.Begin();
  EXPECT_EQ(pipeline_.flight(), first);
  AddBatch();
  EXPECT_EQ(first->batches().size(), 2u);
  EXPECT_EQ(first->batches()[1].answer.to_revision, 2u);
  EXPECT_EQ(pipeline_.revisions(), 3u);
  EXPECT_EQ(pipeline_.waiting(), 1u);
  EXPECT_FALSE(first->ended());
  first->End(absl::OkStatus());
  EXPECT_TRUE(first->ended() && first->written().ok());
  EXPECT_EQ(Numbers(pipeline_.TakeWritten()), (Strings{"0", "1"}));
  EXPECT_EQ(pipeline_.flight(), nullptr);
  EXPECT_EQ(pipeline_.revisions(), 1u);
  EXPECT_EQ(pipeline_.Begin()->batches().front().answer.from_revision, 2u);
  EXPECT_EQ(Numbers(pipeline_.TakeWritten()), (Strings{"2"}));
  EXPECT_TRUE(pipeline_.empty());
}

TEST_F(AppendPipelineTest, AnswersWaitForTheBatchesBeforeThemOnly) {
  AddBatch();
  AddRefusal();
  EXPECT_EQ(pipeline_.Begin()->batches().size(), 1u);
  AddRefusal();
  AddRefusal();
  AddBatch();
  AddRefusal();
  EXPECT_EQ(Numbers(pipeline_.TakeWritten()), (Strings{"0", "1", "2", "3"}));
  EXPECT_EQ(pipeline_.Begin()->batches().size(), 1u);
  EXPECT_EQ(Numbers(pipeline_.TakeWritten()), (Strings{"4", "5"}));
  EXPECT_TRUE(pipeline_.empty());
}

TEST_F(AppendPipelineTest, AllIsGivenBackAfterAFailure) {
  AddBatch();
  AddRefusal();
  pipeline_.Begin();
  AddBatch();
  AddBatch();
  std::size_t flown = 0;
  EXPECT_EQ(Numbers(pipeline_.TakeAll(&flown)), (Strings{"0", "1", "2", "3"}));
  EXPECT_EQ(flown, 2u);
  EXPECT_TRUE(pipeline_.empty());
  EXPECT_EQ(pipeline_.revisions(), 0u);
}

TEST_F(AppendPipelineTest, FindsARequestInFlightOrWaiting) {
  AddBatch("a");
  AddEmpty("b");
  pipeline_.Begin();
  AddBatch("c");
  for (const char* id : {"a", "b", "c"}) {
    ASSERT_NE(pipeline_.Find(id), nullptr) << id;
    EXPECT_EQ(pipeline_.Find(id)->job->request_id, id);
  }
  EXPECT_EQ(pipeline_.Find("d"), nullptr);
  EXPECT_EQ(pipeline_.revisions(), 2u);
  pipeline_.TakeWritten();
  EXPECT_EQ(pipeline_.Find("a"), nullptr);
}

TEST_F(AppendPipelineTest, IsFullByNumberOrByBytes) {
  for (int i = 0; i < 4; ++i) AddBatch();
  pipeline_.Begin();
  for (int i = 0; i < 3; ++i) AddBatch();
  EXPECT_FALSE(pipeline_.full());
  AddRefusal();
  EXPECT_TRUE(pipeline_.full());
  pipeline_.TakeWritten();
  EXPECT_FALSE(pipeline_.full());
  AddBatch("", 13'000);  // 8 bytes each
  EXPECT_TRUE(pipeline_.full());
  pipeline_.Begin();
  EXPECT_TRUE(pipeline_.full());
  pipeline_.TakeWritten();
  EXPECT_FALSE(pipeline_.full());
  AddBatch("", 13'000);
  std::size_t flown = 0;
  pipeline_.TakeAll(&flown);
  EXPECT_EQ(flown, 0u);
  EXPECT_FALSE(pipeline_.full());
}

}  // namespace
}  // namespace dynmesh::server
