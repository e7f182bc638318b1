// Gmsh's `.msh`, ASCII and binary, versions 2.2 and 4.1.
#include <algorithm>
#include <map>
#include <vector>

#include "core/io/elements/element_builder.h"
#include "core/io/elements/msh_stream.h"

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
  explicit MshReader(TextReader reader) : numbers_(std::move(reader)), builder_(in_.name()) {}

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
    if (*binary > 1) return in_.Error("the file's type is 0 (ASCII) or 1 (binary)");
    const auto size = in_.Uint64("the size of numbers");
    if (!size.ok()) return size.status();
    if (*binary == 0) return absl::OkStatus();
    if (*size != 8) {
      return in_.Error(Concat("a binary file with numbers of ", *size, " bytes cannot be read"));
    }
    return numbers_.BeginBinary();
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
      const auto read = numbers_.Count(MshNumber::kSize, "the number of entities");
      if (!read.ok()) return read.status();
      count = *read;
    }
    for (std::size_t d = 0; d < 4; ++d) {
      for (std::uint64_t i = 0; i < counts[d]; ++i) {
        const auto tag = numbers_.Int("an entity's number");
        if (!tag.ok()) return tag.status();
        if (auto s = numbers_.Skip(MshNumber::kReal, d == 0 ? 3 : 6, "an entity's bounds"); !s.ok())
          return s;
        const auto groups = numbers_.Count(MshNumber::kSize, "the number of an entity's groups");
        if (!groups.ok()) return groups.status();
        for (std::uint64_t g = 0; g < *groups; ++g) {
          const auto group = numbers_.Int("an entity's group");
          if (!group.ok()) return group.status();
          if (g == 0) group_of_[{static_cast<int>(d), *tag}] = *group < 0 ? -*group : *group;
        }
        if (d == 0) continue;
        const auto border =
            numbers_.Count(MshNumber::kSize, "the number of an entity's bounding entities");
        if (!border.ok()) return border.status();
        if (auto s = numbers_.Skip(MshNumber::kInt, *border, "an entity's bounding entities");
            !s.ok())
          return s;
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadPosition(std::uint64_t number) {
    std::array<double, 3> position;
    for (double& c : position) {
      const auto value = numbers_.Real("a coordinate");
      if (!value.ok()) return value.status();
      c = *value;
    }
    return builder_.AddVertex(number, position, in_.line());
  }

  absl::Status ReadNodes2() {
    const auto count = in_.Count("the number of vertices");
    if (!count.ok()) return count.status();
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto number = numbers_.Unsigned(MshNumber::kInt, "a vertex's number");
      if (!number.ok()) return number.status();
      if (auto s = ReadPosition(*number); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status ReadNodes4() {
    const auto blocks = numbers_.Count(MshNumber::kSize, "the number of blocks");
    if (!blocks.ok()) return blocks.status();
    if (auto s = numbers_.Skip(MshNumber::kSize, 3, "the numbers of vertices"); !s.ok()) return s;
    for (std::uint64_t b = 0; b < *blocks; ++b) {
      const auto dimension = numbers_.Unsigned(MshNumber::kInt, "an entity's dimension");
      if (!dimension.ok()) return dimension.status();
      if (auto s = numbers_.Skip(MshNumber::kInt, 1, "an entity's number"); !s.ok()) return s;
      const auto parametric = numbers_.Unsigned(MshNumber::kInt, "0 or 1 for parameters");
      if (!parametric.ok()) return parametric.status();
      const auto count = numbers_.Count(MshNumber::kSize, "the number of vertices of a block");
      if (!count.ok()) return count.status();
      std::vector<std::uint64_t> numbers;
      for (std::uint64_t i = 0; i < *count; ++i) {
        const auto number = numbers_.Unsigned(MshNumber::kSize, "a vertex's number");
        if (!number.ok()) return number.status();
        numbers.push_back(*number);
      }
      for (const std::uint64_t number : numbers) {
        if (auto s = ReadPosition(number); !s.ok()) return s;
        if (*parametric == 0) continue;
        if (auto s = numbers_.Skip(MshNumber::kReal, std::min<std::uint64_t>(*dimension, 3),
                                   "parameters");
            !s.ok()) {
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
      const auto vertex =
          numbers_.Unsigned(is_4_ ? MshNumber::kSize : MshNumber::kInt, "a vertex of an element");
      if (!vertex.ok()) return vertex.status();
      if (k < type.corners) corners[k] = *vertex;
    }
    return builder_.AddElement(std::span(corners).first(type.corners), marker, in_.line());
  }

  // In text the type and the number of tags stand in each element. In bytes they are the header of
  // several.
  absl::Status ReadElements2() {
    const auto count = in_.Count("the number of elements");
    if (!count.ok()) return count.status();
    std::uint64_t following = 0, tag_count = 0;  // of this header
    ElementType type = kElementTypes[0];
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto skip_number = [&] {
        return numbers_.Skip(MshNumber::kInt, 1, "an element's number");
      };
      if (!numbers_.is_binary()) {
        if (auto s = skip_number(); !s.ok()) return s;
      }
      if (following == 0) {
        if (auto s = ReadHeader2(type, following, tag_count); !s.ok()) return s;
      }
      --following;
      if (numbers_.is_binary()) {
        if (auto s = skip_number(); !s.ok()) return s;
      }
      std::int64_t marker = 0;
      for (std::uint64_t t = 0; t < tag_count; ++t) {
        const auto tag = numbers_.Int("an element's tag");
        if (!tag.ok()) return tag.status();
        if (t == 0) marker = *tag < 0 ? -*tag : *tag;
      }
      if (auto s = ReadElement(type, marker); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status ReadHeader2(ElementType& type, std::uint64_t& following, std::uint64_t& tag_count) {
    const auto number = numbers_.Int("an element's type");
    if (!number.ok()) return number.status();
    const auto known = TypeOf(*number);
    if (!known.ok()) return known.status();
    type = *known, following = 1;
    if (numbers_.is_binary()) {
      const auto elements = numbers_.Count(MshNumber::kInt, "the number of elements of a type");
      if (!elements.ok()) return elements.status();
      following = *elements;
      if (following == 0) return in_.Error("a header of no elements");
    }
    const auto tags = numbers_.Count(MshNumber::kInt, "the number of an element's tags");
    if (!tags.ok()) return tags.status();
    tag_count = *tags;
    return absl::OkStatus();
  }

  absl::Status ReadElements4() {
    const auto blocks = numbers_.Count(MshNumber::kSize, "the number of blocks");
    if (!blocks.ok()) return blocks.status();
    if (auto s = numbers_.Skip(MshNumber::kSize, 3, "the numbers of elements"); !s.ok()) return s;
    for (std::uint64_t b = 0; b < *blocks; ++b) {
      const auto dimension = numbers_.Unsigned(MshNumber::kInt, "an entity's dimension");
      if (!dimension.ok()) return dimension.status();
      const auto tag = numbers_.Int("an entity's number");
      if (!tag.ok()) return tag.status();
      const auto number = numbers_.Int("the elements' type");
      if (!number.ok()) return number.status();
      const auto type = TypeOf(*number);
      if (!type.ok()) return type.status();
      const auto count = numbers_.Count(MshNumber::kSize, "the number of elements of a block");
      if (!count.ok()) return count.status();
      const auto group =
          group_of_.find({static_cast<int>(std::min<std::uint64_t>(*dimension, 4)), *tag});
      for (std::uint64_t i = 0; i < *count; ++i) {
        if (auto s = numbers_.Skip(MshNumber::kSize, 1, "an element's number"); !s.ok()) return s;
        if (auto s = ReadElement(*type, group == group_of_.end() ? 0 : group->second); !s.ok()) {
          return s;
        }
      }
    }
    return absl::OkStatus();
  }

  MshStream numbers_;
  TokenStream& in_ = numbers_.text();
  ElementBuilder builder_;
  bool is_4_ = false;
  std::map<std::pair<int, std::int64_t>, std::int64_t> group_of_;  // of entities
};

}  // namespace

absl::StatusOr<ElementMesh> ParseMsh(TextReader reader) {
  return MshReader(std::move(reader)).Read();
}

}  // namespace dynmesh::io
