#include "proto/codec/mesh_codec.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/labels.h"
#include "core/mesh_data/regions.h"

namespace dynmesh::codec {
namespace {

constexpr std::size_t kIdBytes = 8;
constexpr std::size_t kOwnerBytes = 10;  // the longest varint
constexpr std::size_t kSetBytes = 24;    // of a region set without its polygons

// Passes over the columns in a fixed order. Stops when a message's budget is used up, and resumes
// at (section, row).
class Cutter {
 public:
  Cutter(std::size_t budget, std::size_t* section, std::size_t* row)
      : budget_(budget), section_(section), row_(row) {}

  // Offers the next column: `size` rows of `row_bytes`; copy(begin, end) takes those rows. A
  // message gets at least one row, whatever the budget.
  template <typename Copy>
  void Column(std::size_t size, std::size_t row_bytes, Copy copy) {
    if (!Begin()) return;
    const std::size_t room = std::max<std::size_t>(budget_ / row_bytes, used_ ? 0 : 1);
    const std::size_t count = std::min(size - *row_, room);
    Take(count, count * row_bytes, copy);
    End(size);
  }

  // The same for rows of different size. Calls bytes(row) for each row in turn until one does not
  // fit; the next message calls it for that row again.
  template <typename Bytes, typename Copy>
  void UnevenColumn(std::size_t size, Bytes bytes, Copy copy) {
    if (!Begin()) return;
    std::size_t count = 0;
    std::size_t sum = 0;
    for (; *row_ + count < size; ++count) {
      const std::size_t more = bytes(*row_ + count);
      if (sum + more > budget_ && (used_ || count > 0)) break;
      sum += more;
    }
    Take(count, sum, copy);
    End(size);
  }

  bool AtEnd() const { return *section_ == seen_; }

 private:
  // True iff the pass is at this column.
  bool Begin() {
    const std::size_t self = seen_++;
    return !full_ && self == *section_;
  }
  template <typename Copy>
  void Take(std::size_t count, std::size_t bytes, Copy copy) {
    if (count == 0) return;
    copy(*row_, *row_ + count);
    used_ = true;
    budget_ -= std::min(budget_, bytes);
    *row_ += count;
  }
  void End(std::size_t size) {
    if (*row_ < size) {
      full_ = true;
    } else {
      ++*section_;
      *row_ = 0;
    }
  }

