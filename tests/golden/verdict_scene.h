// The parts of golden_verdicts.cc: batches, verdicts on them, and lists of both by subject.
#ifndef DYNMESH_TESTS_GOLDEN_VERDICT_SCENE_H_
#define DYNMESH_TESTS_GOLDEN_VERDICT_SCENE_H_

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "tests/differential/differential.h"

namespace dynmesh::test {

inline constexpr double kInf = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// "CODE REASON features A, B edit N: MESSAGE", or "OK".
std::string TextOf(const absl::Status& status);

// A batch in the grammar of edit scripts, with ; for the end of a line.
EditBatch Batch(std::string text, int dimension);

inline EditBatch operator+(EditBatch a, const EditBatch& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// The unit cube.
inline MeshOptions CubeOptions() { return DefaultsIn<3>(); }

// 3D: polygon 10 at z = 0.5, as in space_plc_test.cc, and segment 11 above it.
inline constexpr char kPlate[] =
    "add point 1 0.25 0.25 0.5; add point 2 0.75 0.25 0.5; add point 3 0.75 0.75 0.5; add point 4 "
    "0.25 0.75 0.5; add polygon 10 1 2 3 4; add point 5 0.125 0.125 0.875; add point 6 0.875 0.125 "
    "0.875; add segment 11 5 6";

// A batch and its name.
struct Item {
  const char* name;
  const char* edits;  // as of Batch
};

// Verdicts on batches, one after the other, each on the same features.
class Scene {
 public:
  // Appends to `lines`, which must outlive this. `present` is valid.
  Scene(std::vector<std::string>* lines, std::string name, const MeshOptions& options,
        const EditBatch& present = {}, const LiveMeshTuning& tuning = AlwaysPropagate());

  // Adds the verdict of validation. What it refuses, Apply refuses with the same words, and nothing
  // changes; else there is another line.
  void Validate(const std::string& name, const EditBatch& batch);
  void Validate(std::span<const Item> items);
  // Adds the verdict of a run. `batch` is valid, else there is another line. It is taken back.
  void Apply(const std::string& name, const EditBatch& batch, ApplyOptions options = {});

 private:
  void Add(const std::string& name, const absl::Status& status);

  std::vector<std::string>& lines_;
  const std::string name_;
  const std::unique_ptr<DynamicMesh> mesh_;
};

// What scripts cannot say, 2D and 3D. Points 1 to 4 and segment 11 are present.
void AddMalformed(Scene& scene);
void AddPlanarVerdicts(std::vector<std::string>& lines);
void AddSpaceVerdicts(std::vector<std::string>& lines);
void AddOptionVerdicts(std::vector<std::string>& lines);
// Limits that validation sees, and those that a run exceeds; cancelled runs; ids that collide.
void AddLimitVerdicts(std::vector<std::string>& lines);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_GOLDEN_VERDICT_SCENE_H_
