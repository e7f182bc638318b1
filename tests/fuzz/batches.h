// Batches, packed: a byte of options, then edits. An edit is a byte (its low bits the action, or
// the end of the batch), an id, and its data: a position, two ends, rings or a region with its
// target. Positions are mostly on a coarse grid of the box, so that points coincide, segments meet
// and 3D polygons are planar; some are near others, some are any double.
#ifndef DYNMESH_TESTS_FUZZ_BATCHES_H_
#define DYNMESH_TESTS_FUZZ_BATCHES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/dynamic_mesh/live_mesh.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quality.h"
#include "dynmesh/slot_mesh.h"
#include "tests/differential/differential.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/support/asked.h"
#include "tests/support/workload.h"

namespace dynmesh::fuzz {

// In space the border alone has 386 vertices, and more below a quality of 2. Coarse meshes of few
// further vertices run the same code, and ten times as often.
inline constexpr std::array<test::Asked, 4> kAskedOfSpaceBatches = {
    {{"Rho2", kDefaultQuality3D, Criterion::kEdge},
     {"Rho8", 8, Criterion::kEdge},
     {"ThesisRho4", 4, Criterion::kThesis},
     {"Cured10Rho4", 4, Criterion::kEdge, 10}}};

// The runs from scratch that a mesh is compared with, besides that with a trace and a growing
// triangulation. In 2D all are made for all inputs. In space they take most of the time, and what
// is wrong there depends little on the way to the features: each is made for a fourth.
struct Runs {
  bool with_static = true;  // without a trace
  bool with_svr = true;
  bool with_local = true;  // neighbourhoods from the tree, after every second comparison
};

template <int D>
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

  bool AtEnd() const { return bytes_.empty(); }

  MeshOptions Options() {
    first_ = Byte();
    MeshOptions options;
    options.dimension = D;
    const auto which = static_cast<std::size_t>(first_ % kAskedCount);
    const test::Asked& asked = D == 2 ? test::kAsked[which] : kAskedOfSpaceBatches[which];
    options.quality = asked.quality;
    options.criterion = asked.criterion;
    options.min_dihedral = asked.min_dihedral;
    switch (first_ / kAskedCount % 4) {
      case 0:
      case 1:
        break;  // the unit square or cube
      case 2:
        options.box = {{1e6, -1e6, 2}, {1e6 + 1, -1e6 + 3, 4}};
        break;
      default:
        options.box = {{-3e-9, 5e-10, -1e-9}, {1e-9, 6e-10, 1e-9}};
    }
    options.limits.max_vertices = D == 2 ? kMostVertices : kMostVerticesInSpace;
    box_ = options.box;
    return options;
  }

  // The way of computing, which must not affect the result: edit by edit, or often from scratch.
  LiveMeshTuning Tuning() const {
    LiveMeshTuning tuning = test::AlwaysPropagate();
    if (first_ / (4 * kAskedCount) % 2 == 1) tuning.rebuild.at_least = 3;
    tuning.global_neighbourhoods = first_ / (8 * kAskedCount) % 2 == 0;
    return tuning;
  }

  Runs OfScratch() const {
    if (D == 2) return {};
    const int which = first_ / (16 * kAskedCount);
    return {which == 1, which == 2, which == 3};
  }

  // What is left when there are no more bytes is empty.
  EditBatch Batch() {
    EditBatch batch;
    while (!AtEnd() && batch.size() < kMostFeatures) {
      const std::uint8_t action = Byte() % 16;
      if (action == 0) break;
      if (action <= 2) {
        batch.push_back(Edit::Remove(Id()));
      } else if (action <= 4) {
        const FeatureId id = Id();
        const Place p = Position();
        batch.push_back(Edit::Move(id, p[0], p[1], p[2]));
      } else if (action == 15) {
        const FeatureId id = Id();
        batch.push_back(Edit::SetLabel(id, Label()));
      } else {
        Feature feature = action == 11      ? Polygon()
                          : action == 13    ? Size()
                          : action % 2 == 0 ? Segment()
                                            : Point();
        if (action == 6 || action == 7) feature.label = Label();
        batch.push_back(action == 5 || action == 6 ? Edit::Set(feature) : Edit::Add(feature));
      }
    }
    return batch;
  }

 private:
  using Place = std::array<double, 3>;
  static constexpr int kAskedCount =
      D == 2 ? test::kAskedCount : static_cast<int>(kAskedOfSpaceBatches.size());

