#include "client/cli/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/text.h"
#include "core/io/formats/formats.h"
#include "core/mesh_data/chambers.h"
#include "core/transfer/scattered.h"

namespace dynmesh::cli {
namespace {

double Distance(const io::IndexedMesh::Vertex& p, const io::IndexedMesh::Vertex& q) {
  return std::hypot(p.x - q.x, p.y - q.y, p.z - q.z);
}

// Attributes of all vertices from those of points.
class Attributes {
 public:
  explicit Attributes(io::IndexedMesh& mesh)
      : mesh_(mesh),
        points_(*mesh.labels.features),
        width_(points_.attributes),
        values_(mesh.vertices.size() * width_, 0),
        known_(mesh.vertices.size(), false) {}

  void Fill() {
    const std::size_t points = points_.values.size() / width_;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      const auto& v = mesh_.vertices[i];
      if (v.containing_dimension != 0 || v.owner == kNoFeature || v.owner > points) continue;
      known_[i] = true;
      for (std::size_t k = 0; k < width_; ++k) {
        values_[i * width_ + k] = points_.values[(v.owner - 1) * width_ + k];
      }
    }
    FillChains();
    FillRest();
    mesh_.labels.attributes = width_;
    mesh_.labels.vertex_values = std::move(values_);
  }

 private:
  using Vertex = std::uint32_t;

  // Segments are cut into chains of subsegments between two points.
  void FillChains() {
    absl::flat_hash_map<Vertex, std::vector<std::pair<Vertex, FeatureId>>> around;
    for (const auto& e : mesh_.edges) {
      if (e.owner == kNoFeature || e.owner == kBoxFeature) continue;
      around[e.a].emplace_back(e.b, e.owner);
      around[e.b].emplace_back(e.a, e.owner);
    }
    std::vector<Vertex> starts;
    for (Vertex v = 0; v < known_.size(); ++v) {
      if (known_[v] && around.contains(v)) starts.push_back(v);
    }
    for (const Vertex start : starts) {
      for (const auto& [next, owner] : around[start]) {
        if (!known_[next]) FillChain(around, start, next, owner);
      }
    }
  }

  template <class Around>
  void FillChain(const Around& around, Vertex start, Vertex next, FeatureId owner) {
    std::vector<Vertex> chain = {start, next};
    while (mesh_.vertices[chain.back()].containing_dimension == 1) {
      const Vertex before = chain[chain.size() - 2];
      const auto& steps = around.at(chain.back());
      const auto step = std::ranges::find_if(
          steps, [&](const auto& s) { return s.second == owner && s.first != before; });
      if (step == steps.end() || chain.size() > mesh_.vertices.size()) return;
      chain.push_back(step->first);
    }
    const Vertex end = chain.back();
    if (!known_[end]) return;
    std::vector<double> way = {0};
    for (std::size_t i = 1; i < chain.size(); ++i) {
      way.push_back(way.back() + Distance(mesh_.vertices[chain[i - 1]], mesh_.vertices[chain[i]]));
    }
    for (std::size_t i = 1; i + 1 < chain.size(); ++i) {
      const double t = way[i] / way.back();
      known_[chain[i]] = true;
      for (std::size_t k = 0; k < width_; ++k) {
        const double from = values_[start * width_ + k], to = values_[end * width_ + k];
        values_[chain[i] * width_ + k] = from + t * (to - from);
      }
    }
  }

  void FillRest() {
    std::vector<double> sources, values, targets;
    std::vector<Vertex> rest;
    const auto append = [&](Vertex v, std::vector<double>& to) {
      const std::array<double, 3> position = mesh_.vertices[v].position();
      to.insert(to.end(), position.begin(), position.begin() + mesh_.dimension);
    };
    for (Vertex v = 0; v < known_.size(); ++v) {
      append(v, known_[v] ? sources : targets);
      if (!known_[v]) {
        rest.push_back(v);
        continue;
      }
      for (std::size_t k = 0; k < width_; ++k) values.push_back(values_[v * width_ + k]);
    }
    if (sources.empty()) return;
    const std::vector<double> found =
        transfer::InterpolateScattered(mesh_.dimension, sources, values, targets);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      for (std::size_t k = 0; k < width_; ++k) {
        values_[rest[i] * width_ + k] = found[i * width_ + k];
      }
    }
  }

  io::IndexedMesh& mesh_;
  const io::FeatureLabels& points_;
  const std::size_t width_;
  std::vector<double> values_;
  std::vector<bool> known_;
};

void LabelRegions(const std::vector<io::SeedRow>& regions, io::IndexedMesh& mesh) {
  std::vector<std::array<double, 3>> seeds;
  std::vector<double> values;
  for (const io::SeedRow& row : regions) {
    if (row.more.empty()) continue;
    seeds.push_back(row.position);
    values.push_back(row.more.front());
    if (!row.name.empty()) mesh.labels.value_names[values.back()] = row.name;
  }
  if (seeds.empty()) return;
  const Mesh rows = io::ToMesh(mesh);
  const mesh_data::Chambers chambers = mesh_data::FindChambers(rows);
  std::vector<double> value_of(chambers.count(), 0);
  std::vector<bool> has_value(chambers.count(), false);
  const auto places = mesh_data::LocateInChambers(rows, chambers, seeds);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::uint32_t c = places[i].chamber;
    if (c == mesh_data::PlaceInChambers::kNone || has_value[c]) continue;  // the first one counts
    value_of[c] = values[i];
    has_value[c] = true;
  }
  for (const std::uint32_t c : chambers.of) mesh.labels.simplex_values.push_back(value_of[c]);
}

}  // namespace

void AddMarkersFlag(CLI::App& command, std::string& text) {
  command
      .add_option(
          "--markers", text,
          text::Concat("Markers of ",
                       io::ListOfFormats(
                           [](const io::Format& f) { return f.Is(io::kChosenMarkers); }, "and"),
                       ": ids of features (owners: of a .node on Steiner points, too), or the "
                       "input's, which Steiner points inherit; then 1 is the border's, and a "
                       "triangle or tetrahedron has the attribute of its region, else the marker "
                       "of its polygon (default: ids; a .vtu has both)"))
      ->type_name("ids|owners|input");
}

absl::Status ParseMarkersFlag(const std::string& text, MeshLabels& labels) {
  if (!text.empty() && text != "ids" && text != "owners" && text != "input") {
    return absl::InvalidArgumentError(
        text::Concat("--markers: expected ids, owners or input, found ", text::Quoted(text)));
  }
  labels.replace_ids = text == "input";
  labels.steiner_ids = text == "owners";
  return absl::OkStatus();
}

void ApplyLabels(const MeshLabels& labels, io::IndexedMesh& mesh) {
  auto features = labels.features;
  if (features == nullptr) features = std::make_shared<const io::FeatureLabels>();
  mesh.labels.steiner_ids = labels.steiner_ids;
  io::LabelRows(std::move(features), labels.replace_ids, mesh);
  if (mesh.labels.features->attributes != 0) Attributes(mesh).Fill();
  LabelRegions(labels.regions, mesh);
}

}  // namespace dynmesh::cli
