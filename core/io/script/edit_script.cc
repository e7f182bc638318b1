#include "core/io/script/edit_script.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "absl/status/status.h"
#include "core/base/feature_kinds.h"
#include "core/base/size_shapes.h"
#include "core/base/text.h"

namespace dynmesh::io {

using text::Concat;
using text::Quoted;
using text::Split;
using text::View;

namespace {

class ScriptParser {
 public:
  ScriptParser(TextReader reader, const ScriptParseOptions& options)
      : reader_(std::move(reader)), options_(options) {
    script_.name = reader_.name();
    script_.dimension = options.dimension;
  }

  absl::StatusOr<EditScript> Parse() {
    bool first = true;
    while (reader_.Next()) {
      if (auto status = ParseLine(first); !status.ok()) return status;
      first = false;
    }
    if (first && options_.require_header) return MissingHeader();
    EndBatch();
    return std::move(script_);
  }

 private:
  absl::Status Error(std::string_view message) const { return reader_.Error(message); }

  absl::Status MissingHeader() const {
    return Error("the script must start with a line like: mesh dim=2 box=0,0,1,1 rho=1.4142");
  }

  absl::Status ParseLine(bool first) {
    const std::string_view verb = reader_.token(0);
    if (verb == "mesh") {
      return first ? ParseHeader() : Error("the mesh line must be the first of the script");
    }
    if (first && options_.require_header) return MissingHeader();
    if (verb == "commit") return ParseCommit();
    if (verb == "remove") return ParseRemove();
    if (verb == "add") return ParseFeature(Edit::Action::kAdd);
    if (verb == "set") return ParseFeature(Edit::Action::kSet);
    if (verb == "move") return ParseFeature(Edit::Action::kMove);
    if (verb == "marker") return ParseMarker();
    if (verb == "name") return ParseName();
    return Error(Concat("unknown command ", Quoted(verb),
                        ": expected add, set, move, remove, commit, marker or name"));
  }