  std::uint8_t Byte() {
    if (bytes_.empty()) return 0;
    const auto byte = static_cast<std::uint8_t>(bytes_.front());
    bytes_.remove_prefix(1);
    return byte;
  }

  FeatureId Id() {
    const std::uint8_t byte = Byte();
    return byte == 255 ? kBoxFeature : byte;
  }

  // Now and then none, or a name that is refused.
  FeatureLabel Label() {
    const auto marker = static_cast<std::int8_t>(Byte());
    return {marker, std::string(Byte() % 3, static_cast<char>(Byte()))};
  }

  Feature Point() {
    const FeatureId id = Id();
    const Place p = Position();
    return Feature::Point(id, p[0], p[1], p[2]);
  }

  Feature Segment() {
    const FeatureId id = Id();
    const FeatureId p = Id();
    return Feature::Segment(id, p, Id());
  }

  Rings SomeRings() {
    Rings rings;
    std::uint8_t shape = 0;
    do {
      shape = Byte();
      rings.emplace_back();
      for (int corners = 2 + shape % 6; corners > 0; --corners) rings.back().push_back(Id());
    } while (shape >= 192 && rings.size() < 4);
    return rings;
  }

  Feature Polygon() {
    const FeatureId id = Id();
    return Feature::Polygon(id, SomeRings());
  }

  Feature Size() {
    const FeatureId id = Id();
    const std::uint8_t shape = Byte();
    // Mostly coarse: a run from scratch follows every few batches.
    const double extent = box_.hi[0] - box_.lo[0];
    const double target = shape >= 240 ? AnyDouble() : extent / (1 + Byte() % 8);
    if (shape >= 224 && shape < 240) {
      Path path;
      for (int vertices = shape % 8; vertices > 0; --vertices) path.push_back(Position());
      return Feature::SizeCapsule(id, path, extent * (Byte() - 16) / 512.0, target);
    }
    if (shape % 4 == 3) return Feature::SizePolygon(id, SomeRings(), target);
    const Place p = Position();
    if (shape % 4 == 0) return Feature::Size(id, p, {SizeShape::kPoint, target, 0, {}});
    const double reach = shape >= 248 ? AnyDouble() : extent * Byte() / 512.0;
    if (shape % 4 == 1) return Feature::Size(id, p, {SizeShape::kDisc, target, reach, {}});
    const Place hi = {p[0] + reach, p[1] + reach / 2, D == 2 ? 0 : p[2] + reach};
    return Feature::Size(id, p, {SizeShape::kBox, target, 0, hi});
  }

  // The third number is 0 in 2D.
  Place Position() {
    const std::uint8_t mode = Byte() % 8;
    Place place = {0, 0, 0};
    if (mode == 7) {
      for (std::size_t i = 0; i < D; ++i) place[i] = AnyDouble();
    } else if (mode == 6 && !places_.empty()) {
      place = places_[Byte() % places_.size()];
      for (std::size_t i = 0; i < D; ++i) {
        const auto step = static_cast<std::int8_t>(Byte());
        place[i] += std::ldexp(box_.hi[i] - box_.lo[i], -(Byte() % 64)) * (step / 16.0);
      }
    } else {
      for (std::size_t i = 0; i < D; ++i) {
        const double part = mode == 5 ? (Byte() * 256 + Byte()) / 65535.0 : Byte() % 33 / 32.0;
        place[i] = box_.lo[i] + part * (box_.hi[i] - box_.lo[i]);
      }
    }
    places_.push_back(place);
    return place;
  }

  double AnyDouble() {
    std::array<std::uint8_t, sizeof(double)> raw;
    for (std::uint8_t& byte : raw) byte = Byte();
    double value = 0;
    std::memcpy(&value, raw.data(), sizeof(value));
    return value;
  }

  std::string_view bytes_;
  int first_ = 0;  // the byte of options
  Box box_;
  std::vector<Place> places_;  // all so far
};

template <int D>
class Run {
 public:
  Run(const MeshOptions& options, const LiveMeshTuning& tuning, const Runs& runs)
      : mesh_(options, tuning),
        replica_(SlotMesh::FromMesh(mesh_.Snapshot()).value()),
        runs_(runs) {}

