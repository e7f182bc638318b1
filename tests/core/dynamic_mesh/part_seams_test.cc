// Parts that are opened along features. After each edit the copies of vertices are compared with
// those of a union-find over the corners of cells, slow and obvious.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iostream>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/mesh_data/region_filter.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/part.h"
#include "tests/core/dynamic_mesh/part_shadows.h"
#include "tests/support/seed.h"

namespace dynmesh::part_seams_test {
namespace {

std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }

// What does not depend on numbers. A copy is its vertex's slot and the slots of its cells.
using Copy = std::pair<Slot, std::set<Slot>>;
// Corners in order where there is one cell, else ascending; owner; cells.
using Facet = std::tuple<std::vector<Slot>, FeatureId, Slot, Slot>;
struct Content {
  std::set<Copy> copies;
  std::set<Facet> facets;
  std::set<std::pair<Facet, Facet>> twins;
  friend bool operator==(const Content&, const Content&) = default;
};

Facet MakeFacet(std::vector<Slot> corners, FeatureId owner, Slot a, Slot b) {
  if (b == kNoSlot) {
    std::ranges::rotate(corners, std::ranges::min_element(corners));
  } else {
    std::ranges::sort(corners);
    if (a > b) std::swap(a, b);
  }
  return {corners, owner, a, b};
}

Content ContentOf(const MeshPart& part) {
  Content content;
  const auto d = At(part.dimension());
  const std::size_t vertices = part.vertex_slots().size();
  EXPECT_EQ(part.origin().size(), vertices);
  std::vector<std::set<Slot>> cells_of(vertices);
  for (std::size_t i = 0; i < part.cells().size(); ++i) {
    const std::int32_t number = part.cells()[i];
    if (number < 0 || At(number) >= vertices) {
      ADD_FAILURE() << "cell " << i / (d + 1) << " has the corner " << number;
      return content;
    }
    cells_of[At(number)].insert(part.cell_slots()[i / (d + 1)]);
  }
  for (std::size_t i = 0; i < vertices; ++i) {
    const Slot slot = part.vertex_slots()[i];
    EXPECT_EQ(part.origin()[i], part.vertex_numbers()[At(slot)]);
    EXPECT_EQ(part.vertex_slots()[At(part.origin()[i])], slot);
    for (std::size_t k = 0; k < d; ++k) {
      EXPECT_EQ(part.points()[i * d + k], part.points()[At(part.origin()[i]) * d + k]);
    }
    EXPECT_TRUE(content.copies.emplace(slot, cells_of[i]).second);
  }
  const std::size_t rows = part.facet_owners().size();
  std::vector<Facet> facets;
  for (std::size_t row = 0; row < rows; ++row) {
    std::vector<Slot> corners;
    const Slot* const cells = part.facet_cells().data() + 2 * row;
    for (std::size_t k = 0; k < d; ++k) {
      const std::int32_t number = part.facets()[row * d + k];
      corners.push_back(part.vertex_slots()[At(number)]);
      EXPECT_TRUE(cells_of[At(number)].contains(cells[0]));
      EXPECT_TRUE(cells[1] == kNoSlot || cells_of[At(number)].contains(cells[1]));
    }
    facets.push_back(MakeFacet(corners, part.facet_owners()[row], cells[0], cells[1]));
    EXPECT_TRUE(content.facets.insert(facets.back()).second);
  }
  for (std::size_t row = 0; row < rows; ++row) {
    const std::int32_t twin = part.facet_twins()[row];
    if (twin < 0) continue;
    EXPECT_EQ(part.facet_twins()[At(twin)], static_cast<std::int32_t>(row));
    content.twins.emplace(facets[row], facets[At(twin)]);
  }
  return content;
}

class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t Find(std::size_t i) { return parent_[i] == i ? i : parent_[i] = Find(parent_[i]); }
  void Join(std::size_t a, std::size_t b) { parent_[Find(a)] = Find(b); }

 private:
  std::vector<std::size_t> parent_;
};

