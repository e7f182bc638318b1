#include <cmath>

#include "core/io/sizes/size_fields.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

std::string Check(const absl::StatusOr<std::vector<Feature>>& sizes) {
  if (!sizes.ok()) return "";
  FeatureId id = 7;
  for (const Feature& f : *sizes) {
    if (f.id != id++ || f.kind != FeatureKind::kSize) return "no size in order";
    if (!(f.sizing.target > 0) || !std::isfinite(f.sizing.target)) return "no length";
  }
  return "";
}

template <class Field>
std::string Use(const absl::StatusOr<Field>& field, int dimension) {
  if (!field.ok()) return field.status().message().empty() ? "an error without a message" : "";
  return Check(io::SizesOf(*field, {{0, 0, 0}, {1, 1, 1}}, 7, dimension));
}

}  // namespace

std::string FuzzSizes(std::string_view bytes) {
  const std::string text(bytes);
  for (const int dimension : {2, 3}) {
    const Box box = {{0, 0, 0}, {1, 1, 1}};
    if (auto p = Use(io::ParseNpy("fuzz.npy", text, box, dimension), dimension); !p.empty()) {
      return p;
    }
    // A length far below the extent takes minutes to cut; that is what it says.
    const absl::StatusOr<io::SizeView> view = io::ParsePos("fuzz.pos", text);
    bool is_small = view.ok();
    if (view.ok()) {
      for (const io::SizeElement& e : view->elements) {
        for (const double v : e.values) is_small &= !(v > 0) || v > 0.05;
        for (const auto& c : e.corners) {
          for (const double x : c) is_small &= std::abs(x) < 2;
        }
      }
    }
    if (is_small) {
      if (auto p = Use(view, dimension); !p.empty()) return p;
    }
  }
  if (auto p = Use(io::ParseEsriAscii(io::TextReader("fuzz.asc", text)), 2); !p.empty()) return p;
  const auto sizes = io::ParseMtr(io::TextReader("fuzz.mtr", text));
  return sizes.ok() || !sizes.status().message().empty() ? "" : "an error without a message";
}

}  // namespace dynmesh::fuzz