  std::size_t budget_;
  std::size_t* section_;
  std::size_t* row_;
  std::size_t seen_ = 0;
  bool used_ = false;
  bool full_ = false;
};

template <typename Field, typename T>
void AddRange(Field* field, const std::vector<T>& from, std::size_t begin, std::size_t end) {
  field->Add(from.data() + begin, from.data() + end);
}

template <typename Message, typename Get>
void CutVertices(Cutter& cutter, const VertexColumns& v, std::size_t dimension, Message* out,
                 Get get) {
  cutter.Column(
      v.size(), kIdBytes + 8 * dimension + 1 + kOwnerBytes,
      [&](std::size_t begin, std::size_t end) {
        v1::VertexColumns* to = get(out);
        AddRange(to->mutable_ids(), v.ids, begin, end);
        AddRange(to->mutable_coordinates(), v.coordinates, begin * dimension, end * dimension);
        to->mutable_containing_dimensions()->assign(
            reinterpret_cast<const char*>(v.containing_dimensions.data()) + begin, end - begin);
        AddRange(to->mutable_owners(), v.owners, begin, end);
      });
}

// Simplices with their regions.
struct LabelledSimplices {
  const SimplexColumn& simplices;
  const RegionColumn& regions;
  const std::vector<RegionSet>& sets;  // by id
};

const RegionSet* FindSet(const std::vector<RegionSet>& sets, RegionId region) {
  const auto it = std::ranges::lower_bound(sets, region, {}, &RegionSet::id);
  return it != sets.end() && it->id == region ? &*it : nullptr;
}

// Regions of rows, and the sets that these rows name. Empty if all are 0.
void AddRegions(const LabelledSimplices& s, std::size_t begin, std::size_t end,
                v1::SimplexColumn* to) {
  const auto first = s.regions.begin() + static_cast<std::ptrdiff_t>(begin);
  const RegionColumn regions(first, first + static_cast<std::ptrdiff_t>(end - begin));
  if (std::ranges::count(regions, kNoRegion) == std::ssize(regions)) return;
  AddRange(to->mutable_regions(), regions, 0, regions.size());
  std::vector<RegionId> ids = regions;
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (const RegionId id : ids) {
    const RegionSet* const set = FindSet(s.sets, id);
    if (set == nullptr) continue;
    v1::RegionSet* const out = to->add_region_sets();
    out->set_id(id);
    AddRange(out->mutable_polygons(), set->polygons, 0, set->polygons.size());
  }
}

template <typename Message, typename Get>
void CutSimplices(Cutter& cutter, const LabelledSimplices& s, std::size_t dimension, Message* out,
                  Get get) {
  const std::size_t corners = dimension + 1;
  const std::size_t size = s.simplices.size() / corners;
  const auto copy = [&](std::size_t begin, std::size_t end) {
    v1::SimplexColumn* to = get(out);
    AddRange(to->mutable_vertex_ids(), s.simplices, begin * corners, end * corners);
    if (!s.regions.empty()) AddRegions(s, begin, end, to);
  };
  if (s.regions.empty()) return cutter.Column(size, kIdBytes * corners, copy);
  absl::flat_hash_set<RegionId> brought;
  RegionId last = kNoRegion;
  const auto bytes = [&](std::size_t row) {
    const std::size_t own = kIdBytes * (corners + 1);
    const RegionId region = s.regions[row];
    if (region == last || !brought.insert(region).second) return own;
    last = region;
    const RegionSet* const set = FindSet(s.sets, region);
    return set == nullptr ? own : own + kSetBytes + kOwnerBytes * set->polygons.size();
  };
  cutter.UnevenColumn(size, bytes, copy);
}

auto* MutableIds(v1::SubsegmentColumns* s) { return s->mutable_ends(); }
auto* MutableIds(v1::SubfacetColumns* s) { return s->mutable_corners(); }

// Subsegments or subfacets.
template <typename Columns, typename Message, typename Get>
void CutConstraints(Cutter& cutter, const Columns& constraints, Message* out, Get get) {
  constexpr std::size_t kIds = mesh_data::kCorners<Columns>;
  cutter.Column(constraints.size(), kIds * kIdBytes + kOwnerBytes,
                [&](std::size_t begin, std::size_t end) {
                  auto* to = get(out);
                  AddRange(MutableIds(to), mesh_data::IdsOf(constraints), kIds * begin, kIds * end);
                  AddRange(to->mutable_owners(), constraints.owners, begin, end);
                });
}

// Columns of zeros or empty names are left out.
template <typename Message>
void CutLabels(Cutter& cutter, const LabelColumn& labels, Message* out) {
  const auto bytes = [&](std::size_t row) {
    return 3 * kOwnerBytes + labels[row].label.name.size();
  };
  cutter.UnevenColumn(labels.size(), bytes, [&](std::size_t begin, std::size_t end) {
    v1::LabelColumns* const to = out->mutable_labels();
    const std::span rows(labels.data() + begin, labels.data() + end);
    for (const LabelOfFeature& row : rows) to->add_features(row.id);
    const auto has_marker = [](const LabelOfFeature& row) { return row.label.marker != 0; };
    const auto has_name = [](const LabelOfFeature& row) { return !row.label.name.empty(); };
    if (std::ranges::any_of(rows, has_marker)) {
      for (const LabelOfFeature& row : rows) to->add_markers(row.label.marker);
    }
    if (std::ranges::any_of(rows, has_name)) {
      for (const LabelOfFeature& row : rows) to->add_names(row.label.name);
    }
  });
}

void CutDiff(Cutter& cutter, const MeshDiff& diff, v1::MeshDiff* out) {
  const auto dimension = static_cast<std::size_t>(diff.dimension);
  using D = v1::MeshDiff;
  CutSimplices(cutter, {diff.removed_simplices, diff.removed_regions, diff.region_sets}, dimension,
               out, [](D* d) { return d->mutable_removed_simplices(); });
  CutConstraints(cutter, diff.removed_subfacets, out,
                 [](D* d) { return d->mutable_removed_subfacets(); });
  CutConstraints(cutter, diff.removed_subsegments, out,
                 [](D* d) { return d->mutable_removed_subsegments(); });
  cutter.Column(diff.removed_vertices.size(), kIdBytes, [&](std::size_t begin, std::size_t end) {
    AddRange(out->mutable_removed_vertices(), diff.removed_vertices, begin, end);
  });
  CutVertices(cutter, diff.added_vertices, dimension, out,
              [](D* d) { return d->mutable_added_vertices(); });
  CutConstraints(cutter, diff.added_subsegments, out,
                 [](D* d) { return d->mutable_added_subsegments(); });
  CutConstraints(cutter, diff.added_subfacets, out,
                 [](D* d) { return d->mutable_added_subfacets(); });
  CutSimplices(cutter, {diff.added_simplices, diff.added_regions, diff.region_sets}, dimension, out,
               [](D* d) { return d->mutable_added_simplices(); });
  CutLabels(cutter, diff.labels, out);
}

// ---------------------------------------------------------------- assembly

absl::Status Broken(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("broken message from the server: ", what));
}

template <typename T, typename Field>
void Append(std::vector<T>& to, const Field& from) {
  to.insert(to.end(), from.begin(), from.end());
}

bool AppendVertices(VertexColumns& to, const v1::VertexColumns& from, int dimension) {
  const int n = from.ids_size();
  if (static_cast<std::int64_t>(from.coordinates_size()) != std::int64_t{n} * dimension ||
      static_cast<int>(from.containing_dimensions().size()) != n || from.owners_size() != n) {
    return false;
  }
  Append(to.ids, from.ids());
  Append(to.coordinates, from.coordinates());
  Append(to.containing_dimensions, from.containing_dimensions());
  Append(to.owners, from.owners());
  return true;
}

// Sets of earlier messages may be repeated: KeepNamed merges them.
bool AppendSets(std::vector<RegionSet>& to, const v1::SimplexColumn& from) {
  std::vector<RegionSet> sets;
  for (const v1::RegionSet& set : from.region_sets()) {
    sets.push_back({set.id(), {set.polygons().begin(), set.polygons().end()}});
  }
  if (!mesh_data::AreRegionSets(sets)) return false;
  std::ranges::move(sets, std::back_inserter(to));
  return true;
}

bool AppendSimplices(SimplexColumn& to, RegionColumn& regions, const v1::SimplexColumn& from,
                     int dimension) {
  const auto corners = static_cast<std::size_t>(dimension) + 1;
  const auto size = static_cast<std::size_t>(from.vertex_ids_size());
  if (size % corners != 0) return false;
  if (from.regions_size() > 0) {
    if (static_cast<std::size_t>(from.regions_size()) != size / corners) return false;
    regions.resize(to.size() / corners, kNoRegion);  // of messages without regions
    Append(regions, from.regions());
  } else if (!regions.empty()) {
    regions.resize((to.size() + size) / corners, kNoRegion);
  }
  Append(to, from.vertex_ids());
  return true;
}

const auto& IdsOf(const v1::SubsegmentColumns& s) { return s.ends(); }
const auto& IdsOf(const v1::SubfacetColumns& s) { return s.corners(); }

template <typename Columns, typename Message>
bool AppendConstraints(Columns& to, const Message& from) {
  constexpr std::int64_t kIds = mesh_data::kCorners<Columns>;
  if (IdsOf(from).size() != kIds * from.owners_size()) return false;
  Append(mesh_data::IdsOf(to), IdsOf(from));
  Append(to.owners, from.owners());
  return true;
}

bool AppendLabels(LabelColumn& to, const v1::LabelColumns& from) {
  const int n = from.features_size();
  const auto fits = [n](int size) { return size == 0 || size == n; };
  if (!fits(from.markers_size()) || !fits(from.names_size())) return false;
  for (int i = 0; i < n; ++i) {
    LabelOfFeature& row = to.emplace_back();
    row.id = from.features(i);
    if (from.markers_size() > 0) row.label.marker = from.markers(i);
    if (from.names_size() > 0) row.label.name = from.names(i);
  }
  return true;
}

bool IsDimension(int dimension) { return dimension == 2 || dimension == 3; }

}  // namespace