// By the rows of the mesh, slowly. Corners of cells at one vertex are one copy iff they are joined
// through facets that are not opened. Where no opened facet lies between two cells of the part, all
// corners are.
Content Expected(const SlotMesh& mesh, const mesh_data::RegionChoice& choice,
                 const std::set<FeatureId>& open) {
  Content content;
  const auto d = At(mesh.dimension());
  const std::vector<RegionSet> sets = mesh.region_sets();
  mesh_data::RegionFilter filter(choice, sets);
  std::map<std::vector<Slot>, FeatureId> owners;
  const auto take = [&](const SlotColumn<Slot>& rows, const SlotColumn<FeatureId>& of) {
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (rows[i * d] == kNoSlot) continue;
      std::vector<Slot> key(rows.data() + i * d, rows.data() + (i + 1) * d);
      std::ranges::sort(key);
      owners[key] = of[i];
    }
  };
  d == 2 ? take(mesh.subsegments(), mesh.subsegment_owners())
         : take(mesh.subfacets(), mesh.subfacet_owners());
  // Cells by the vertices of a face, and the face as seen from outside of the cell.
  std::map<std::vector<Slot>, std::vector<std::pair<Slot, std::vector<Slot>>>> faces;
  UnionFind corners(mesh.cells().size());
  const auto corner = [&](Slot cell, Slot vertex) {
    std::size_t i = At(cell) * (d + 1);
    while (mesh.cells()[i] != vertex) ++i;
    return i;
  };
  std::map<Slot, std::vector<Slot>> stars;
  for (std::size_t i = 0; i * (d + 1) < mesh.cells().size(); ++i) {
    const Slot* const row = mesh.cells().data() + i * (d + 1);
    if (row[0] == kNoSlot || !filter.Has(mesh.regions()[i])) continue;
    for (std::size_t k = 0; k <= d; ++k) {
      stars[row[k]].push_back(static_cast<Slot>(i));
      std::vector<Slot> face;
      for (std::size_t j = 1; j <= d; ++j) face.push_back(row[(k + j) % (d + 1)]);
      if (d == 3 && k % 2 == 1) std::swap(face[0], face[1]);
      std::vector<Slot> key = face;
      std::ranges::sort(key);
      faces[key].emplace_back(static_cast<Slot>(i), face);
    }
  }
  std::set<Slot> on_seam;
  for (const auto& [key, sides] : faces) {
    const auto it = owners.find(key);
    const FeatureId owner = it == owners.end() ? kNoFeature : it->second;
    if (sides.size() == 1) {
      content.facets.insert(MakeFacet(sides[0].second, owner, sides[0].first, kNoSlot));
    } else if (it != owners.end() && open.contains(owner)) {
      const Facet a = MakeFacet(sides[0].second, owner, sides[0].first, kNoSlot),
                  b = MakeFacet(sides[1].second, owner, sides[1].first, kNoSlot);
      content.facets.insert({a, b});
      content.twins.insert({{a, b}, {b, a}});
      on_seam.insert(key.begin(), key.end());
    } else {
      for (const Slot vertex : key) {
        corners.Join(corner(sides[0].first, vertex), corner(sides[1].first, vertex));
      }
      if (it == owners.end()) continue;
      content.facets.insert(MakeFacet(key, owner, sides[0].first, sides[1].first));
    }
  }
  for (const auto& [vertex, cells] : stars) {
    std::map<std::size_t, std::set<Slot>> copies;
    for (const Slot cell : cells) {
      const std::size_t copy = corners.Find(corner(cell, vertex));
      copies[on_seam.contains(vertex) ? copy : 0].insert(cell);
    }
    for (const auto& [copy, of] : copies) content.copies.emplace(vertex, of);
  }
  return content;
}

// A plate (3D: a box) between the nodes of a grid, whose edges (3D: squares) come and go as
// segments (polygons), with labels that come and go; a smaller polygon (box) in it; points at
// random, and nodes that move.
class Edits {
 public:
  Edits(int dimension, std::uint64_t seed) : dimension_(dimension), random_(seed) {
    side_ = dimension == 2 ? 6 : 3;
  }

  static constexpr FeatureId kPlate = 7, kInclusion = 8;
  // Features of the grid have ids from here on.
  static constexpr FeatureId kFirst = 10'000;

  EditBatch First() {
    EditBatch batch;
    for (std::size_t i = 0; i < Count(); ++i) {
      const auto p = PositionOf(i, 0.02);
      batch.push_back(Edit::Add(dimension_ == 2 ? Feature::Point(Node(i), p[0], p[1])
                                                : Feature::Point(Node(i), p[0], p[1], p[2])));
    }
    if (dimension_ == 2) {
      std::vector<FeatureId> ring;
      const std::size_t n = side_ - 1;
      for (std::size_t i = 0; i < n; ++i) ring.push_back(Node(Index(i, 0, 0)));
      for (std::size_t i = 0; i < n; ++i) ring.push_back(Node(Index(n, i, 0)));
      for (std::size_t i = n; i > 0; --i) ring.push_back(Node(Index(i, n, 0)));
      for (std::size_t i = n; i > 0; --i) ring.push_back(Node(Index(0, i, 0)));
      batch.push_back(Edit::Add(Feature::Polygon(kPlate, {ring})));
      MakeEdges();
    } else {
      MakeSquares(batch);
    }
    return batch;
  }