  // Empty, or what is wrong.
  std::string Apply(const EditBatch& batch) {
    is_compared_ = false;
    const std::vector<Feature> before = mesh_.Features();
    const MeshHash hash = mesh_.hash();
    const std::uint64_t revision = mesh_.revision();
    const bool valid = mesh_.Validate(batch).ok();
    const absl::StatusOr<MeshDiff> diff = mesh_.Apply(batch, ApplyOptions{});
    if (!diff.ok()) {
      if (diff.status().message().empty()) return "a refusal without a message";
      if (valid && !absl::IsResourceExhausted(diff.status())) {
        return "valid, but refused: " + diff.status().ToString();
      }
      const bool same =
          mesh_.hash() == hash && mesh_.revision() == revision && mesh_.Features() == before;
      return same ? "" : "a refused batch changed the mesh";
    }
    if (!valid) return "accepted, but not valid";
    if (const absl::Status status = replica_.Apply(*diff); !status.ok()) {
      return "a replica refuses the diff: " + status.ToString();
    }
    return ++accepted_ % 4 == 0 ? Compare() : "";
  }

  std::string Compare() {
    if (std::exchange(is_compared_, true)) return "";
    const Mesh snapshot = mesh_.Snapshot();
    if (!(ComputeHash(snapshot) == mesh_.hash())) return "the snapshot has another hash";
    if (snapshot.labels != replica_.labels()) return "a replica has other labels";
    auto label = snapshot.labels.begin();
    for (const Feature& f : mesh_.Features()) {
      if (!f.label) continue;
      if (label == snapshot.labels.end() || *label++ != LabelOfFeature{f.id, *f.label}) {
        return "the labels are not those of the features";
      }
    }
    if (label != snapshot.labels.end()) return "a label without a feature";
    const bool local = runs_.with_local && accepted_ % 2 == 0;
    return test::CompareWithFresh(mesh_, Fresh(local), runs_.with_static).what;
  }

  // The same features by SVR: a good mesh, or a limit.
  std::string TrySvr() const {
    if (!runs_.with_svr) return "";
    MeshOptions options = mesh_.options();
    options.criterion = Criterion::kEdge;
    options.quality = std::max(options.quality, DefaultQuality(D));
    options.min_dihedral = 0;
    BuildOptions build;
    build.engine = BuildEngine::kSvr;
    const absl::StatusOr<Mesh> mesh = BuildMesh(mesh_.Features(), options, build);
    if (!mesh.ok()) {
      return absl::IsResourceExhausted(mesh.status()) ? "" : "SVR: " + mesh.status().ToString();
    }
    if (!(ComputeHash(*mesh) == mesh->hash)) return "SVR: another hash";
    const QualityReport quality = MeasureQuality(*mesh, options);
    return quality.over_rho == quality.exempt ? "" : "SVR left a simplex that is over rho";
  }

 private:
  // A mesh to be made from scratch. It is kept, also for later inputs, as a new one is made of the
  // bare box first.
  LiveMesh<D>& Fresh(bool local) const {
    struct Kept {
      MeshOptions options;
      bool local;
      std::unique_ptr<LiveMesh<D>> mesh;
    };
    constexpr std::size_t kMostKept = 64;
    static std::vector<Kept>& all = *new std::vector<Kept>;
    for (const Kept& kept : all) {
      if (kept.local == local && kept.options == mesh_.options()) return *kept.mesh;
    }
    if (all.size() == kMostKept) all.clear();
    auto mesh = std::make_unique<LiveMesh<D>>(mesh_.options(), test::AlwaysFromScratch(local));
    all.push_back({mesh_.options(), local, std::move(mesh)});
    return *all.back().mesh;
  }

  LiveMesh<D> mesh_;
  SlotMesh replica_;
  const Runs runs_;
  bool is_compared_ = false;  // nothing was applied since
  std::uint64_t accepted_ = 0;
};

// In D dimensions, `most` batches: empty, or what is wrong, with a script of it.
template <int D>
std::string TryBatches(std::string_view bytes, std::size_t most) {
  Unpacker<D> unpacker(bytes);
  const MeshOptions options = unpacker.Options();
  std::vector<EditBatch> batches;
  Run<D> run(options, unpacker.Tuning(), unpacker.OfScratch());
  std::string problem;
  while (problem.empty() && !unpacker.AtEnd() && batches.size() < most) {
    batches.push_back(unpacker.Batch());
    problem = run.Apply(batches.back());
  }
  if (problem.empty()) problem = run.Compare();
  if (problem.empty()) problem = run.TrySvr();
  return problem.empty() ? "" : problem + "\n" + test::ToScript(options, batches);
}

}  // namespace dynmesh::fuzz

#endif  // DYNMESH_TESTS_FUZZ_BATCHES_H_
