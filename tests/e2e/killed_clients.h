// Clients of a server that may be killed at any moment. Each knows what was acknowledged, and so
// what the server must have when it is back.
#ifndef DYNMESH_TESTS_E2E_KILLED_CLIENTS_H_
#define DYNMESH_TESTS_E2E_KILLED_CLIENTS_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/edit_session.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "proto/codec/status_codec.h"
#include "tests/support/seed.h"

namespace dynmesh::test {

using client::MeshClient;
inline std::string ReasonOf(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  return error.has_value() ? error->reason : "";
}

// No answer came: only the server's journal determines whether it was applied.
inline bool WasNotAnswered(const absl::Status& status) { return absl::IsUnavailable(status); }

using FeatureMap = std::map<FeatureId, Feature>;

inline void Act(const EditBatch& batch, FeatureMap& features) {
  for (const Edit& edit : batch) {
    if (edit.action == Edit::Action::kRemove) {
      features.erase(edit.feature.id);
    } else {
      features[edit.feature.id] = edit.feature;
    }
  }
}

// A legal one. `last_id` is that of the last point added.
inline EditBatch RandomBatch(const FeatureMap& features, FeatureId& last_id,
                             std::mt19937_64& random) {
  // A grid, so that no two are too close.
  const auto place = [&] { return 0.1 + 0.8 / 64 * static_cast<double>(random() % 64); };
  EditBatch batch;
  FeatureMap draft = features;
  const int count = 1 + static_cast<int>(random() % 4);
  while (static_cast<int>(batch.size()) < count) {
    Edit edit = Edit::Add(Feature::Point(++last_id, place(), place()));
    if (!draft.empty() && (random() % 3 == 0 || draft.size() > 300)) {
      auto it = draft.begin();
      std::advance(it, random() % draft.size());
      edit = random() % 2 == 0 ? Edit::Remove(it->first) : Edit::Move(it->first, place(), place());
    }
    const bool taken = edit.action != Edit::Action::kRemove &&
                       std::any_of(draft.begin(), draft.end(), [&](const auto& f) {
                         return f.second.position == edit.feature.position;
                       });
    if (taken) continue;
    Act({edit}, draft);
    batch.push_back(edit);
  }
  return batch;
}

// The server has the mesh of these features, with that hash.
inline void ExpectMesh(MeshClient& client, const std::string& id, const FeatureMap& features,
                       const MeshHash& hash) {
  std::vector<Feature> all;
  for (const auto& [feature_id, feature] : features) all.push_back(feature);
  auto scratch = *DynamicMesh::Create(MeshOptions());
  ASSERT_TRUE(scratch->Apply(AddAll(all)).ok());
  ASSERT_EQ(hash, scratch->hash());
  auto theirs = client.GetSnapshot(id);
  ASSERT_TRUE(theirs.ok()) << theirs.status();
  Mesh ours = scratch->Snapshot();
  Canonicalize(ours);
  Canonicalize(*theirs);
  ASSERT_EQ(theirs->vertices, ours.vertices);
  ASSERT_EQ(theirs->simplices, ours.simplices);
}

// A client that streams into its mesh and does not wait for answers.
class Streamer {
 public:
  Streamer(std::string id, std::uint64_t seed) : id_(std::move(id)), random_(seed) {}

  // Until the server is gone. Answers come in the order sent, each the next revision.
  void Work(MeshClient& client) {
    const auto session = client.OpenEdits(id_);
    std::thread sender([&] {
      FeatureMap draft = features_;
      while (Send(*session, draft)) {
      }
    });
    while (const auto answer = session->Receive()) {
      if (!answer->result.ok()) {
        EXPECT_TRUE(WasNotAnswered(answer->result.status())) << answer->result.status();
        break;
      }
      Take(*answer);
    }
    session->Cancel();
    sender.join();
    (void)session->Finish();
  }

  // After a restart: all acknowledged batches are present, and the others up to some batch; the
  // retries agree with that.
  void Check(MeshClient& client) {
    SCOPED_TRACE("streamed mesh " + id_);
    const auto info = client.GetMesh(id_);
    ASSERT_TRUE(info.ok()) << info.status();
    ASSERT_GE(info->revision, revision_);
    ASSERT_LE(info->revision, revision_ + pending_.size());
    FeatureMap expected = features_;
    for (std::size_t i = 0; i < info->revision - revision_; ++i) Act(pending_[i].edits, expected);
    ExpectMesh(client, id_, expected, info->hash);
    if (testing::Test::HasFatalFailure()) return;
    unacknowledged_ += info->revision - revision_;
    const auto session = client.OpenEdits(id_);
    const std::deque<Pending> again = pending_;
    std::thread sender([&] {
      for (const Pending& p : again) EXPECT_TRUE(session->Send(p.edits, Params(p)).ok());
      EXPECT_TRUE(session->DoneSending().ok());
    });
    while (const auto answer = session->Receive()) {
      EXPECT_TRUE(answer->result.ok()) << answer->result.status();
      if (!answer->result.ok()) break;
      EXPECT_EQ(answer->result->replayed, revision_ < info->revision);
      Take(*answer);
    }
    sender.join();
    EXPECT_TRUE(session->Finish().ok());
    EXPECT_TRUE(pending_.empty());
    ExpectMesh(client, id_, features_, client.GetMesh(id_)->hash);
  }

  std::uint64_t acknowledged() const { return acknowledged_; }
  // Batches that are in the journal and not answered.
  std::uint64_t unacknowledged() const { return unacknowledged_; }