  EditBatch Next() {
    EditBatch batch;
    for (int i = static_cast<int>(random_() % 3); i >= 0; --i) {
      switch (random_() % 8) {
        case 0:
          AddPoints(batch);
          break;
        case 1:
          RemovePoint(batch);
          break;
        case 2:
          MoveNode(batch);
          break;
        case 3:
          dimension_ == 2 ? ToggleInclusion(batch) : Toggle(batch);
          break;
        case 4:
          ToggleName(batch);
          break;
        default:
          Toggle(batch);
      }
    }
    return batch;
  }

  std::mt19937_64& random() { return random_; }
  std::size_t toggles() const { return features_.size(); }

 private:
  std::size_t Count() const { return side_ * side_ * (dimension_ == 2 ? 1 : side_); }
  std::size_t Index(std::size_t x, std::size_t y, std::size_t z) const {
    return x + side_ * (y + side_ * z);
  }
  static FeatureId Node(std::size_t i) { return 100 + i; }
  double Unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  // Nodes at the border stay on it; in 3D all stay where squares are flat.
  std::array<double, 3> PositionOf(std::size_t index, double jitter) {
    std::array<double, 3> p = {};
    bool is_inside = dimension_ == 2;
    for (std::size_t k = 0; k < static_cast<std::size_t>(dimension_); ++k, index /= side_) {
      const std::size_t i = index % side_;
      p[k] = 0.1 + 0.8 * static_cast<double>(i) / static_cast<double>(side_ - 1);
      is_inside &= i > 0 && i < side_ - 1;
    }
    if (is_inside) p[0] += jitter * (Unit() - 0.5), p[1] += jitter * (Unit() - 0.5);
    return p;
  }

  void MakeEdges() {
    FeatureId id = kFirst;
    for (std::size_t y = 0; y < side_; ++y) {
      for (std::size_t x = 0; x < side_; ++x) {
        const FeatureId node = Node(Index(x, y, 0));
        const bool is_last = x + 1 == side_, is_top = y + 1 == side_;
        if (!is_last) features_.push_back(Feature::Segment(id++, node, Node(Index(x + 1, y, 0))));
        if (!is_top) features_.push_back(Feature::Segment(id++, Node(Index(x, y + 1, 0)), node));
        if (!is_last && !is_top) {
          features_.push_back(Feature::Segment(id++, node, Node(Index(x + 1, y + 1, 0))));
        }
      }
    }
  }

