// Helpers of the server's tests.
#ifndef DYNMESH_TESTS_SERVER_TEST_SUPPORT_H_
#define DYNMESH_TESTS_SERVER_TEST_SUPPORT_H_

#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "dynmesh/dynamic_mesh.h"
#include "proto/codec/status_codec.h"
#include "server/meshes/mesh_host.h"
#include "tests/server/fake_dynamic_mesh.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {

inline std::string ReasonOf(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  return error.has_value() ? error->reason : "";
}

inline std::string Text(const absl::Status& status) { return status.ToString(); }

// Point `id` in a place of its own.
inline Edit AddPoint(FeatureId id) {
  return Edit::Add(Feature::Point(id, 1.0 / (1.0 + static_cast<double>(id)),
                                  0.5 + 0.25 / (1.0 + static_cast<double>(id))));
}

// `count` of them.
inline EditBatch ManyPoints(FeatureId first, std::size_t count) {
  EditBatch batch;
  for (FeatureId id = first; id < first + count; ++id) batch.push_back(AddPoint(id));
  return batch;
}

// The fake mesh of those points.
inline MeshHash HashOfFake(const std::vector<FeatureId>& points) {
  const auto mesh = *MakeFake(MeshOptions());
  EditBatch batch;
  for (const FeatureId id : points) batch.push_back(AddPoint(id));
  EXPECT_TRUE(mesh->Apply(batch, {}).ok());
  return mesh->hash();
}

// Values handed from callbacks to the test, waited for one by one.
template <typename T>
class Mailbox {
 public:
  void Put(T value) {
    const std::lock_guard lock(mutex_);
    values_.push_back(std::move(value));
    changed_.notify_all();
  }
  // Fails the test, by an exception, after a minute without a value.
  T Take() {
    std::unique_lock lock(mutex_);
    test::WaitUntil("a value", changed_, lock, [this] { return !values_.empty(); });
    T value = std::move(values_.front());
    values_.pop_front();
    return value;
  }
  std::size_t size() {
    const std::lock_guard lock(mutex_);
    return values_.size();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> values_;
};

// A host with a fake mesh, pools included.
class HostFixture : public ::testing::Test {
 protected:
  using Result = absl::StatusOr<EditOutcome>;

  std::shared_ptr<MeshHost> MakeHost(const MeshHost::Options& options = {}) {
    return MeshHost::Create("m", *MakeFake(MeshOptions(), gate_), absl::UnixEpoch(), &writers_,
                            &readers_, options);
  }

  // Submits a job; its outcome goes to `box`.
  static absl::Status Submit(MeshHost& host, EditJob job, Mailbox<Result>& box) {
    job.done = [&box](Result outcome) { box.Put(std::move(outcome)); };
    return host.Apply(std::move(job));
  }

  // Applies and waits.
  static Result Apply(MeshHost& host, EditJob job) {
    Mailbox<Result> box;
    if (absl::Status s = Submit(host, std::move(job), box); !s.ok()) return s;
    return box.Take();
  }
  static Result Apply(MeshHost& host, EditBatch edits, std::string request_id = "") {
    EditJob job;
    job.edits = std::move(edits);
    job.request_id = std::move(request_id);
    return Apply(host, std::move(job));
  }

  std::shared_ptr<FakeGate> gate_ = std::make_shared<FakeGate>();
  WorkerPool writers_{2};
  WorkerPool readers_{2};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_TEST_SUPPORT_H_
