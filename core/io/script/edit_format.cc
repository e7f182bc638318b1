// Formats edits as lines of a script; see edit_script.h.
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/feature_kinds.h"
#include "core/base/size_shapes.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::io {

using text::Concat;

namespace {

// Rings with a lone / between them.
std::string FormatRings(const Rings& rings) {
  std::string text;
  for (const std::vector<FeatureId>& ring : rings) {
    if (!text.empty()) text += " /";
    for (const FeatureId point : ring) text += Concat(text.empty() ? "" : " ", point);
  }
  return text;
}

std::string Mark(bool unsplit) { return unsplit ? Concat(" ", kUnsplitWord) : ""; }

// Its coordinates with `separator` between them.
std::string FormatPosition(const std::array<double, 3>& position, int dimension,
                           std::string_view separator = " ") {
  std::string text = Concat(FormatDouble(position[0]), separator, FormatDouble(position[1]));
  if (dimension == 3) text += Concat(separator, FormatDouble(position[2]));
  return text;
}

// "disc X Y RADIUS H": the shape's name, what it uses in the order of the table, the target.
std::string FormatSize(const Feature& f, int dimension) {
  const Sizing& s = f.sizing;
  const SizeShapeUse* const use = FindUse(s.shape);
  if (use == nullptr) return "?";
  std::string text(use->name);
  if (use->position) text += Concat(" ", FormatPosition(f.position, dimension));
  if (use->hi) text += Concat(" ", FormatPosition(s.hi, dimension));
  if (use->rings) text += Concat(" ", FormatRings(f.rings));
  if (use->path) {
    for (const auto& vertex : s.path) text += Concat(" ", FormatPosition(vertex, dimension));
  }
  if (use->radius) text += Concat(" ", FormatDouble(s.radius));
  return Concat(text, " ", FormatDouble(s.target));
}

}  // namespace

std::string FormatMeshLine(const MeshOptions& options) {
  const Box& box = options.box;
  const std::string begin = Concat("mesh dim=", options.dimension,
                                   " box=", FormatPosition(box.lo, options.dimension, ","), ",",
                                   FormatPosition(box.hi, options.dimension, ","));
  if (options.kind != MeshKind::kDelaunay) return Concat(begin, " kind=", NameOf(options.kind));
  return Concat(
      begin, " rho=", FormatDouble(options.quality),
      " criterion=", options.criterion == Criterion::kThesis ? "thesis" : "edge",
      options.max_edge > 0 ? Concat(" hmax=", FormatDouble(options.max_edge)) : "",
      options.dimension == 3 ? Concat(" min_dihedral=", FormatDouble(options.min_dihedral)) : "");
}

std::string FormatEdit(const Edit& edit, int dimension) {
  const Feature& f = edit.feature;
  if (edit.action == Edit::Action::kRemove) return Concat("remove ", f.id);
  if (edit.action == Edit::Action::kSetLabel) {
    if (!f.label) return Concat("marker ", f.id, " 0");
    std::string lines = FormatLabel(f.id, *f.label);
    return lines.substr(0, lines.size() - 1);
  }
  const auto point = [&] {
    return Concat("point ", f.id, " ", FormatPosition(f.position, dimension));
  };
  if (edit.action == Edit::Action::kMove) return Concat("move ", point());
  const std::string_view verb = edit.action == Edit::Action::kAdd ? "add" : "set";
  return Visit(
      f, [&](const APoint&) { return Concat(verb, " ", point()); },
      [&](const ASegment& s) {
        return Concat(verb, " segment ", s.id, " ", s.ends[0], " ", s.ends[1], Mark(s.unsplit));
      },
      [&](const APolygon& p) {
        return Concat(verb, " polygon ", p.id, " ", FormatRings(p.rings), Mark(p.unsplit));
      },
      [&](const ASize& s) { return Concat(verb, " size ", s.id, " ", FormatSize(f, dimension)); });
}

}  // namespace dynmesh::io
