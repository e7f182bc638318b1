#include "tests/golden/golden_cases.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <utility>

#include "core/base/mix.h"
#include "core/geometry/angles.h"
#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "core/mesh_data/feature_set.h"
#include "tests/differential/differential.h"
#include "tests/golden/digest.h"
#include "tests/support/polygon_script.h"
#include "tests/support/source_path.h"
#include "tests/support/workload.h"

namespace dynmesh::test {
namespace {

constexpr double kSqrt2 = kDefaultQuality2D;
constexpr std::uint64_t kSeed = 2026, kOtherSeed = 2027;

struct Asking {
  double quality;
  Criterion criterion = Criterion::kEdge;
  double max_edge = 0;
  double min_dihedral = 0;
  MeshKind kind = MeshKind::kDelaunay;
};

std::string NameOf(const Asking& asking) {
  if (asking.kind == MeshKind::kTriangulation) return "_triangulation";
  char text[40];
  std::snprintf(text, sizeof text, "%s_rho%.4g%s", asking.max_edge > 0 ? "_hmax" : "",
                asking.quality, asking.criterion == Criterion::kThesis ? "_thesis" : "");
  std::string name = text;
  if (asking.min_dihedral > 0) name += "_cured" + std::to_string(std::lround(asking.min_dihedral));
  std::replace(name.begin(), name.end(), '.', 'p');
  return name;
}

MeshOptions OptionsOf(int dimension, const Asking& asking) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = asking.quality;
  options.criterion = asking.criterion;
  options.max_edge = asking.max_edge;
  options.min_dihedral = asking.min_dihedral;
  options.kind = asking.kind;
  return options;
}

// Coordinates to multiples of 2^-bits.
EditBatch Rounded(EditBatch batch, int bits) {
  const auto round = [&](double x) { return std::ldexp(std::round(std::ldexp(x, bits)), -bits); };
  for (Edit& edit : batch) {
    for (double& x : edit.feature.position) x = round(x);
    for (double& x : edit.feature.sizing.hi) x = round(x);
    for (auto& vertex : edit.feature.sizing.path) {
      for (double& x : vertex) x = round(x);
    }
  }
  return batch;
}

// Its input is exact on every machine, and finer than what rounding leaves.
bool IsExact(Distribution d) {
  return d == Distribution::kTwoScale || d == Distribution::kSpaceTwoScale;
}

std::string NameOfSeed(std::uint64_t seed) {
  return seed == kSeed ? "" : "_seed" + std::to_string(seed);
}

// Would the batch make segments meet at less than 60 degrees?
bool MakesSharpAngle(const std::vector<Feature>& present, const EditBatch& batch) {
  mesh_data::FeatureSet set;
  if (!set.Apply(AddAll(present)).ok() || !set.Apply(batch).ok()) return false;
  std::map<FeatureId, geometry::Point3> at;
  std::vector<Feature> segments;
  for (const Feature& f : set.Sorted()) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = {f.position};
    if (f.kind == FeatureKind::kSegment) segments.push_back(f);
  }
  for (const Feature& s : segments) {
    for (const Feature& t : segments) {
      for (const std::size_t i : {0, 1}) {
        for (const std::size_t j : {0, 1}) {
          if (s.id >= t.id || s.ends[i] != t.ends[j]) continue;
          const auto apex = at.find(s.ends[i]), a = at.find(s.ends[1 - i]),
                     b = at.find(t.ends[1 - j]);
          if (apex == at.end() || a == at.end() || b == at.end()) continue;
          if (geometry::IsSmallAngle(apex->second, a->second, b->second)) return true;
        }
      }
    }
  }
  return false;
}

GoldenCase WorkloadCase(Distribution d, int n, const Asking& asking, std::uint64_t seed = kSeed) {
  GoldenCase golden;
  golden.name = NameOf(d) + NameOf(asking) + NameOfSeed(seed);
  golden.options = OptionsOf(DimensionOf(d), asking);
  golden.batches = 12;
  golden.script = [d, n, seed] {
    const auto generator = std::make_shared<ScriptGenerator>(d, n, seed);
    return [d, n, seed, generator](int done, const std::vector<Feature>& present) {
      EditBatch batch = done == 0 ? AddAll(MakeFeatures(d, n, seed)) : generator->Next(present);
      return IsExact(d) ? batch : Rounded(std::move(batch), 32);
    };
  };
  return golden;
}

