// Gmsh's `.msh`, ASCII, versions 2.2 and 4.1.
#include <algorithm>
#include <map>
#include <vector>

#include "core/io/elements/element_builder.h"
#include "core/io/elements/token_stream.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;

struct ElementType {
  int type;
  std::size_t corners, nodes;
};
constexpr ElementType kElementTypes[] = {{15, 1, 1},  {1, 2, 2},  {8, 2, 3},   {26, 2, 4},
                                         {2, 3, 3},   {9, 3, 6},  {21, 3, 10}, {4, 4, 4},
                                         {11, 4, 10}, {29, 4, 20}};

class MshReader {
 public:
  explicit MshReader(TextReader reader) : in_(std::move(reader)), builder_(in_.name()) {}

  absl::StatusOr<ElementMesh> Read() {
    bool has_format = false, has_elements = false;
    while (in_.Next()) {
      const std::string section(in_.token());
      absl::Status status;
      if (section == "$MeshFormat") {
        status = ReadFormat();
        has_format = true;
      } else if (!has_format) {
        return in_.Error("a Gmsh file must begin with $MeshFormat");
      } else if (section == "$PhysicalNames") {
        status = ReadNames();
      } else if (section == "$Entities" && is_4_) {
        status = ReadEntities();
      } else if (section == "$Nodes") {
        status = is_4_ ? ReadNodes4() : ReadNodes2();
      } else if (section == "$Elements") {
        status = is_4_ ? ReadElements4() : ReadElements2();
        has_elements = true;
      } else if (section.starts_with("$")) {
        if (auto s = SkipSection(section); !s.ok()) return s;
        continue;
      } else {
        return in_.Error(Concat("expected a section as $Nodes, found ", Quoted(section)));
      }
      if (!status.ok()) return status;
      if (!in_.Next() || in_.token() != "$End" + section.substr(1)) {
        return in_.Error(Concat("expected $End", section.substr(1)));
      }
    }
    if (!has_elements) return in_.Error("the file has no $Elements");
    return builder_.Take();
  }

 private:
  absl::Status SkipSection(const std::string& section) {
    const std::string end = "$End" + section.substr(1);
    const int line = in_.line();
    while (in_.Next()) {
      if (in_.token() == end) return absl::OkStatus();
    }
    return TextReader::ErrorAt(in_.name(), line, Concat("section ", section, " has no ", end));
  }

  absl::Status ReadFormat() {
    const auto version = in_.Double("the version");
    if (!version.ok()) return version.status();
    if (*version != 2.2 && *version != 4.1) {
      return in_.Error(Concat("version ", *version,
                              " of Gmsh's files cannot be read: save it as 4.1 or 2.2, as with "
                              "gmsh -format msh41"));
    }
    is_4_ = *version > 4;
    const auto binary = in_.Uint64("the file's type");
    if (!binary.ok()) return binary.status();
    if (*binary != 0) {
      return in_.Error("a binary file cannot be read: save it as ASCII, as with gmsh -bin 0");
    }
    return in_.Uint64("the size of numbers").status();
  }