  // Those at the border stay.
  void MakeSquares(EditBatch& batch) {
    FeatureId id = kFirst;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t at = 0; at < side_; ++at) {
        for (std::size_t i = 0; i + 1 < side_; ++i) {
          for (std::size_t j = 0; j + 1 < side_; ++j) {
            const auto node = [&](std::size_t a, std::size_t b) {
              std::array<std::size_t, 3> p = {};
              p[axis] = at, p[(axis + 1) % 3] = i + a, p[(axis + 2) % 3] = j + b;
              return Node(Index(p[0], p[1], p[2]));
            };
            const Feature square =
                Feature::Polygon(id++, {{node(0, 0), node(1, 0), node(1, 1), node(0, 1)}});
            if (at == 0 || at + 1 == side_) {
              batch.push_back(Edit::Add(square));
            } else {
              features_.push_back(square);
            }
          }
        }
      }
    }
  }

  void Toggle(EditBatch& batch) {
    const Feature& f = features_[random_() % features_.size()];
    if (present_.erase(f.id) > 0) {
      batch.push_back(Edit::Remove(f.id));
    } else {
      batch.push_back(Edit::Add(f));
      present_.insert(f.id);
      if (random_() % 2 == 0) batch.push_back(Edit::SetLabel(f.id, {1, "crack"}));
    }
  }

  void ToggleInclusion(EditBatch& batch) {
    if (present_.erase(kInclusion) > 0) {
      batch.push_back(Edit::Remove(kInclusion));
      return;
    }
    present_.insert(kInclusion);
    const std::size_t lo = 1 + random_() % 2, hi = lo + 1 + random_() % 2;
    std::vector<FeatureId> ring;
    for (std::size_t i = lo; i < hi; ++i) ring.push_back(Node(Index(i, lo, 0)));
    for (std::size_t i = lo; i < hi; ++i) ring.push_back(Node(Index(hi, i, 0)));
    for (std::size_t i = hi; i > lo; --i) ring.push_back(Node(Index(i, hi, 0)));
    for (std::size_t i = hi; i > lo; --i) ring.push_back(Node(Index(lo, i, 0)));
    batch.push_back(Edit::Add(Feature::Polygon(kInclusion, {ring})));
  }

  void ToggleName(EditBatch& batch) {
    if (present_.empty()) return;
    auto it = present_.begin();
    std::advance(it, random_() % present_.size());
    const bool is_crack = random_() % 2 == 0;
    batch.push_back(Edit::SetLabel(*it, {is_crack ? 1 : 2, is_crack ? "crack" : "scratch"}));
  }

  void MoveNode(EditBatch& batch) {
    if (dimension_ == 3) return AddPoints(batch);
    const std::size_t i = random_() % Count();
    const auto p = PositionOf(i, 0.05);
    batch.push_back(Edit::Move(Node(i), p[0], p[1]));
  }

  void AddPoints(EditBatch& batch) {
    for (int k = 0; k < 3; ++k) {
      const FeatureId id = ++last_point_;
      batch.push_back(Edit::Add(dimension_ == 2 ? Feature::Point(id, Unit(), Unit())
                                                : Feature::Point(id, Unit(), Unit(), Unit())));
      points_.push_back(id);
    }
  }

  void RemovePoint(EditBatch& batch) {
    if (points_.empty()) return;
    const std::size_t at = random_() % points_.size();
    batch.push_back(Edit::Remove(points_[at]));
    points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  const int dimension_;
  std::mt19937_64 random_;
  std::size_t side_ = 0;
  std::vector<Feature> features_;
  std::set<FeatureId> present_;
  std::vector<FeatureId> points_;
  FeatureId last_point_ = 100'000;
};

MeshOptions OptionsOf(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = dimension == 2 ? 1.5 : 2.5;
  options.min_dihedral = 0;
  return options;
}

std::set<FeatureId> OpenOf(const SlotMesh& mesh, const PartChoice& choice) {
  std::set<FeatureId> open = {choice.open.begin(), choice.open.end()};
  for (const LabelOfFeature& of : mesh.labels()) {
    if (!of.label.name.empty() && std::ranges::count(choice.open_names, of.label.name) > 0) {
      open.insert(of.id);
    }
  }
  return open;
}

class PartSeamsTest : public testing::TestWithParam<int> {};

using Place = std::array<double, 3>;

// The part as a mesh has its vertices and cells, and of features the facets of each side.
void ExpectToMeshHolds(const MeshPart& part, const SlotMesh& mesh) {
  const absl::StatusOr<Mesh> own = part.ToMesh(mesh);
  ASSERT_TRUE(own.ok()) << own.status();
  ASSERT_EQ(own->vertices.size(), part.vertex_slots().size());
  EXPECT_EQ(own->hash, ComputeHash(*own));
  const auto d = At(part.dimension());
  const auto place_at = [d](const double* coordinates) {
    Place place{};
    std::copy_n(coordinates, d, place.begin());
    return place;
  };
  std::map<VertexId, Place> place_of;
  for (std::size_t v = 0; v < own->vertices.size(); ++v) {
    place_of[own->vertices.ids[v]] = place_at(&own->vertices.coordinates[v * d]);
  }
  ASSERT_EQ(place_of.size(), own->vertices.size()) << "an id stands twice";
  // Rows by the places of their corners, in 2D and 3D in any order of these; and an owner.
  using Rows = std::multiset<std::pair<std::multiset<Place>, std::uint64_t>>;
  Rows cells, own_cells, facets, own_facets;
  for (std::size_t cell = 0; cell < part.cell_slots().size(); ++cell) {
    std::multiset<Place> row, own_row;
    for (std::size_t k = 0; k <= d; ++k) {
      row.insert(place_at(&part.points().data()[At(part.cells()[cell * (d + 1) + k]) * d]));
      own_row.insert(place_of.at(own->simplices.at(cell * (d + 1) + k)));
    }
    cells.insert({row, part.cell_regions()[cell]}), own_cells.insert({own_row, own->region(cell)});
  }
  EXPECT_TRUE(cells == own_cells);
  std::set<std::set<std::int32_t>> seen;  // of two sides with the same corners there is one
  for (std::size_t facet = 0; facet < part.facet_owners().size(); ++facet) {
    if (part.facet_owners()[facet] == kNoFeature) continue;
    const std::int32_t* const corners = &part.facets().data()[facet * d];
    if (!seen.insert({corners, corners + d}).second) continue;
    std::multiset<Place> row;
    for (std::size_t k = 0; k < d; ++k) {
      row.insert(place_at(&part.points().data()[At(corners[k]) * d]));
    }
    facets.insert({row, part.facet_owners()[facet]});
  }
  const std::vector<VertexId>& ids = d == 2 ? own->subsegments.ends : own->subfacets.corners;
  const auto& owners = d == 2 ? own->subsegments.owners : own->subfacets.owners;
  std::set<std::set<VertexId>> sides;  // of cells
  for (std::size_t i = 0; i < own->simplices.size(); ++i) {
    const std::size_t first = i / (d + 1) * (d + 1);
    std::set<VertexId> side(&own->simplices[first], &own->simplices[first] + d + 1);
    side.erase(own->simplices[i]);
    sides.insert(side);
  }
  for (std::size_t facet = 0; facet < owners.size(); ++facet) {
    std::multiset<Place> row;
    for (std::size_t k = 0; k < d; ++k) row.insert(place_of.at(ids[facet * d + k]));
    own_facets.insert({row, owners[facet]});
    EXPECT_TRUE(sides.contains({&ids[facet * d], &ids[facet * d] + d}));
  }
  EXPECT_TRUE(facets == own_facets) << facets.size() << " and " << own_facets.size();
}