 private:
  struct Pending {
    std::string request_id;
    EditBatch edits;
  };

  static client::EditParams Params(const Pending& pending) {
    client::EditParams params;
    params.request_id = pending.request_id;
    return params;
  }

  bool Send(client::EditSession& session, FeatureMap& draft) {
    Pending next{absl::StrCat(id_, "-", ++batches_), RandomBatch(draft, last_id_, random_)};
    Act(next.edits, draft);
    {
      const std::lock_guard lock(mutex_);
      pending_.push_back(next);
    }
    return session.Send(next.edits, Params(next)).ok();
  }

  void Take(const client::EditSession::Answer& answer) {
    const std::lock_guard lock(mutex_);
    EXPECT_FALSE(pending_.empty());
    EXPECT_EQ(answer.request_id, pending_.front().request_id);
    EXPECT_EQ(answer.result->diff.to_revision, revision_ + 1);
    Act(pending_.front().edits, features_);
    pending_.pop_front();
    ++revision_;
    ++acknowledged_;
  }

  const std::string id_;
  std::mt19937_64 random_;
  std::mutex mutex_;
  FeatureMap features_;  // acknowledged
  std::uint64_t revision_ = 0;
  std::deque<Pending> pending_;  // sent, or about to be, and not answered
  std::uint64_t batches_ = 0, acknowledged_ = 0, unacknowledged_ = 0;
  FeatureId last_id_ = 0;
};

// A client's knowledge of its mesh.
class Editor {
 public:
  // `once`: its mesh is made once and never deleted.
  Editor(std::string id, std::uint64_t seed, bool once = false)
      : id_(std::move(id)), once_(once), random_(seed) {}

  // Edits, and now and then makes the mesh anew, until the server is gone.
  void Work(MeshClient& client) {
    while (true) {
      const bool done = !created_                       ? Create(client)
                        : !once_ && random_() % 64 == 0 ? Delete(client)
                                                        : Change(client);
      if (!done) return;
    }
  }

  // After a restart: compares, and completes the pending batch.
  void Check(MeshClient& client) {
    SCOPED_TRACE("mesh " + id_);
    if (deleting_ || !created_) {
      const auto info = client.GetMesh(id_);
      if (!info.ok()) {
        ASSERT_EQ(ReasonOf(info.status()), "MESH_NOT_FOUND") << info.status();
        Forget();
        return;
      }
      if (!created_) {
        // The unanswered creation was done.
        ASSERT_TRUE(creating_);
        created_ = true;
      }
      deleting_ = creating_ = false;
    }
    const auto info = client.GetMesh(id_);
    ASSERT_TRUE(info.ok()) << info.status();
    FeatureMap expected = features_;
    const bool applied = info->revision == revision_ + 1;
    if (applied) {
      ASSERT_TRUE(pending_.has_value());
      Act(*pending_, expected);
    } else {
      ASSERT_EQ(info->revision, revision_);
    }
    ExpectMesh(client, id_, expected, info->hash);
    if (testing::Test::HasFatalFailure() || !pending_.has_value()) return;
    const auto again = client.Apply(id_, *pending_, Params());
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(again->replayed, applied);
    EXPECT_EQ(again->diff.to_revision, revision_ + 1);
    Acknowledge();
    ExpectMesh(client, id_, features_, again->diff.hash);
  }

  bool Create(MeshClient& client) {
    creating_ = true;
    const auto made = client.CreateMesh(id_, MeshOptions(), "");
    if (WasNotAnswered(made.status())) return false;
    EXPECT_TRUE(made.ok()) << made.status();
    creating_ = false;
    created_ = made.ok();
    return made.ok();
  }

  std::uint64_t revision() const { return revision_; }
  std::uint64_t acknowledged() const { return acknowledged_; }

 private:
  client::EditParams Params() const {
    client::EditParams params;
    params.request_id = absl::StrCat(id_, "-", batches_);
    return params;
  }

  bool Delete(MeshClient& client) {
    deleting_ = true;
    const absl::Status status = client.DeleteMesh(id_);
    if (WasNotAnswered(status)) return false;
    EXPECT_TRUE(status.ok()) << status;
    Forget();
    return status.ok();
  }

  bool Change(MeshClient& client) {
    ++batches_;
    pending_ = RandomBatch(features_, last_id_, random_);
    const auto result = client.Apply(id_, *pending_, Params());
    if (WasNotAnswered(result.status())) return false;
    EXPECT_TRUE(result.ok()) << result.status();
    if (!result.ok()) return false;
    EXPECT_EQ(result->diff.to_revision, revision_ + 1);
    Acknowledge();
    return true;
  }

  void Acknowledge() {
    Act(*pending_, features_);
    pending_.reset();
    ++revision_;
    ++acknowledged_;
  }

  void Forget() {
    created_ = creating_ = deleting_ = false;
    pending_.reset();
    features_.clear();
    revision_ = 0;
  }

  const std::string id_;
  const bool once_;
  std::mt19937_64 random_;
  bool created_ = false, creating_ = false, deleting_ = false;
  FeatureMap features_;  // acknowledged
  std::uint64_t revision_ = 0;
  std::optional<EditBatch> pending_;  // not answered
  std::uint64_t batches_ = 0, acknowledged_ = 0;
  FeatureId last_id_ = 0;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_E2E_KILLED_CLIENTS_H_
