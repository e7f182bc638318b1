// Views of Gmsh, background meshes and `.mtr` as sizing features.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/sizes/size_fields.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;

// Values between brackets and names, with lines.
class PosScanner {
 public:
  PosScanner(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  absl::Status Error(std::string_view message) const {
    return TextReader::ErrorAt(name_, line_, message);
  }
  // At the end of the text, where Peek() is '\0'. A '\0' of the text itself is not the end.
  bool IsAtEnd() {
    Peek();
    return at_ >= text_.size();
  }
  char Peek() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (text_.substr(at_, 2) == "//") {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      } else if (c == '\n') {
        ++line_, ++at_;
      } else if (IsBlank(c)) {
        ++at_;
      } else {
        return c;
      }
    }
    return '\0';
  }
  bool Take(char c) {
    if (Peek() != c) return false;
    ++at_;
    return true;
  }
  std::string_view Word() {
    Peek();
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           ((text_[at_] >= 'A' && text_[at_] <= 'Z') || (text_[at_] >= 'a' && text_[at_] <= 'z') ||
            (text_[at_] >= '0' && text_[at_] <= '9') || text_[at_] == '_')) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }
  // "\"...\"" or "{...}" without what is in it.
  bool SkipQuoted() {
    if (!Take('"')) return false;
    while (at_ < text_.size() && text_[at_] != '"') line_ += text_[at_++] == '\n' ? 1 : 0;
    return Take('"');
  }
  // Numbers with commas between `open` and `close`.
  absl::Status Numbers(char open, char close, std::vector<double>& numbers) {
    if (!Take(open)) return Error(Concat("expected ", std::string(1, open)));
    while (!Take(close)) {
      Peek();
      const std::size_t begin = at_;
      while (at_ < text_.size() && text_[at_] != ',' && text_[at_] != close &&
             !IsBlank(text_[at_])) {
        ++at_;
      }
      double value = 0;
      if (!ParseDouble(text_.substr(begin, at_ - begin), &value)) {
        return Error(Concat("not a finite number: ", Quoted(text_.substr(begin, at_ - begin))));
      }
      numbers.push_back(value);
      Take(',');
    }
    return absl::OkStatus();
  }

 private:
  static bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  const std::string& name_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

// Cuts elements to pieces that a disc can stand for.
class ViewSizes {
 public:
  ViewSizes(const SizeView& view, const Box& within, FeatureId first, int dimension)
      : view_(view), within_(within), next_(first), d_(static_cast<std::size_t>(dimension)) {}

  absl::StatusOr<std::vector<Feature>> Run() {
    for (const SizeElement& element : view_.elements) Add(element);
    if (features_.size() <= kMostSizes) return std::move(features_);
    return absl::InvalidArgumentError(
        Concat(view_.file, ": more than ", kMostSizes, " sizing features; give larger lengths"));
  }

 private:
  double Distance(const std::array<double, 3>& a, const std::array<double, 3>& b) const {
    return std::hypot(a[0] - b[0], a[1] - b[1], d_ == 3 ? a[2] - b[2] : 0);
  }

  void Add(const SizeElement& e) {
    if (features_.size() > kMostSizes) return;
    // Parts of it outside are never cut.
    for (std::size_t k = 0; k < d_; ++k) {
      const auto in_k = [k](const auto& corner) { return corner[k]; };
      if (std::ranges::max(e.corners, {}, in_k)[k] < within_.lo[k] ||
          std::ranges::min(e.corners, {}, in_k)[k] > within_.hi[k]) {
        return;
      }
    }
    double least = HUGE_VAL;
    for (const double value : e.values) {
      if (!(value > 0)) return;
      least = std::min(least, value);
    }
    std::size_t a = 0, b = 0;
    double longest = 0;
    for (std::size_t i = 0; i < e.corners.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double length = Distance(e.corners[i], e.corners[j]);
        if (length > longest) longest = length, a = i, b = j;
      }
    }
    if (longest > 2 * least) {
      SizeElement one = e, other = e;
      std::array<double, 3> middle;
      for (std::size_t k = 0; k < 3; ++k) middle[k] = e.corners[a][k] / 2 + e.corners[b][k] / 2;
      if (middle != e.corners[a] && middle != e.corners[b]) {
        one.corners[a] = other.corners[b] = middle;
        one.values[a] = other.values[b] = (e.values[a] + e.values[b]) / 2;
        Add(one);
        Add(other);
        return;
      }
    }
    std::array<double, 3> centre = {0, 0, 0};
    for (const auto& corner : e.corners) {
      for (std::size_t k = 0; k < d_; ++k) {
        centre[k] += corner[k] / static_cast<double>(e.corners.size());
      }
    }
    double radius = 0;
    for (const auto& corner : e.corners) radius = std::max(radius, Distance(corner, centre));
    std::array<double, 3> nearest = centre;  // of the box
    for (std::size_t k = 0; k < d_; ++k) {
      nearest[k] = std::clamp(centre[k], within_.lo[k], within_.hi[k]);
    }
    if (nearest != centre) {
      // A disc's centre must be in the box. For q in a box and its point p nearest to c,
      // |qc|^2 >= |qp|^2 + |pc|^2: the part of the disc in the box is in this one.
      const double away = Distance(nearest, centre);
      if (!(away < radius)) return;
      radius = std::sqrt((radius - away) * (radius + away));
      centre = nearest;
    }
    const SizeShape shape = radius > 0 ? SizeShape::kDisc : SizeShape::kPoint;
    features_.push_back(Feature::Size(next_++, centre, {shape, least, radius, {}}));
  }

  const SizeView& view_;
  const Box within_;
  FeatureId next_;
  const std::size_t d_;
  std::vector<Feature> features_;
};

