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
#include <string>
#include <string_view>
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

template <int D>
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

  bool AtEnd() const { return bytes_.empty(); }

  MeshOptions Options() {
    first_ = Byte();
    MeshOptions options;
    options.dimension = D;
    const test::Asked& asked =
        D == 2 ? test::kAsked[first_ % kAskedCount] : test::kAskedInSpace[first_ % kAskedCount];
    options.quality = asked.quality;
    options.criterion = asked.criterion;
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
    // In 3D the border alone has some hundreds.
    options.limits.max_vertices = (D == 2 ? 1 : 5) * kMostVertices;
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
  static constexpr int kAskedCount = D == 2 ? test::kAskedCount : test::kAskedInSpaceCount;

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
  Run(const MeshOptions& options, const LiveMeshTuning& tuning)
      : mesh_(options, tuning), replica_(SlotMesh::FromMesh(mesh_.Snapshot()).value()) {}

  // Empty, or what is wrong.
  std::string Apply(const EditBatch& batch) {
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

  std::string Compare() const {
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
    return test::CompareWithScratch(mesh_, accepted_ % 2 == 0).what;
  }

  // The same features by SVR: a good mesh, or a limit.
  std::string TrySvr() const {
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
  LiveMesh<D> mesh_;
  SlotMesh replica_;
  std::uint64_t accepted_ = 0;
};

// In D dimensions, `most` batches: empty, or what is wrong, with a script of it.
template <int D>
std::string TryBatches(std::string_view bytes, std::size_t most) {
  Unpacker<D> unpacker(bytes);
  const MeshOptions options = unpacker.Options();
  std::vector<EditBatch> batches;
  Run<D> run(options, unpacker.Tuning());
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