DiffFragmenter::DiffFragmenter(std::shared_ptr<const MeshDiff> diff, bool omit_columns,
                               std::size_t fragment_bytes)
    : diff_(std::move(diff)), fragment_bytes_(fragment_bytes), omit_columns_(omit_columns) {}

bool DiffFragmenter::Next(v1::MeshDiff* out) {
  out->Clear();
  if (done_) return false;
  out->set_dimension(diff_->dimension);
  out->set_from_revision(diff_->from_revision);
  out->set_to_revision(diff_->to_revision);
  out->set_columns_omitted(omit_columns_);
  if (!omit_columns_) {
    Cutter cutter(fragment_bytes_, &section_, &row_);
    CutDiff(cutter, *diff_, out);
    out->set_more(!cutter.AtEnd());
  }
  if (!out->more()) {
    done_ = true;
    EncodeWork(diff_->work, out->mutable_work());
    out->set_hash(diff_->hash.ToHex());
  }
  return true;
}

void EncodeWork(const WorkCounters& work, v1::WorkCounters* out) {
  out->set_executed(work.executed);
  out->set_created(work.created);
  out->set_dropped(work.dropped);
  out->set_microseconds(work.microseconds);
  out->set_validate_microseconds(work.validate_microseconds);
  out->set_diff_microseconds(work.diff_microseconds);
  out->set_notified(work.notified);
  out->set_visited_cells(work.visited_cells);
  out->set_visited_nodes(work.visited_nodes);
}