TEST_P(PartSeamsTest, CopiesAreThoseOfTheSectorsAfterEachEdit) {
  const int dimension = GetParam();
  const std::uint64_t seed = test::NewSeed();
  std::cout << "seed " << seed << "\n";
  Edits edits(dimension, seed);
  const auto mesher = *DynamicMesh::Create(OptionsOf(dimension));
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  ASSERT_TRUE(mesh.Apply(*mesher->Apply(edits.First())).ok());
  std::vector<FeatureId> all(edits.toggles() + 60), some;
  std::iota(all.begin(), all.end(), Edits::kFirst);
  for (std::size_t i = 0; i < all.size(); i += 2) some.push_back(all[i]);
  const std::vector<PartChoice> choices = {
      {.inside = true, .open = all},
      {.inside = true, .open_names = {"crack"}},
      {.inside = true,
       .without = {Edits::kInclusion},
       .open = some,
       .open_names = {"scratch", "nothing"}},
      {.inside = true, .open = {Edits::kInclusion}, .open_names = {"crack", "scratch"}}};
  std::vector<MeshPart> parts;
  for (const PartChoice& choice : choices) parts.emplace_back(mesh, choice);
  std::vector<test::PartShadows> shadows(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) shadows[p].Follow(parts[p]);
  std::size_t most_twins = 0, most_copies = 0;
  int revisions = 0;
  for (int i = 0; i < (dimension == 2 ? 150 : 60); ++i) {
    std::vector<MeshDiff> diffs;
    for (int k = static_cast<int>(edits.random()() % 2); k >= 0; --k) {
      auto diff = mesher->Apply(edits.Next());
      if (!diff.ok()) continue;  // twice in one batch, or features that cross
      ASSERT_TRUE((diffs.empty() ? mesh.Apply(*diff) : mesh.Extend(*diff)).ok());
      diffs.push_back(*std::move(diff));
    }
    if (diffs.empty()) continue;
    ++revisions;
    std::vector<const MeshDiff*> pointers;
    for (const MeshDiff& diff : diffs) pointers.push_back(&diff);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      ASSERT_TRUE(parts[p].Update(mesh, pointers).ok());
      EXPECT_FALSE(parts[p].changes().is_all);
      shadows[p].Follow(parts[p]);
      mesh_data::RegionChoice regions = {{}, true, choices[p].without};
      const Content expected = Expected(mesh, regions, OpenOf(mesh, choices[p]));
      const Content content = ContentOf(parts[p]);
      ASSERT_TRUE(content.copies == expected.copies) << "part " << p << " at step " << i;
      ASSERT_TRUE(content.facets == expected.facets) << "part " << p << " at step " << i;
      ASSERT_TRUE(content.twins == expected.twins) << "part " << p << " at step " << i;
      ASSERT_TRUE(ContentOf(MeshPart(mesh, choices[p])) == expected) << "part " << p;
      if (i % 10 == 0) {
        ExpectToMeshHolds(parts[p], mesh);  // and is the same, whatever led there
        EXPECT_EQ(parts[p].ToMesh(mesh)->hash, MeshPart(mesh, choices[p]).ToMesh(mesh)->hash);
      }
      most_twins = std::max(most_twins, content.twins.size());
      std::map<Slot, std::size_t> count;
      for (const Copy& copy : content.copies) {
        most_copies = std::max(most_copies, ++count[copy.first]);
      }
    }
  }
  EXPECT_GT(revisions, 30);
  EXPECT_GT(most_twins, 20U);
  EXPECT_GE(most_copies, 3U);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, PartSeamsTest, testing::Values(2, 3));