  absl::Status ReadNames() {
    const auto count = in_.Count("the number of names");
    if (!count.ok()) return count.status();
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto dimension = in_.Uint64("a group's dimension");
      if (!dimension.ok()) return dimension.status();
      const auto tag = in_.Int64("a group's number");
      if (!tag.ok()) return tag.status();
      std::string name = in_.RestOfLine();
      if (name.size() < 2 || name.front() != '"' || name.back() != '"') {
        return in_.Error(Concat("expected a name in quotes, found ", Quoted(name)));
      }
      if (*dimension > 3) return in_.Error("a group's dimension is 0 to 3");
      name = name.substr(1, name.size() - 2);
      if (!name.empty()) builder_.mesh().names[{static_cast<int>(*dimension), *tag}] = name;
    }
    return absl::OkStatus();
  }

  // The first physical group of each entity; a negative one is turned round.
  absl::Status ReadEntities() {
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& count : counts) {
      const auto read = in_.Count("the number of entities");
      if (!read.ok()) return read.status();
      count = *read;
    }
    for (std::size_t d = 0; d < 4; ++d) {
      for (std::uint64_t i = 0; i < counts[d]; ++i) {
        const auto tag = in_.Int64("an entity's number");
        if (!tag.ok()) return tag.status();
        if (auto s = in_.Skip(d == 0 ? 3 : 6, "an entity's bounds"); !s.ok()) return s;
        const auto groups = in_.Count("the number of an entity's groups");
        if (!groups.ok()) return groups.status();
        for (std::uint64_t g = 0; g < *groups; ++g) {
          const auto group = in_.Int64("an entity's group");
          if (!group.ok()) return group.status();
          if (g == 0) group_of_[{static_cast<int>(d), *tag}] = *group < 0 ? -*group : *group;
        }
        if (d == 0) continue;
        const auto border = in_.Count("the number of an entity's bounding entities");
        if (!border.ok()) return border.status();
        if (auto s = in_.Skip(*border, "an entity's bounding entities"); !s.ok()) return s;
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadPosition(std::uint64_t number) {
    std::array<double, 3> position;
    for (double& c : position) {
      const auto value = in_.Double("a coordinate");
      if (!value.ok()) return value.status();
      c = *value;
    }
    return builder_.AddVertex(number, position, in_.line());
  }

  absl::Status ReadNodes2() {
    const auto count = in_.Count("the number of vertices");
    if (!count.ok()) return count.status();
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto number = in_.Uint64("a vertex's number");
      if (!number.ok()) return number.status();
      if (auto s = ReadPosition(*number); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status ReadNodes4() {
    const auto blocks = in_.Count("the number of blocks");
    if (!blocks.ok()) return blocks.status();
    if (auto s = in_.Skip(3, "the numbers of vertices"); !s.ok()) return s;
    for (std::uint64_t b = 0; b < *blocks; ++b) {
      const auto dimension = in_.Uint64("an entity's dimension");
      if (!dimension.ok()) return dimension.status();
      if (auto s = in_.Skip(1, "an entity's number"); !s.ok()) return s;
      const auto parametric = in_.Uint64("0 or 1 for parameters");
      if (!parametric.ok()) return parametric.status();
      const auto count = in_.Count("the number of vertices of a block");
      if (!count.ok()) return count.status();
      std::vector<std::uint64_t> numbers;
      for (std::uint64_t i = 0; i < *count; ++i) {
        const auto number = in_.Uint64("a vertex's number");
        if (!number.ok()) return number.status();
        numbers.push_back(*number);
      }
      for (const std::uint64_t number : numbers) {
        if (auto s = ReadPosition(number); !s.ok()) return s;
        if (*parametric == 0) continue;
        if (auto s = in_.Skip(std::min<std::uint64_t>(*dimension, 3), "parameters"); !s.ok()) {
          return s;
        }
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<ElementType> TypeOf(std::int64_t type) const {
    for (const ElementType& known : kElementTypes) {
      if (known.type == type) return known;
    }
    return in_.Error(Concat("elements of type ", type,
                            " cannot be read: only points, lines, triangles and tetrahedra"));
  }

  absl::Status ReadElement(const ElementType& type, std::int64_t marker) {
    std::array<std::uint64_t, 4> corners{};
    for (std::size_t k = 0; k < type.nodes; ++k) {
      const auto vertex = in_.Uint64("a vertex of an element");
      if (!vertex.ok()) return vertex.status();
      if (k < type.corners) corners[k] = *vertex;
    }
    return builder_.AddElement(std::span(corners).first(type.corners), marker, in_.line());
  }

  absl::Status ReadElements2() {
    const auto count = in_.Count("the number of elements");
    if (!count.ok()) return count.status();
    for (std::uint64_t i = 0; i < *count; ++i) {
      if (auto s = in_.Skip(1, "an element's number"); !s.ok()) return s;
      const auto number = in_.Int64("an element's type");
      if (!number.ok()) return number.status();
      const auto type = TypeOf(*number);
      if (!type.ok()) return type.status();
      const auto tags = in_.Count("the number of an element's tags");
      if (!tags.ok()) return tags.status();
      std::int64_t marker = 0;
      for (std::uint64_t t = 0; t < *tags; ++t) {
        const auto tag = in_.Int64("an element's tag");
        if (!tag.ok()) return tag.status();
        if (t == 0) marker = *tag < 0 ? -*tag : *tag;
      }
      if (auto s = ReadElement(*type, marker); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status ReadElements4() {
    const auto blocks = in_.Count("the number of blocks");
    if (!blocks.ok()) return blocks.status();
    if (auto s = in_.Skip(3, "the numbers of elements"); !s.ok()) return s;
    for (std::uint64_t b = 0; b < *blocks; ++b) {
      const auto dimension = in_.Uint64("an entity's dimension");
      if (!dimension.ok()) return dimension.status();
      const auto tag = in_.Int64("an entity's number");
      if (!tag.ok()) return tag.status();
      const auto number = in_.Int64("the elements' type");
      if (!number.ok()) return number.status();
      const auto type = TypeOf(*number);
      if (!type.ok()) return type.status();
      const auto count = in_.Count("the number of elements of a block");
      if (!count.ok()) return count.status();
      const auto group =
          group_of_.find({static_cast<int>(std::min<std::uint64_t>(*dimension, 4)), *tag});
      for (std::uint64_t i = 0; i < *count; ++i) {
        if (auto s = in_.Skip(1, "an element's number"); !s.ok()) return s;
        if (auto s = ReadElement(*type, group == group_of_.end() ? 0 : group->second); !s.ok()) {
          return s;
        }
      }
    }
    return absl::OkStatus();
  }

  TokenStream in_;
  ElementBuilder builder_;
  bool is_4_ = false;
  std::map<std::pair<int, std::int64_t>, std::int64_t> group_of_;  // of entities
};

}  // namespace

absl::StatusOr<ElementMesh> ParseMsh(TextReader reader) {
  return MshReader(std::move(reader)).Read();
}

}  // namespace dynmesh::io