WorkCounters DecodeWork(const v1::WorkCounters& work) {
  return {work.executed(),
          work.created(),
          work.dropped(),
          work.microseconds(),
          work.validate_microseconds(),
          work.diff_microseconds(),
          work.notified(),
          work.visited_cells(),
          work.visited_nodes()};
}

void EncodeTime(absl::Time time, google::protobuf::Timestamp* out) {
  const std::int64_t nanos = absl::ToUnixNanos(time);
  out->set_seconds(nanos / 1'000'000'000);
  out->set_nanos(static_cast<std::int32_t>(nanos % 1'000'000'000));
}

SnapshotFragmenter::SnapshotFragmenter(std::shared_ptr<const Mesh> mesh, std::size_t fragment_bytes)
    : mesh_(std::move(mesh)), fragment_bytes_(fragment_bytes) {}

bool SnapshotFragmenter::Next(v1::SnapshotChunk* out) {
  out->Clear();
  if (done_) return false;
  const auto dimension = static_cast<std::size_t>(mesh_->dimension);
  using C = v1::SnapshotChunk;
  out->set_dimension(mesh_->dimension);
  out->set_revision(mesh_->revision);
  out->set_index(index_);
  if (index_ == 0) {
    out->set_vertex_count(mesh_->vertices.size());
    out->set_simplex_count(mesh_->simplex_count());
    out->set_subsegment_count(mesh_->subsegments.size());
    out->set_subfacet_count(mesh_->subfacets.size());
  }
  Cutter cutter(fragment_bytes_, &section_, &row_);
  CutVertices(cutter, mesh_->vertices, dimension, out, [](C* c) { return c->mutable_vertices(); });
  CutConstraints(cutter, mesh_->subsegments, out, [](C* c) { return c->mutable_subsegments(); });
  CutConstraints(cutter, mesh_->subfacets, out, [](C* c) { return c->mutable_subfacets(); });
  CutSimplices(cutter, {mesh_->simplices, mesh_->regions, mesh_->region_sets}, dimension, out,
               [](C* c) { return c->mutable_simplices(); });
  CutLabels(cutter, mesh_->labels, out);
  ++index_;
  done_ = cutter.AtEnd();
  out->set_more(!done_);
  if (done_) out->set_hash(mesh_->hash.ToHex());
  return true;
}

absl::StatusOr<std::optional<MeshDiff>> DiffAssembler::Add(const v1::MeshDiff& f) {
  const bool first = !diff_.has_value();
  MeshDiff diff = first ? MeshDiff{} : std::move(*diff_);
  diff_.reset();
  if (first) {
    if (!IsDimension(f.dimension())) return Broken("bad dimension");
    diff.dimension = f.dimension();
    diff.from_revision = f.from_revision();
    diff.to_revision = f.to_revision();
  } else if (diff.dimension != f.dimension() || diff.from_revision != f.from_revision() ||
             diff.to_revision != f.to_revision()) {
    return Broken("a diff's fragments belong to different diffs");
  }
  if (!AppendSimplices(diff.removed_simplices, diff.removed_regions, f.removed_simplices(),
                       diff.dimension) ||
      !AppendConstraints(diff.removed_subsegments, f.removed_subsegments()) ||
      !AppendVertices(diff.added_vertices, f.added_vertices(), diff.dimension) ||
      !AppendConstraints(diff.added_subsegments, f.added_subsegments()) ||
      !AppendConstraints(diff.removed_subfacets, f.removed_subfacets()) ||
      !AppendConstraints(diff.added_subfacets, f.added_subfacets()) ||
      !AppendSimplices(diff.added_simplices, diff.added_regions, f.added_simplices(),
                       diff.dimension) ||
      !AppendLabels(diff.labels, f.labels())) {
    return Broken("a diff's columns disagree in length");
  }
  if (!AppendSets(diff.region_sets, f.removed_simplices()) ||
      !AppendSets(diff.region_sets, f.added_simplices())) {
    return Broken("a diff has a region set that is none");
  }
  Append(diff.removed_vertices, f.removed_vertices());
  if (f.more()) {
    diff_ = std::move(diff);
    return std::optional<MeshDiff>();
  }
  absl::StatusOr<MeshHash> hash = MeshHash::FromHex(f.hash());
  if (!hash.ok()) return Broken("a diff's hash is not 32 hex digits");
  diff.hash = *hash;
  if (!mesh_data::AreLabels(diff.labels)) return Broken("a diff's labels are out of order");
  mesh_data::KeepNamed(diff.region_sets, {&diff.removed_regions, &diff.added_regions});
  diff.work = DecodeWork(f.work());
  return std::optional<MeshDiff>(std::move(diff));
}

absl::StatusOr<std::optional<Mesh>> SnapshotAssembler::Add(const v1::SnapshotChunk& c) {
  Mesh mesh;
  if (c.index() == 0) {
    if (!IsDimension(c.dimension())) return Broken("bad dimension");
    mesh.dimension = c.dimension();
    mesh.revision = c.revision();
    mesh_.reset();
    next_index_ = 0;
  } else {
    if (!mesh_.has_value()) return Broken("a snapshot's first chunk is lost");
    mesh = std::move(*mesh_);
    mesh_.reset();
    if (c.index() != next_index_) return Broken("a snapshot's chunk is lost");
    if (c.dimension() != mesh.dimension || c.revision() != mesh.revision) {
      return Broken("a snapshot's chunks belong to different snapshots");
    }
  }
  if (!AppendVertices(mesh.vertices, c.vertices(), mesh.dimension) ||
      !AppendConstraints(mesh.subsegments, c.subsegments()) ||
      !AppendConstraints(mesh.subfacets, c.subfacets()) ||
      !AppendSimplices(mesh.simplices, mesh.regions, c.simplices(), mesh.dimension) ||
      !AppendLabels(mesh.labels, c.labels())) {
    return Broken("a snapshot's columns disagree in length");
  }
  if (!AppendSets(mesh.region_sets, c.simplices())) {
    return Broken("a snapshot has a region set that is none");
  }
  if (c.more()) {
    mesh_ = std::move(mesh);
    ++next_index_;
    return std::optional<Mesh>();
  }
  absl::StatusOr<MeshHash> hash = MeshHash::FromHex(c.hash());
  if (!hash.ok()) return Broken("a snapshot's hash is not 32 hex digits");
  mesh.hash = *hash;
  if (!mesh_data::AreLabelsOfMesh(mesh.labels)) return Broken("a snapshot's labels are broken");
  mesh_data::KeepNamed(mesh.region_sets, {&mesh.regions});
  return std::optional<Mesh>(std::move(mesh));
}

}  // namespace dynmesh::codec