// The number of copies of the vertex at a place; 0 without one.
std::size_t CopiesAt(const MeshPart& part, const std::array<double, 3>& at) {
  const auto d = At(part.dimension());
  std::size_t count = 0;
  for (std::size_t i = 0; i < part.vertex_slots().size(); ++i) {
    count += std::equal(at.begin(), at.begin() + part.dimension(), part.points().data() + i * d);
  }
  return count;
}

std::size_t CopiesIn(const MeshPart& part) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < part.origin().size(); ++i) count += At(part.origin()[i]) != i;
  return count;
}

TEST(PartSeams, TipsAreClosedAndBranchesAndMouthsAreOpen) {
  const auto mesher = *DynamicMesh::Create(OptionsOf(2));
  const std::vector<Feature> features = {
      Feature::Point(1, 0, 0),        Feature::Point(2, 1, 0),
      Feature::Point(3, 1, 0.5),      Feature::Point(4, 1, 1),
      Feature::Point(5, 0, 1),        Feature::Polygon(7, {{1, 2, 3, 4, 5}}),
      Feature::Point(10, 0.25, 0.5),  Feature::Point(11, 0.5, 0.5),
      Feature::Point(12, 0.75, 0.75), Feature::Segment(20, 10, 11),
      Feature::Segment(21, 11, 3),    Feature::Segment(22, 12, 11)};
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  ASSERT_TRUE(mesh.Apply(*mesher->Apply(AddAll(features))).ok());
  const MeshPart part(mesh, {.polygons = {7}, .open = {20, 21, 22}});
  EXPECT_EQ(CopiesAt(part, {0.25, 0.5}), 1U);   // a tip
  EXPECT_EQ(CopiesAt(part, {0.75, 0.75}), 1U);  // a tip
  EXPECT_EQ(CopiesAt(part, {0.5, 0.5}), 3U);    // a branch
  EXPECT_EQ(CopiesAt(part, {1, 0.5}), 2U);      // a mouth
  EXPECT_EQ(CopiesAt(part, {0, 1}), 1U);
  ExpectToMeshHolds(part, mesh);
  const MeshPart closed(mesh, {.polygons = {7}});
  EXPECT_EQ(CopiesIn(closed), 0U);
  EXPECT_EQ(part.vertex_slots().size() - CopiesIn(part), closed.vertex_slots().size());

  // Sides: left of the segment is 1.
  const std::vector<std::int8_t> sides = *part.FacetSides(mesh, features);
  std::size_t sided = 0;
  for (std::size_t row = 0; row < sides.size(); ++row) {
    const std::int32_t twin = part.facet_twins()[row];
    EXPECT_EQ(twin >= 0, sides[row] != 0);
    if (twin < 0) continue;
    ++sided;
    EXPECT_EQ(sides[row], -sides[At(twin)]);
    const std::int32_t cell = part.cell_numbers()[At(part.facet_cells()[2 * row])];
    double x = 0, y = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t vertex = At(part.cells()[3 * At(cell) + k]);
      x += part.points()[2 * vertex] / 3, y += part.points()[2 * vertex + 1] / 3;
    }
    // 20 and 21 go to the right, 22 from the upper right to the lower left.
    const bool is_left = part.facet_owners()[row] == 22 ? y < x : y > 0.5;
    EXPECT_EQ(sides[row], is_left ? 1 : -1) << part.facet_owners()[row] << " " << x << " " << y;
  }
  EXPECT_GE(sided, 6U);
  // Without the features they are not known.
  EXPECT_EQ(*part.FacetSides(mesh, {}), std::vector<std::int8_t>(sides.size()));
}