std::string WithExtension(const std::string& path, const char* extension) {
  return path.substr(0, path.size() - ExtensionOf(path).size()) + extension;
}

template <int D>
absl::StatusOr<SizeView> BackgroundOf(const std::string& path, const NodeSection& nodes,
                                      const std::vector<double>& sizes, TextReader elements) {
  const absl::StatusOr<SimplexSection<D>> rows = ReadSimplexSection<D>(elements, nodes);
  if (!rows.ok()) return rows.status();
  SizeView view;
  view.file = path;
  for (const auto& corners : rows->corners) {
    SizeElement& element = view.elements.emplace_back();
    for (const std::uint32_t v : corners) {
      element.corners.push_back(nodes.positions[v]);
      element.values.push_back(sizes[v]);
    }
  }
  return view;
}

absl::Status CheckCount(const std::string& path, std::size_t sizes, std::size_t points) {
  if (sizes == points) return absl::OkStatus();
  return absl::InvalidArgumentError(
      Concat(path, ":1: ", sizes, " lengths for ", points, " points"));
}

}  // namespace

absl::StatusOr<SizeView> ParsePos(const std::string& name, const std::string& text) {
  PosScanner in(name, text);
  SizeView view;
  view.file = name;
  while (!in.IsAtEnd()) {
    if (in.Word() != "View" || !in.SkipQuoted() || !in.Take('{')) {
      return in.Error("expected View \"NAME\" {");
    }
    while (!in.Take('}')) {
      if (in.IsAtEnd()) return in.Error("the file ends before }");
      const std::string_view kind = in.Word();
      const std::size_t corners = kind == "SP"   ? 1
                                  : kind == "SL" ? 2
                                  : kind == "ST" ? 3
                                  : kind == "SS" ? 4
                                                 : 0;
      if (corners == 0) {
        return in.Error(Concat("elements ", Quoted(kind),
                               " cannot be read: only SP, SL, ST and SS, scalars of simplices"));
      }
      std::vector<double> positions;
      SizeElement element;
      if (auto s = in.Numbers('(', ')', positions); !s.ok()) return s;
      if (auto s = in.Numbers('{', '}', element.values); !s.ok()) return s;
      if (positions.size() != 3 * corners || element.values.size() < corners) {
        return in.Error(
            Concat(kind, " takes ", 3 * corners, " coordinates and ", corners, " values"));
      }
      element.values.resize(corners);
      for (std::size_t i = 0; i < corners; ++i) {
        element.corners.push_back({positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]});
      }
      view.elements.push_back(std::move(element));
      if (!in.Take(';')) return in.Error("expected ; after an element");
    }
    in.Take(';');
  }
  return view;
}

absl::StatusOr<std::vector<Feature>> SizesOf(const SizeView& view, const Box& within,
                                             FeatureId first, int dimension) {
  return ViewSizes(view, within, first, dimension).Run();
}

absl::StatusOr<std::vector<double>> ParseMtr(TextReader reader) {
  if (!reader.Next()) return reader.Error("the file has no header");
  const absl::StatusOr<std::uint64_t> count = reader.Uint64(0, "the number of lengths");
  if (!count.ok()) return count.status();
  if (reader.size() > 1 && reader.token(1) != "1") {
    return reader.Error("only a length for each point can be read, no metric of several values");
  }
  std::vector<double> sizes;
  for (std::uint64_t i = 0; i < *count; ++i) {
    if (!reader.Next()) return reader.Error(Concat("the file ends after ", i, " lengths"));
    const absl::StatusOr<double> size = reader.Double(0, "a length");
    if (!size.ok()) return size.status();
    sizes.push_back(*size);
  }
  if (auto s = ExpectEnd(reader); !s.ok()) return s;
  return sizes;
}

absl::StatusOr<std::vector<Feature>> ReadMtrFile(const std::string& path, const SizedInput& input) {
  const MeshOptions& options = input.options;
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  const absl::StatusOr<std::vector<double>> sizes = ParseMtr(*std::move(reader));
  if (!sizes.ok()) return sizes.status();
  absl::StatusOr<TextReader> elements = TextReader::Open(WithExtension(path, ".ele"));
  if (elements.ok()) {
    absl::StatusOr<TextReader> nodes = TextReader::Open(WithExtension(path, ".node"));
    if (!nodes.ok()) return nodes.status();
    const absl::StatusOr<NodeSection> section = ReadNodeSection(*nodes, options.dimension);
    if (!section.ok()) return section.status();
    if (auto s = CheckCount(path, sizes->size(), section->positions.size()); !s.ok()) return s;
    const absl::StatusOr<SizeView> view =
        options.dimension == 2 ? BackgroundOf<2>(path, *section, *sizes, *std::move(elements))
                               : BackgroundOf<3>(path, *section, *sizes, *std::move(elements));
    if (!view.ok()) return view.status();
    return SizesOf(*view, options.box, input.first, options.dimension);
  }
  SizeView view;
  view.file = path;
  for (const Feature& f : input.features) {
    if (!IsPoint(f)) continue;
    const std::size_t i = view.elements.size();
    view.elements.push_back({{f.position}, {i < sizes->size() ? (*sizes)[i] : 0}});
  }
  if (auto s = CheckCount(path, sizes->size(), view.elements.size()); !s.ok()) return s;
  return SizesOf(view, options.box, input.first, options.dimension);
}

absl::StatusOr<std::vector<Feature>> ReadPosFile(const std::string& path, const SizedInput& input) {
  const absl::StatusOr<std::string> text = ReadWholeFile(path);
  if (!text.ok()) return text.status();
  const absl::StatusOr<SizeView> view = ParsePos(path, *text);
  if (!view.ok()) return view.status();
  return SizesOf(*view, input.options.box, input.first, input.options.dimension);
}

}  // namespace dynmesh::io