  absl::Status ParseHeader() {
    script_.has_header = true;
    script_.header_line = reader_.line();
    std::map<std::string_view, std::string_view> values;
    for (std::size_t i = 1; i < reader_.size(); ++i) {
      const std::string_view token = reader_.token(i);
      const std::size_t equals = token.find('=');
      if (equals == std::string_view::npos) {
        return Error(Concat("expected key=value, found ", Quoted(token)));
      }
      const std::string_view key = token.substr(0, equals);
      if (!values.emplace(key, token.substr(equals + 1)).second) {
        return Error(Concat("key ", key, " stands twice"));
      }
    }
    // First, since the number of values of a box depends on it.
    if (const auto dim = values.find("dim"); dim != values.end()) {
      if (dim->second != "2" && dim->second != "3") {
        return Error(Concat("dim must be 2 or 3, found ", Quoted(dim->second)));
      }
      script_.dimension = dim->second[0] - '0';
      values.erase(dim);
    }
    for (const auto& [key, value] : values) {
      if (auto s = ParseOption(key, value); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status ParseOption(std::string_view key, std::string_view value) {
    if (key == "box") {
      absl::StatusOr<Box> box = ParseBox(value, script_.dimension);
      if (!box.ok()) return Error(View(box.status().message()));
      script_.box = *box;
      return absl::OkStatus();
    }
    if (key == "rho" || key == "min_dihedral") {
      double number = 0;
      if (!ParseDouble(value, &number)) {
        return Error(Concat(key, " is not a finite number: ", Quoted(value)));
      }
      (key == "rho" ? script_.quality : script_.min_dihedral) = number;
      return absl::OkStatus();
    }
    if (key == "criterion") {
      absl::StatusOr<Criterion> criterion = ParseCriterion(value);
      if (!criterion.ok()) return Error(View(criterion.status().message()));
      script_.criterion = *criterion;
      return absl::OkStatus();
    }
    if (key == "quality" && value != "none") {
      return Error(
          Concat("quality can only be none, which is kind=triangulation; a bound is "
                 "given as rho, found ",
                 Quoted(value)));
    }
    if (key == "kind" || key == "quality") {
      const absl::StatusOr<MeshKind> kind =
          key == "kind" ? MeshKindOf(value) : MeshKind::kTriangulation;
      if (!kind.ok()) return Error(View(kind.status().message()));
      if (script_.kind) return Error("quality=none stands beside a kind: give one of them");
      script_.kind = *kind;
      return absl::OkStatus();
    }
    if (key == "hmax") {
      double hmax = 0;
      if (!ParseDouble(value, &hmax) || !(hmax > 0)) {
        return Error(Concat("hmax is not a length above 0: ", Quoted(value)));
      }
      script_.max_edge = hmax;
      return absl::OkStatus();
    }
    return Error(Concat("unknown key ", Quoted(key),
                        ": expected dim, box, kind, rho, criterion, hmax or min_dihedral"));
  }

  absl::Status ParseCommit() {
    if (reader_.size() > 1) return TooMany(1);
    EndBatch();
    return absl::OkStatus();
  }

  absl::Status ParseMarker() {
    const absl::StatusOr<FeatureId> id = Id(1, "the feature with the marker");
    if (!id.ok()) return id.status();
    std::int64_t marker = 0;
    if (reader_.size() != 3 || !ParseInt64(reader_.token(2), &marker)) {
      return Error("expected: marker ID N, with a whole number");
    }
    script_.labels.markers.erase(*id);
    if (marker != 0) script_.labels.markers[*id] = marker;
    NoteLabel(*id);
    return absl::OkStatus();
  }

  absl::Status ParseName() {
    const absl::StatusOr<FeatureId> id = Id(1, "the feature with the name");
    if (!id.ok()) return id.status();
    if (reader_.size() < 3) return Error("expected: name ID TEXT");
    std::string name;
    for (std::size_t i = 2; i < reader_.size(); ++i) {
      name += Concat(i == 2 ? "" : " ", reader_.token(i));
    }
    script_.labels.names[*id] = std::move(name);
    NoteLabel(*id);
    return absl::OkStatus();
  }

  absl::Status ParseRemove() {
    const absl::StatusOr<FeatureId> id = Id(1, "the feature to remove");
    if (!id.ok()) return id.status();
    if (reader_.size() > 2) return TooMany(2);
    Add(Edit::Remove(*id));
    return absl::OkStatus();
  }

  // "add|set|move KIND ID ...".
  absl::Status ParseFeature(Edit::Action action) {
    static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);  // below
    if (reader_.size() < 2) {
      return Error(Concat(reader_.token(0), " what? Expected point, segment, polygon or size"));
    }
    const std::string_view kind = reader_.token(1);
    if (action == Edit::Action::kMove && kind != "point") {
      return Error(Concat("only points move: expected move point ID ",
                          script_.dimension == 3 ? "X Y Z" : "X Y", ", found ", Quoted(kind)));
    }
    if (kind == "point") return ParsePoint(action);
    if (kind == "segment") return ParseSegment(action);
    if (kind == "polygon") return ParsePolygon(action);
    if (kind == "size") return ParseSize(action);
    return Error(Concat("unknown kind of feature ", Quoted(kind),
                        ": expected point, segment, polygon or size"));
  }

  absl::Status ParsePoint(Edit::Action action) {
    const absl::StatusOr<FeatureId> id = Id(2, "the point's id");
    if (!id.ok()) return id.status();
    const absl::StatusOr<Position> position = ParsePosition(3, "");
    if (!position.ok()) return position.status();
    if (reader_.size() > 3 + Axes()) return TooMany(3 + Axes());
    const auto& [x, y, z] = *position;
    Add({action, Feature::Point(*id, x, y, z)});
    return absl::OkStatus();
  }

  absl::Status ParseSegment(Edit::Action action) {
    const absl::StatusOr<FeatureId> id = Id(2, "the segment's id");
    if (!id.ok()) return id.status();
    const absl::StatusOr<FeatureId> p = Id(3, "the first end's id");
    if (!p.ok()) return p.status();
    const absl::StatusOr<FeatureId> q = Id(4, "the second end's id");
    if (!q.ok()) return q.status();
    const bool unsplit = EndsInUnsplit();
    if (reader_.size() > (unsplit ? 6 : 5)) return TooMany(unsplit ? 6 : 5);
    Feature segment = Feature::Segment(*id, *p, *q);
    segment.unsplit = unsplit;
    Add({action, std::move(segment)});
    return absl::OkStatus();
  }

  // "add|set polygon ID P1 P2 P3 ... [/ Q1 Q2 Q3 ...] [unsplit]".
  absl::Status ParsePolygon(Edit::Action action) {
    const absl::StatusOr<FeatureId> id = Id(2, "the polygon's id");
    if (!id.ok()) return id.status();
    const bool unsplit = EndsInUnsplit();
    absl::StatusOr<Rings> rings = ParseRings(3, reader_.size() - (unsplit ? 1 : 0));
    if (!rings.ok()) return rings.status();
    Feature polygon = Feature::Polygon(*id, *std::move(rings));
    polygon.unsplit = unsplit;
    Add({action, std::move(polygon)});
    return absl::OkStatus();
  }

  bool EndsInUnsplit() const { return reader_.token(reader_.size() - 1) == kUnsplitWord; }

  // Tokens begin, ..., end - 1: ids of points, with a lone / between rings. Validation checks the
  // number of points of a ring; an empty ring cannot be written.
  absl::StatusOr<Rings> ParseRings(std::size_t begin, std::size_t end) const {
    Rings rings(1);
    for (std::size_t i = begin; i < end; ++i) {
      if (reader_.token(i) == "/") {
        if (rings.back().empty()) return Error("no point stands before this /");
        rings.emplace_back();
        continue;
      }
      const absl::StatusOr<FeatureId> point = Id(i, "a point's id");
      if (!point.ok()) return point.status();
      rings.back().push_back(*point);
    }
    if (!rings.back().empty()) return rings;
    return Error(rings.size() > 1 ? "no point stands after the last /" : "a point's id is missing");
  }

  // "add|set size ID SHAPE ... H", with what the shape uses (edit_script.h).
  absl::Status ParseSize(Edit::Action action) {
    const absl::StatusOr<FeatureId> id = Id(2, "the sizing feature's id");
    if (!id.ok()) return id.status();
    const std::string_view name = reader_.size() > 3 ? reader_.token(3) : std::string_view();
    const SizeShapeUse* const use = FindUse(name);
    if (use == nullptr) {
      return Error(Concat("what size? Expected ", NamesOfSizeShapes(), " after the id, found ",
                          Quoted(name)));
    }
    Feature size = Feature::Size(*id, {0, 0, 0}, {use->shape, 0, 0, {}});
    std::size_t next = 4;
    if (use->position) {
      const absl::StatusOr<Position> position = ParsePosition(next, use->hi ? "0" : "");
      if (!position.ok()) return position.status();
      size.position = *position;
      next += Axes();
    }
    if (use->hi) {
      const absl::StatusOr<Position> hi = ParsePosition(next, "1");
      if (!hi.ok()) return hi.status();
      size.sizing.hi = *hi;
      next += Axes();
    }
    if (use->rings) {  // all but the target
      if (reader_.size() < 5) return Error("a point's id is missing");
      absl::StatusOr<Rings> rings = ParseRings(next, reader_.size() - 1);
      if (!rings.ok()) return rings.status();
      size.rings = *std::move(rings);
      next = reader_.size() - 1;
    }
    if (use->path) {  // all but the radius and the target
      const std::size_t tail = 2;
      while (reader_.size() >= next + Axes() + tail) {
        const absl::StatusOr<Position> vertex = ParsePosition(next, "");
        if (!vertex.ok()) return vertex.status();
        size.sizing.path.push_back(*vertex);
        next += Axes();
      }
      if (size.sizing.path.empty()) return Error("a capsule's first vertex is missing");
      if (reader_.size() > next + tail) {
        return Error(Concat("a capsule has ", Axes(),
                            " coordinates a vertex, a radius and a target ", "length; found ",
                            reader_.size() - 4, " numbers"));
      }
    }
    if (use->radius) {
      const absl::StatusOr<double> radius = reader_.Double(next++, "the radius");
      if (!radius.ok()) return radius.status();
      size.sizing.radius = *radius;
    }
    const absl::StatusOr<double> target = reader_.Double(next++, "the target length");
    if (!target.ok()) return target.status();
    size.sizing.target = *target;
    if (reader_.size() > next) return TooMany(next);
    Add({action, std::move(size)});
    return absl::OkStatus();
  }

  using Position = std::array<double, 3>;
  std::size_t Axes() const { return static_cast<std::size_t>(script_.dimension); }

  // The tokens from `first` on, one per axis; named x, y, z with `suffix` in messages.
  absl::StatusOr<Position> ParsePosition(std::size_t first, std::string_view suffix) const {
    Position position = {0, 0, 0};
    for (std::size_t i = 0; i < Axes(); ++i) {
      const absl::StatusOr<double> value =
          reader_.Double(first + i, Concat(std::string_view("xyz").substr(i, 1), suffix));
      if (!value.ok()) return value.status();
      position[i] = *value;
    }
    return position;
  }

  absl::StatusOr<FeatureId> Id(std::size_t i, std::string_view what) const {
    const absl::StatusOr<std::uint64_t> id = reader_.Uint64(i, what);
    if (!id.ok()) return id.status();
    if (*id == kNoFeature || *id > kLastFeatureId) {
      return Error(Concat(what, " is reserved: ids run from 1 to ", kLastFeatureId,
                          ", those of polygons to ", kLastPolygonId));
    }
    return *id;
  }

  absl::Status TooMany(std::size_t expected) const {
    return Error(Concat("unexpected ", Quoted(reader_.token(expected)), " at the end of the line"));
  }

  void Add(const Edit& edit) {
    batch_.edits.push_back(edit);
    batch_.lines.push_back(reader_.line());
  }

  void NoteLabel(FeatureId id) {
    script_.label_lines.push_back({script_.batches.size(),
                                   id,
                                   {script_.labels.MarkerOf(id), script_.labels.NameOf(id)},
                                   reader_.line()});
  }

  void EndBatch() {
    if (!batch_.edits.empty()) script_.batches.push_back(std::move(batch_));
    batch_ = {};
  }

  TextReader reader_;
  const ScriptParseOptions options_;
  EditScript script_;
  ScriptBatch batch_;
};

}  // namespace

std::string EditScript::Where(std::size_t batch, std::optional<std::size_t> edit) const {
  if (batch >= batches.size() || batches[batch].lines.empty()) return name;
  const std::vector<int>& lines = batches[batch].lines;
  const std::size_t row = edit && *edit < lines.size() ? *edit : 0;
  return Concat(name, ":", lines[row]);
}

std::string EditScript::WhereOption(std::string_view option) const {
  const bool has_dimension = has_header;  // even if the header does not set it
  for (const auto& [name_of, word, is_there] :
       {std::tuple{"quality", "rho", quality.has_value()},
        std::tuple{"box", "box", box.has_value()},
        std::tuple{"max_edge", "hmax", max_edge.has_value()},
        std::tuple{"min_dihedral", "min_dihedral", min_dihedral.has_value()},
        std::tuple{"criterion", "criterion", criterion.has_value()},
        std::tuple{"kind", "kind", kind.has_value()},
        std::tuple{"dimension", "dim", has_dimension}}) {
    if (option == name_of && is_there) return Concat(name, ":", header_line, ": ", word);
  }
  return "";
}

absl::StatusOr<EditScript> ParseEditScript(TextReader reader, const ScriptParseOptions& options) {
  return ScriptParser(std::move(reader), options).Parse();
}

absl::StatusOr<EditScript> ReadEditScript(const std::string& path,
                                          const ScriptParseOptions& options) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseEditScript(*std::move(reader), options);
}

absl::StatusOr<Box> ParseBox(std::string_view text, int dimension) {
  const auto axes = static_cast<std::size_t>(dimension);
  const bool plane = dimension == 2;
  const std::vector<std::string_view> parts = Split(text, ',');
  Box box;
  bool good = parts.size() == 2 * axes;
  for (std::size_t i = 0; good && i < axes; ++i) {
    good = ParseDouble(parts[i], &box.lo[i]) && ParseDouble(parts[axes + i], &box.hi[i]);
  }
  if (!good) {
    return absl::InvalidArgumentError(Concat("a box is ",
                                             plane ? "x0,y0,x1,y1" : "x0,y0,z0,x1,y1,z1",
                                             " (no blanks), found ", Quoted(text)));
  }
  for (std::size_t i = 0; i < axes; ++i) {
    if (box.lo[i] <= box.hi[i]) continue;
    return absl::InvalidArgumentError(
        Concat("a box needs ", plane ? "x0 <= x1 and y0 <= y1" : "x0 <= x1, y0 <= y1 and z0 <= z1",
               ", found ", Quoted(text)));
  }
  return box;
}

absl::StatusOr<Criterion> ParseCriterion(std::string_view text) {
  if (text == "edge") return Criterion::kEdge;
  if (text == "thesis") return Criterion::kThesis;
  return absl::InvalidArgumentError(Concat("a criterion is edge or thesis, found ", Quoted(text)));
}

}  // namespace dynmesh::io