TEST(PartSeams, AnOpenedPolygonIsCutOut) {
  const auto mesher = *DynamicMesh::Create(OptionsOf(2));
  const std::vector<Feature> features = {Feature::Point(1, 0, 0),
                                         Feature::Point(2, 1, 0),
                                         Feature::Point(3, 1, 1),
                                         Feature::Point(4, 0, 1),
                                         Feature::Polygon(7, {{1, 2, 3, 4}}),
                                         Feature::Point(11, 0.4, 0.4),
                                         Feature::Point(12, 0.6, 0.4),
                                         Feature::Point(13, 0.6, 0.6),
                                         Feature::Point(14, 0.4, 0.6),
                                         Feature::Polygon(8, {{11, 14, 13, 12}})};
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  ASSERT_TRUE(mesh.Apply(*mesher->Apply(AddAll(features))).ok());
  const MeshPart part(mesh, {.inside = true, .open = {8}});
  EXPECT_EQ(CopiesAt(part, {0.4, 0.4}), 2U);
  const std::vector<std::int8_t> sides = *part.FacetSides(mesh, features);
  std::size_t inside = 0, outside = 0;
  for (std::size_t row = 0; row < sides.size(); ++row) {
    EXPECT_EQ(sides[row] != 0, part.facet_owners()[row] == 8);
    inside += sides[row] == 1, outside += sides[row] == -1;
  }
  EXPECT_EQ(inside, outside);
  EXPECT_GE(inside, 4U);
  // Beside a hole it has one side.
  const MeshPart with_hole(mesh, {.inside = true, .without = {8}, .open = {8}});
  EXPECT_EQ(CopiesIn(with_hole), 0U);
  const std::vector<std::int8_t> outer = *with_hole.FacetSides(mesh, features);
  for (const std::int8_t side : outer) EXPECT_LE(side, 0);
}

// Two triangles that touch in one point stay together there, unless a crack in one of them ends
// there.
TEST(PartSeams, WhatOnlyTouchesIsTakenApartByACrackInItAlone) {
  const auto mesher = *DynamicMesh::Create(OptionsOf(2));
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  ASSERT_TRUE(
      mesh.Apply(*mesher->Apply(AddAll(std::vector<Feature>{
                     Feature::Point(1, 0, 0), Feature::Point(2, 0.5, 0.5), Feature::Point(3, 0, 1),
                     Feature::Point(4, 1, 0), Feature::Point(5, 1, 1),
                     Feature::Polygon(7, {{1, 2, 3}}), Feature::Polygon(8, {{4, 5, 2}}),
                     Feature::Point(10, 0.5, 1), Feature::Segment(20, 2, 10),
                     Feature::Point(11, 0.1, 0.5), Feature::Segment(21, 11, 2)})))
          .ok());
  EXPECT_EQ(CopiesAt(MeshPart(mesh, {.inside = true}), {0.5, 0.5}), 1U);
  EXPECT_EQ(CopiesAt(MeshPart(mesh, {.inside = true, .open = {20}}), {0.5, 0.5}), 1U);
  EXPECT_EQ(CopiesAt(MeshPart(mesh, {.inside = true, .open = {21}}), {0.5, 0.5}), 3U);
  const MeshPart part(mesh, {.inside = true, .open = {21}});
  const std::vector<std::int32_t> all = *part.CellsAround(mesh, part.origin().span());
  EXPECT_EQ(all.size(), part.cell_slots().size());
  const std::int32_t none[] = {static_cast<std::int32_t>(part.origin().size())};
  EXPECT_EQ(part.CellsAround(mesh, none).status().code(), absl::StatusCode::kOutOfRange);
}

