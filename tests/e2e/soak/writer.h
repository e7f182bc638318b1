// One writer of a mesh: points of its own that are added, moved and removed, a few segments and
// discs, batches, batches that must be refused, and edits that are cancelled while they run and
// then retried. The amounts stay the same on average, so that the server's memory has no reason to
// grow.
//
// Run belongs to one thread.
#ifndef DYNMESH_TESTS_E2E_SOAK_WRITER_H_
#define DYNMESH_TESTS_E2E_SOAK_WRITER_H_

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/synchronization/notification.h"
#include "dynmesh/client/mesh_client.h"
#include "tests/e2e/soak/ledger.h"

namespace dynmesh::soak {

// A mesh of the soak, from the writers' side. Its box is the unit square or cube.
struct MeshPlan {
  std::string name;
  int dimension = 2;
  std::uint64_t vertices = 0;  // after loading
  // Whether to try edits that exceed the vertex limit: they delay the others while they run.
  bool beyond_limit = false;

  double Spacing() const;  // of vertices
};

// Fills the mesh with points with ids below kFirstOwnId, until it has its vertices.
inline constexpr FeatureId kFirstOwnId = 1'000'000'000;
absl::Status LoadMesh(const MeshPlan& plan, client::MeshClient& client, std::uint64_t seed,
                      Ledger& ledger);

class Writer {
 public:
  struct Config {
    MeshPlan plan;
    int index = 0;  // among the writers of the mesh
    int writers = 1;
    double rate = 5;  // batches a second, on average
    std::uint64_t seed = 0;
  };
  // All outlive the writer.
  Writer(const Config& config, client::MeshClient* client, Ledger* ledger, Faults* faults);

  // Until `stop`, or until the server is gone.
  void Run(const absl::Notification& stop);

 private:
  using Place = std::array<double, 3>;
  struct Own {
    struct Point {
      FeatureId id;
      Place place;
    };
    std::vector<Point> points;
    std::vector<bool> slots;  // of segments and discs: is there one?
    FeatureId next_id;
  };

  void Step();
  void SingleEdit();
  void Batch();
  void Refused();
  void Cancelled();

  // Makes an edit, and the writer's features after it.
  Edit PointEdit(Own& own);
  EditBatch RandomBatch(Own& own);
  EditBatch Toggle(Own& own, std::size_t slot);

  // Applies what must succeed; false if it did not.
  bool Apply(const EditBatch& batch, const client::EditParams& params, Latencies* times);
  void Fault(const std::string& what, const absl::Status& status);

  double Unit() { return std::uniform_real_distribution<double>(0.001, 0.999)(random_); }
  std::size_t Below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }
  Place Anywhere();
  Place Near(const Place& place, double reach);
  Place InCell(std::size_t slot);
  Edit AddPoint(FeatureId id, const Place& p) const;
  client::EditParams Params(bool named = false);

  const Config config_;
  client::MeshClient* const client_;
  Ledger* const ledger_;
  Faults* const faults_;
  std::mt19937_64 random_;
  Own own_;
  std::uint64_t requests_ = 0;
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_WRITER_H_
