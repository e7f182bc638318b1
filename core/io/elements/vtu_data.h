// The values of arrays in a VTK XML file: ASCII or base64, inline or appended, with zlib or
// without.
#ifndef DYNMESH_CORE_IO_ELEMENTS_VTU_DATA_H_
#define DYNMESH_CORE_IO_ELEMENTS_VTU_DATA_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace dynmesh::io {

// A tag of XML. Views point into the text.
struct XmlTag {
  std::string_view name;  // "/Piece" closes
  std::map<std::string_view, std::string_view> attributes;
  std::string_view text;  // from behind the tag to the next one
  int line = 0;

  std::string_view Get(std::string_view attribute) const {
    const auto it = attributes.find(attribute);
    return it == attributes.end() ? std::string_view() : it->second;
  }
};

// All tags of a text in order; comments and declarations are left out. Errors are those of a file
// `name`.
absl::StatusOr<std::vector<XmlTag>> ParseXmlTags(const std::string& name, std::string_view text);

// How a file packs its arrays.
struct VtuPacking {
  bool is_compressed = false;   // by zlib
  std::size_t count_bytes = 4;  // of counts: 4 or 8
  std::string_view appended;    // the base64 text behind AppendedData's underscore
};

// The values of a DataArray, one way or the other: whole numbers or reals.
struct VtuValues {
  std::vector<double> reals;
  std::vector<std::int64_t> wholes;
};
// INVALID_ARGUMENT as `name:line: ...`. `most`: the most values that the caller can use.
absl::StatusOr<VtuValues> ReadVtuValues(const std::string& name, const XmlTag& array,
                                        const VtuPacking& packing, std::uint64_t most);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_ELEMENTS_VTU_DATA_H_