// A square crack in a box, or from its middle to a wall.
void CheckSquareInBox(bool reaches_wall) {
  const auto mesher = *DynamicMesh::Create(OptionsOf(3));
  std::vector<Feature> features;
  for (FeatureId i = 0; i < 8; ++i) {
    features.push_back(Feature::Point(1 + i, i & 1 ? 1 : 0, i & 2 ? 1 : 0, i & 4 ? 1 : 0));
  }
  const FeatureId sides[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                 {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (FeatureId i = 0; i < 6; ++i) {
    std::vector<FeatureId> ring;
    for (const FeatureId corner : sides[i]) ring.push_back(1 + corner);
    if (reaches_wall && i == 5) ring = {2, 4, 13, 12};
    features.push_back(Feature::Polygon(20 + i, {ring}));
  }
  // The crack's edge is one of the wall, which is cut there.
  if (reaches_wall) features.push_back(Feature::Polygon(26, {{2, 12, 13, 4, 8, 6}}));
  const double end = reaches_wall ? 1 : 0.75;
  features.insert(
      features.end(),
      {Feature::Point(11, 0.5, 0.25, 0.5), Feature::Point(12, end, 0.25, 0.5),
       Feature::Point(13, end, 0.75, 0.5), Feature::Point(14, 0.5, 0.75, 0.5),
       Feature::Polygon(40, {{11, 12, 13, 14}}), Feature::SizeBox(50, 0, 0, 0.1, 0, 0.1)});
  features.back() =
      Feature::Size(50, {0.5, 0.25, 0.5}, {SizeShape::kBox, 0.1, 0, {end, 0.75, 0.5}});
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  const auto diff = mesher->Apply(AddAll(features));
  ASSERT_TRUE(diff.ok()) << diff.status();
  ASSERT_TRUE(mesh.Apply(*diff).ok());
  const MeshPart part(mesh, {.inside = true, .open = {40}});
  EXPECT_EQ(CopiesAt(part, {0.5, 0.25, 0.5}), 1U);
  // Vertices inside of the square, and on the wall between the crack's corners, have two copies.
  std::size_t front = 0;
  for (std::size_t i = 0; i < part.vertex_slots().size(); ++i) {
    const double x = part.points()[3 * i], y = part.points()[3 * i + 1],
                 z = part.points()[3 * i + 2];
    if (z != 0.5 || x < 0.5 || x > end || y < 0.25 || y > 0.75) continue;
    const bool is_front = x == 0.5 || y == 0.25 || y == 0.75 || (!reaches_wall && x == end);
    front += is_front;
    EXPECT_EQ(CopiesAt(part, {x, y, z}), is_front ? 1U : 2U) << x << " " << y;
  }
  EXPECT_GT(front, 8U);
  EXPECT_GT(CopiesIn(part), 8U);
  ExpectToMeshHolds(part, mesh);
  const std::vector<std::int8_t> facet_sides = *part.FacetSides(mesh, features);
  std::size_t doubled = 0;
  for (std::size_t row = 0; row < facet_sides.size(); ++row) {
    if (part.facet_twins()[row] < 0) continue;
    ++doubled;
    const std::int32_t cell = part.cell_numbers()[At(part.facet_cells()[2 * row])];
    double z = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      z += part.points()[3 * At(part.cells()[4 * At(cell) + k]) + 2] / 4;
    }
    // The ring is counter-clockwise as seen from above.
    EXPECT_EQ(facet_sides[row], z > 0.5 ? 1 : -1);
  }
  EXPECT_GT(doubled, 20U);
  EXPECT_EQ(MeshPart(mesh, {.inside = true}).vertex_slots().size() + CopiesIn(part),
            part.vertex_slots().size());
}

TEST(PartSeams, ACracksFrontInABoxIsClosed) { CheckSquareInBox(false); }
TEST(PartSeams, ACrackIsOpenAtAWall) { CheckSquareInBox(true); }

// The rows that did not change are not written.
TEST(PartSeams, AnEditElsewhereWritesNothing) {
  const auto mesher = *DynamicMesh::Create(OptionsOf(2));
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  ASSERT_TRUE(mesh.Apply(*mesher->Apply(AddAll(std::vector<Feature>{
                             Feature::Point(1, 0.1, 0.1), Feature::Point(2, 0.3, 0.1),
                             Feature::Point(3, 0.3, 0.3), Feature::Point(4, 0.1, 0.3),
                             Feature::Polygon(5, {{1, 2, 3, 4}}), Feature::Segment(6, 1, 3),
                             Feature::SizeDisc(7, 0.2, 0.2, 0.2, 0.02)})))
                  .ok());
  MeshPart part(mesh, {.inside = true, .open = {6}});
  EXPECT_GT(CopiesIn(part), 10U);
  const MeshDiff second = *mesher->Apply(AddAll(std::vector<Feature>{Feature::Point(8, 0.9, 0.9)}));
  ASSERT_TRUE(mesh.Apply(second).ok());
  const MeshDiff* const diffs[] = {&second};
  ASSERT_TRUE(part.Update(mesh, diffs).ok());
  const MeshPart::Changes& changes = part.changes();
  EXPECT_FALSE(changes.is_all);
  EXPECT_TRUE(changes.vertices.empty() && changes.cells.empty() && changes.facets.empty());
  EXPECT_TRUE(changes.vertex_slots.empty() && changes.cell_slots.empty());
}

}  // namespace
}  // namespace dynmesh::part_seams_test
