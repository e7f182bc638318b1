// Verdicts on MeshOptions.
#include <functional>

#include "tests/golden/verdict_scene.h"

namespace dynmesh::test {
void AddOptionVerdicts(std::vector<std::string>& lines) {
  const auto refused = [&](const std::string& name, const std::function<void(MeshOptions&)>& set,
                           int dimension) {
    MeshOptions options;
    options.dimension = dimension;
    options.quality = DefaultQuality(dimension);
    set(options);
    const absl::Status valid = ValidateOptions(options);
    const absl::Status made = DynamicMesh::Create(options).status();
    const std::string line = "options " + std::to_string(dimension) + "D " + name;
    lines.push_back(line + ": " + TextOf(made));
    if (!valid.ok() && !(valid == made)) lines.push_back(line + " valid: " + TextOf(valid));
  };
  refused(
      "dimension", [](MeshOptions& o) { o.dimension = 4; }, 2);
  for (const int dimension : {2, 3}) {
    const auto with = [&](const std::string& name, const std::function<void(MeshOptions&)>& set) {
      refused(name, set, dimension);
    };
    with("nan", [](MeshOptions& o) { o.box.lo[0] = kNan; });
    with("infinite", [](MeshOptions& o) { o.box.hi[1] = kInf; });
    with("z infinite", [](MeshOptions& o) { o.box.hi[2] = kInf; });
    with("swapped", [](MeshOptions& o) { o.box = {{0, 1, 0}, {1, 0.5, 1}}; });
    with("large", [](MeshOptions& o) { o.box.hi[0] = 0x1p201; });
    with("small", [](MeshOptions& o) { o.box.hi = {0x1p-141, 0, 0}; });
    with("far", [](MeshOptions& o) { o.box = {{0x1p40, 0, 0}, {0x1p40 + 1, 1, 1}}; });
    with("quality low", [](MeshOptions& o) { o.quality = 0.5; });
    with("quality high", [](MeshOptions& o) { o.quality = 101; });
    with("quality nan", [](MeshOptions& o) { o.quality = kNan; });
    with("criterion", [](MeshOptions& o) { o.criterion = static_cast<Criterion>(7); });
    with("thesis", [](MeshOptions& o) {
      o.criterion = Criterion::kThesis;
      o.quality = 1.25;
    });
    with("max_edge negative", [](MeshOptions& o) { o.max_edge = -1; });
    with("max_edge infinite", [](MeshOptions& o) { o.max_edge = kInf; });
    with("max_edge small", [](MeshOptions& o) {
      o.max_edge = 0x1p-10;
      o.limits.max_vertices = 5000;
    });
    with("min_dihedral negative", [](MeshOptions& o) { o.min_dihedral = -1; });
    with("min_dihedral high", [](MeshOptions& o) { o.min_dihedral = 20.5; });
    with("min_dihedral", [](MeshOptions& o) { o.min_dihedral = 10; });
    with("max_vertices low", [](MeshOptions& o) { o.limits.max_vertices = 5; });
    with("max_vertices high", [](MeshOptions& o) { o.limits.max_vertices = 200'000'000; });
    with("max_depth", [](MeshOptions& o) { o.limits.max_depth = 0; });
  }
}

}  // namespace dynmesh::test
