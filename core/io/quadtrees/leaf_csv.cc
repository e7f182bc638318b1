// Leaves as comma-separated values.
#include <cmath>
#include <string_view>

#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/common/text_reader.h"
#include "core/io/quadtrees/leaf_list.h"

namespace dynmesh::io {
namespace {

constexpr std::string_view kHeader2D = "x,y,side,level", kHeader3D = "x,y,z,side,level";
constexpr int kMostLevel = 1074;  // more than the exponents of doubles allow

// Without blanks and line ends around it.
std::string_view Trimmed(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = line.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlank) - first + 1);
}

}  // namespace

absl::Status WriteLeafCsv(const LeafList& list, const std::string& path) {
  FileWriter out(path);
  out << (list.dimension == 2 ? kHeader2D : kHeader3D) << '\n';
  for (const LeafList::Leaf& leaf : list.leaves) {
    for (int k = 0; k < list.dimension; ++k) {
      out << leaf.centre[static_cast<std::size_t>(k)] << ',';
    }
    out << leaf.cell.side << ',' << leaf.cell.level << '\n';
  }
  return out.Close();
}

absl::StatusOr<LeafList> ReadLeafCsv(const std::string& path) {
  const absl::StatusOr<std::string> text = ReadWholeFile(path);
  if (!text.ok()) return text.status();
  LeafList list;
  std::size_t width = 0;
  int number = 0;
  for (const std::string_view row : text::Split(*text, '\n')) {
    ++number;
    const auto error = [&](std::string_view what) {
      return TextReader::ErrorAt(path, number, what);
    };
    const std::string_view line = Trimmed(row);
    if (width == 0) {
      if (line == kHeader2D) {
        width = 2;
      } else if (line == kHeader3D) {
        width = 3;
      } else {
        return error(text::Concat("expected the first line ", kHeader2D, " or ", kHeader3D,
                                  " of a quadtree's leaves"));
      }
      list.dimension = static_cast<int>(width);
      continue;
    }
    if (line.empty()) continue;
    const std::vector<std::string_view> parts = text::Split(line, ',');
    if (parts.size() != width + 2) {
      return error(text::Concat("expected ", width + 2, " values, found ", parts.size()));
    }
    LeafList::Leaf leaf;
    for (std::size_t k = 0; k < width; ++k) {
      if (!ParseDouble(parts[k], &leaf.centre[k])) {
        return error(text::Concat("no finite coordinate: ", text::Quoted(parts[k])));
      }
    }
    if (!ParseDouble(parts[width], &leaf.cell.side) || !(leaf.cell.side > 0)) {
      return error(text::Concat("no side above 0: ", text::Quoted(parts[width])));
    }
    std::uint64_t level = 0;
    if (!ParseUint64(parts[width + 1], &level) || level > kMostLevel) {
      return error(text::Concat("no level: ", text::Quoted(parts[width + 1])));
    }
    leaf.cell.level = static_cast<int>(level);
    list.leaves.push_back(leaf);
  }
  if (width == 0) return TextReader::ErrorAt(path, 1, "the file is empty");
  return list;
}

}  // namespace dynmesh::io