// The same without batches that make sharp angles.
GoldenCase BluntCase(GoldenCase golden) {
  golden.script = [script = golden.script] {
    return [next = script()](int done, const std::vector<Feature>& present) {
      EditBatch batch = next(done, present);
      constexpr FeatureId kAbsent = 1'000'000'000;
      return MakesSharpAngle(present, batch) ? EditBatch{Edit::Remove(kAbsent)} : batch;
    };
  };
  return golden;
}

// The same by another name.
GoldenCase Named(std::string name, GoldenCase golden) {
  golden.name = std::move(name);
  return golden;
}

GoldenCase SolidsCase(PolygonKind kind, const Asking& asking, std::uint64_t seed = kSeed) {
  GoldenCase golden;
  golden.name = "solids_" + NameOf(kind) + NameOf(asking) + NameOfSeed(seed);
  golden.options = OptionsOf(3, asking);
  golden.batches = 12;
  golden.script = [kind, seed] {
    const auto generator = std::make_shared<PolygonScript>(kind, 3, seed);
    return [generator](int, const std::vector<Feature>& present) {
      return Rounded(generator->Next(present), 44);
    };
  };
  return golden;
}

// A test's own files: a missing one is no case less but an end.
template <class T>
T Need(absl::StatusOr<T> value) {
  if (!value.ok()) {
    std::cerr << value.status() << "\n";
    std::abort();
  }
  return *std::move(value);
}

GoldenCase BatchesCase(std::string name, const MeshOptions& options,
                       std::vector<EditBatch> batches) {
  std::replace(name.begin(), name.end(), '-', '_');
  GoldenCase golden;
  golden.name = std::move(name);
  golden.options = options;
  golden.batches = static_cast<int>(batches.size());
  golden.script = [batches = std::move(batches)] {
    return [batches](int done, const std::vector<Feature>&) {
      return batches[static_cast<std::size_t>(done)];
    };
  };
  return golden;
}

std::vector<EditBatch> BatchesOf(const io::EditScript& script) {
  std::vector<EditBatch> batches;
  for (const io::ScriptBatch& batch : script.batches) batches.push_back(batch.edits);
  return batches;
}

const std::string kSource = test::SourcePath();

void AddRegressCases(std::vector<GoldenCase>& cases) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(kSource + "/tests/regress")) {
    if (entry.path().extension() == ".dynmesh") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) {
    const io::EditScript script = Need(io::ReadEditScript(path.string()));
    cases.push_back(
        BatchesCase("regress_" + path.stem().string(), script.Options(), BatchesOf(script)));
  }
}

// The storm along the coast, each step a revision; at another quality the coast alone.
void AddCoastCases(std::vector<GoldenCase>& cases) {
  const io::FileFeatures coast =
      Need(io::ReadPolyFile(kSource + "/deploy/data/coastline-110m.poly"));
  MeshOptions options;
  options.box = io::BoundingBox(coast.features);
  const EditBatch all = AddAll(coast.features);
  for (const Asking& asking : {Asking{1.0}, Asking{2.0}, Asking{kSqrt2, Criterion::kThesis}}) {
    options.quality = asking.quality;
    options.criterion = asking.criterion;
    cases.push_back(BatchesCase("coastline" + NameOf(asking), options, {all}));
  }
  options.quality = kSqrt2;
  options.criterion = Criterion::kEdge;
  std::vector<EditBatch> batches = BatchesOf(Need(io::ReadEditScript(
      kSource + "/deploy/data/storm.dynmesh", {.require_header = false, .dimension = 2})));
  batches.insert(batches.begin(), all);
  cases.push_back(BatchesCase("storm", options, std::move(batches)));
}

void AddBoxCase(std::vector<GoldenCase>& cases) {
  const io::EditScript boxes = Need(io::ReadEditScript(kSource + "/deploy/data/boxes.dynmesh"));
  cases.push_back(BatchesCase("boxes", boxes.Options(), BatchesOf(boxes)));
}

// A script of tests/golden/scripts, with other options than its own, as asked.
GoldenCase ScriptCase(const std::string& name, const Asking& asking) {
  const io::EditScript script =
      Need(io::ReadEditScript(kSource + "/tests/golden/scripts/" + name + ".dynmesh"));
  MeshOptions options = OptionsOf(script.dimension, asking);
  options.box = script.Options().box;
  GoldenCase golden = BatchesCase("script_" + name + NameOf(asking), options, BatchesOf(script));
  golden.is_valid = true;
  return golden;
}

