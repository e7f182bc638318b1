// Edits as lines of a script; edit_script.h says what they look like.
#include <string>
#include <string_view>
#include <vector>

#include "core/data/text.h"
#include "core/io/edit_script.h"
#include "core/io/file_writer.h"

namespace dynmesh::io {

using data::Concat;

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

std::string FormatSize(const Feature& f) {
  const Sizing& s = f.sizing;
  const std::string at = Concat(FormatDouble(f.position[0]), " ", FormatDouble(f.position[1]));
  const std::string target = Concat(" ", FormatDouble(s.target));
  switch (s.shape) {
    case SizeShape::kPoint:
      return Concat("point ", at, target);
    case SizeShape::kDisc:
      return Concat("disc ", at, " ", FormatDouble(s.radius), target);
    case SizeShape::kPolygon:
      return Concat("polygon ", FormatRings(f.rings), target);
    default:
      return Concat("box ", at, " ", FormatDouble(s.hi[0]), " ", FormatDouble(s.hi[1]), target);
  }
}

std::string FormatPosition(const Feature& f) {
  return Concat(f.id, " ", FormatDouble(f.position[0]), " ", FormatDouble(f.position[1]));
}

}  // namespace

std::string FormatMeshLine(const MeshOptions& options) {
  const Box& box = options.box;
  return Concat("mesh dim=2 box=", FormatDouble(box.lo[0]), ",", FormatDouble(box.lo[1]), ",",
                FormatDouble(box.hi[0]), ",", FormatDouble(box.hi[1]),
                " rho=", FormatDouble(options.quality),
                " criterion=", options.criterion == Criterion::kThesis ? "thesis" : "edge",
                options.max_edge > 0 ? Concat(" hmax=", FormatDouble(options.max_edge)) : "");
}

std::string FormatEdit(const Edit& edit) {
  const Feature& f = edit.feature;
  if (edit.action == Edit::Action::kRemove) return Concat("remove ", f.id);
  if (edit.action == Edit::Action::kMove) return Concat("move point ", FormatPosition(f));
  const std::string_view verb = edit.action == Edit::Action::kAdd ? "add" : "set";
  if (f.kind == FeatureKind::kPoint) return Concat(verb, " point ", FormatPosition(f));
  if (f.kind == FeatureKind::kSize) return Concat(verb, " size ", f.id, " ", FormatSize(f));
  if (f.kind == FeatureKind::kPolygon) {
    return Concat(verb, " polygon ", f.id, " ", FormatRings(f.rings));
  }
  return Concat(verb, " segment ", f.id, " ", f.ends[0], " ", f.ends[1]);
}

}  // namespace dynmesh::io
