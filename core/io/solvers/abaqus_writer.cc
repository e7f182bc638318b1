#include "core/io/solvers/abaqus_writer.h"

#include <array>
#include <charconv>
#include <cstddef>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/common/file_writer.h"
#include "core/io/solvers/named_facets.h"

namespace dynmesh::io {
namespace {

constexpr std::size_t kMostName = 72;
// By order and dimension.
constexpr const char* kTypeOf[2][4] = {{"", "", "CPS3", "C3D4"}, {"", "", "CPS6", "C3D10"}};
// The format's order of midpoints, by dimension.
const std::vector<std::pair<std::size_t, std::size_t>> kMidpointsOf[] = {
    {}, {}, {{0, 1}, {1, 2}, {2, 0}}, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
// The format's number of the side opposite to a corner, by dimension.
constexpr int kSideOf[4][4] = {{}, {}, {2, 3, 1, 0}, {3, 4, 2, 1}};

// Numbers of a set, as many on a line as the format takes.
template <class Numbers>
void WriteNumbers(const Numbers& numbers, FileWriter& out) {
  constexpr std::size_t kOnALine = 16;
  std::size_t i = 0;
  for (const auto number : numbers) {
    out << (i == 0 ? "" : i % kOnALine == 0 ? ",\n" : ", ") << std::uint64_t{number} + 1;
    ++i;
  }
  out << '\n';
}

// As many of the number's digits as fit into the field that programs read.
std::string_view Fitting(double value, std::array<char, 32>& text) {
  constexpr std::ptrdiff_t kWidth = 20;
  char* const begin = text.data();
  char* const most = begin + text.size();
  char* end = std::to_chars(begin, most, value).ptr;
  for (int digits = 16; end - begin > kWidth; --digits) {
    end = std::to_chars(begin, most, value, std::chars_format::general, digits).ptr;
  }
  return {begin, static_cast<std::size_t>(end - begin)};
}

// The vertices of facets, with midpoints if there are any.
std::set<std::uint32_t> VerticesOn(const IndexedMesh& mesh, const FacetSet& set) {
  std::set<std::uint32_t> vertices;
  const auto count = static_cast<std::size_t>(mesh.dimension);
  for (const NamedFacet& facet : set.facets) {
    const auto corners = CornersOf(mesh, facet);
    for (std::size_t a = 0; a < count; ++a) {
      vertices.insert(corners[a]);
      for (std::size_t b = 0; b < a && mesh.order() == 2; ++b) {
        vertices.insert(mesh.MidpointOf(corners[a], corners[b]));
      }
    }
  }
  return vertices;
}

class AbaqusFile {
 public:
  AbaqusFile(const IndexedMesh& mesh, const NamedParts& parts, FileWriter& out)
      : mesh_(mesh), parts_(parts), out_(out) {
    std::vector<std::string> names;
    for (const RegionSet& set : parts.regions) names.push_back(set.name);
    for (const FacetSet& set : parts.facets) names.push_back(set.name);
    words_ = WordsOf(names, kMostName);
    out << "*HEADING\nby dynmesh\n";
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (words_[i] != names[i]) out << "** " << words_[i] << ": " << names[i] << '\n';
    }
  }

  void Write() {
    out_ << "*NODE\n";
    std::array<char, 32> digits;
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
      const IndexedMesh::Vertex& v = mesh_.vertices[i];
      out_ << i + 1;
      for (const double c : v.position()) out_ << ", " << Fitting(c, digits);
      out_ << '\n';
    }
    for (std::size_t k = 0; k < parts_.regions.size(); ++k) {
      out_ << "*ELEMENT, TYPE=" << kTypeOf[mesh_.order() - 1][mesh_.dimension]
           << ", ELSET=" << words_[k] << '\n';
      for (const std::uint32_t i : parts_.regions[k].simplices) WriteElement(i);
    }
    for (std::size_t k = 0; k < parts_.facets.size(); ++k) {
      const FacetSet& set = parts_.facets[k];
      const std::string& word = words_[parts_.regions.size() + k];
      out_ << "*NSET, NSET=" << word << '\n';
      WriteNumbers(VerticesOn(mesh_, set), out_);
      out_ << "*SURFACE, NAME=S_" << word << ", TYPE=ELEMENT\n";
      for (const NamedFacet& facet : set.facets) {
        out_ << std::uint64_t{facet.simplex} + 1 << ", S"
             << kSideOf[mesh_.dimension][facet.opposite] << '\n';
      }
    }
  }

 private:
  void WriteElement(std::uint32_t i) {
    out_ << std::uint64_t{i} + 1;
    const auto write = [&](const auto& corners) {
      for (const std::uint32_t corner : corners) out_ << ", " << std::uint64_t{corner} + 1;
      if (mesh_.order() == 2) {
        for (const auto& [a, b] : kMidpointsOf[mesh_.dimension]) {
          out_ << ", " << std::uint64_t{mesh_.MidpointOf(corners[a], corners[b])} + 1;
        }
      }
    };
    if (mesh_.dimension == 2) {
      write(mesh_.triangles[i]);
    } else {
      write(mesh_.tetrahedra[i]);
    }
    out_ << '\n';
  }

  const IndexedMesh& mesh_;
  const NamedParts& parts_;
  std::vector<std::string> words_;  // of regions, then of sets of facets
  FileWriter& out_;
};

}  // namespace

absl::Status WriteAbaqus(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<NamedParts> parts = NamePartsOf(mesh);
  if (!parts.ok()) return parts.status();
  FileWriter out(path);
  AbaqusFile(mesh, *parts, out).Write();
  return out.Close();
}

}  // namespace dynmesh::io