void AddCasesWithDiffs(std::vector<GoldenCase>& cases) {
  using enum Distribution;
  std::vector<GoldenCase> added;
  for (const Asking& asking : {Asking{kSqrt2}, Asking{1.0, Criterion::kEdge, 0.0625}}) {
    added.push_back(ScriptCase("polygons", asking));
  }
  for (const Asking& asking : {Asking{1.0}, Asking{kSqrt2, Criterion::kThesis}}) {
    added.push_back(ScriptCase("polygon-areas", asking));
  }
  for (const double rho : {kSqrt2, 1.0}) added.push_back(ScriptCase("presplits-2d", {rho}));
  added.push_back(ScriptCase("presplits-3d", {2.0}));
  added.push_back(ScriptCase("surfaces", {2.0}));
  for (const Asking& asking : {Asking{2.0}, Asking{2.0, Criterion::kEdge, 0.125}}) {
    added.push_back(ScriptCase("facets", asking));
  }
  const Asking cured = {.quality = 2.0, .min_dihedral = 10};
  for (const Asking& asking : {Asking{kSqrt2}, Asking{2.0, Criterion::kThesis}, cured}) {
    added.push_back(ScriptCase("facet-areas", asking));
  }
  for (const Distribution d : {kUniform, kSized, kPolygons, kSpaceSized}) {
    added.push_back(WorkloadCase(d, 40, {DefaultQuality(DimensionOf(d))}, kOtherSeed));
  }
  added.push_back(SolidsCase(PolygonKind::kNestedBoxes, {2.0}, kOtherSeed));
  for (GoldenCase& golden : added) {
    golden.has_diffs = true;
    cases.push_back(std::move(golden));
  }
}

std::vector<GoldenCase> MakeCases() {
  using enum Distribution;
  std::vector<GoldenCase> cases;
  for (const Distribution d : kAllDistributions) cases.push_back(WorkloadCase(d, 60, {kSqrt2}));
  for (const Distribution d :
       {kUniform, kGrid, kSegmentsTurned, kParallel, kWedges, kSized, kPolygons, kCapsules}) {
    cases.push_back(WorkloadCase(d, 60, {1.0}));
  }
  for (const Distribution d : {kUniform, kCircle, kWedges}) {
    cases.push_back(WorkloadCase(d, 60, {2.0}));
  }
  for (const Distribution d : {kUniform, kSegmentsAxis, kDiagonals, kSized, kPolygons}) {
    cases.push_back(WorkloadCase(d, 60, {kSqrt2, Criterion::kThesis}));
  }
  cases.push_back(WorkloadCase(kSegmentsTurned, 60, {kSqrt2, Criterion::kEdge, 0.05}));
  for (const Distribution d : {kUniform, kGrid, kDiagonals, kSegmentsTurned, kWedges}) {
    cases.push_back(WorkloadCase(d, 60, {.quality = kSqrt2, .kind = MeshKind::kTriangulation}));
  }
  for (const Distribution d : kSpaceDistributions) {
    const GoldenCase golden = WorkloadCase(d, 40, {2.0});
    cases.push_back(d == kSkewGridEdges ? BluntCase(golden) : golden);
  }
  cases.push_back(Named("SkewGridEdges_sharp_rho2", WorkloadCase(kSkewGridEdges, 40, {2.0})));
  for (const Distribution d : {kSpaceUniform, kSphere, kTurnedGridEdges, kSpaceSized}) {
    cases.push_back(WorkloadCase(d, 40, {kSqrt2}));
  }
  cases.push_back(WorkloadCase(kSpaceUniform, 40, {1.2}));
  for (const Distribution d : {kSpaceUniform, kGridEdges}) {
    cases.push_back(WorkloadCase(d, 40, {2.0, Criterion::kThesis}));
  }
  cases.push_back(WorkloadCase(kGridEdges, 40, {2.0, Criterion::kEdge, 0.2}));
  for (const PolygonKind kind : kPolygonKinds) cases.push_back(SolidsCase(kind, {2.0}));
  for (const PolygonKind kind : {PolygonKind::kPlates, PolygonKind::kMixture}) {
    cases.push_back(SolidsCase(kind, {kSqrt2}));
  }
  cases.push_back(SolidsCase(PolygonKind::kNestedBoxes, {2.0, Criterion::kThesis}));
  const Asking cured = {.quality = 2.0, .min_dihedral = 10};
  for (const Distribution d :
       {kSpaceUniform, kSphere, kTurnedGridEdges, kSpaceSized, kSpaceCapsules}) {
    cases.push_back(WorkloadCase(d, 40, cured));
  }
  for (const PolygonKind kind :
       {PolygonKind::kNestedBoxes, PolygonKind::kMixture, PolygonKind::kSharp}) {
    cases.push_back(SolidsCase(kind, cured));
  }
  AddRegressCases(cases);
  AddCoastCases(cases);
  AddBoxCase(cases);
  AddCasesWithDiffs(cases);
  return cases;
}

std::uint64_t HashOf(const std::string& text) {
  std::uint64_t hash = text.size();
  for (const char c : text) hash = Mix(hash ^ static_cast<unsigned char>(c));
  return hash;
}

// Of all revisions.
struct Digests {
  Digest snapshots, diffs;
  friend bool operator==(const Digests&, const Digests&) = default;

  void Add(const DynamicMesh& mesh, const MeshDiff& diff) {
    snapshots.Add(mesh.Snapshot());
    diffs.Add(diff);
  }
};

// Of a mesh that is rebuilt by every batch.
Digests DigestsOfRebuilds(const GoldenCase& golden) {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = 0;
  tuning.rebuild.features = -1;
  const auto mesh =
      InDimension(golden.options.dimension, [&](auto d) -> std::unique_ptr<DynamicMesh> {
        return std::make_unique<LiveMesh<d()>>(golden.options, tuning);
      });
  const GoldenCase::NextBatch next = golden.script();
  Digests digests;
  for (int done = 0; done < golden.batches; ++done) {
    const auto diff = mesh->Apply(next(done, mesh->Features()));
    if (diff.ok()) digests.Add(*mesh, *diff);
  }
  return digests;
}

}  // namespace

const std::vector<GoldenCase>& GoldenCases() {
  static const auto* const cases = new std::vector<GoldenCase>(MakeCases());
  return *cases;
}

GoldenResult RunGoldenCase(const GoldenCase& golden) {
  const auto mesh = NewMesh(golden.options);
  const GoldenCase::NextBatch next = golden.script();
  std::uint64_t all = 0;
  MeshHash trace;
  Digests digests;
  GoldenResult result;
  for (int done = 0; done < golden.batches; ++done) {
    const auto diff = mesh->Apply(next(done, mesh->Features()));
    if (!diff.ok()) {
      if (golden.is_valid) result.problem += diff.status().ToString() + "\n";
      continue;
    }
    if (golden.has_diffs) digests.Add(*mesh, *diff);
    trace = mesh->Audit().trace;
    for (const std::uint64_t part : {mesh->hash().hi, mesh->hash().lo, trace.hi, trace.lo}) {
      all = Mix(all ^ part);
    }
  }
  std::string input;
  for (const Feature& f : mesh->Features()) {
    input += io::FormatEdit(Edit::Add(f), golden.options.dimension) + "\n";
  }
  for (const bool local : {false, true}) {
    result.problem += CompareWithScratch(*mesh, local, !local).what;
  }
  char line[200];
  std::snprintf(line, sizeof line, "%-32s %2d %016llx %s %016llx:%llu %016llx", golden.name.c_str(),
                static_cast<int>(mesh->revision()), static_cast<unsigned long long>(HashOf(input)),
                mesh->hash().ToHex().c_str(), static_cast<unsigned long long>(trace.hi),
                static_cast<unsigned long long>(trace.lo), static_cast<unsigned long long>(all));
  result.line = line;
  if (golden.has_diffs) {
    if (!(DigestsOfRebuilds(golden) == digests)) {
      result.problem += "snapshots or diffs of a rebuilt mesh differ\n";
    }
    std::snprintf(line, sizeof line, " %016llx %016llx",
                  static_cast<unsigned long long>(digests.snapshots.value()),
                  static_cast<unsigned long long>(digests.diffs.value()));
    result.line += line;
  }
  return result;
}

}  // namespace dynmesh::test
