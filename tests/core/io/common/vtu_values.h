// The values of arrays of a VTK XML file, by code written from the format only.
#ifndef DYNMESH_TESTS_CORE_IO_COMMON_VTU_VALUES_H_
#define DYNMESH_TESTS_CORE_IO_COMMON_VTU_VALUES_H_

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "gtest/gtest.h"

namespace dynmesh::testing {

// The bytes of the text between the tags of a DataArray: the number of blocks, their size, that of
// the last one, and the compressed size of each, in one base64; then the blocks in another.
inline std::string VtuBytes(std::string base64) {
  std::erase_if(base64, [](char c) { return c == ' ' || c == '\n'; });
  const auto count_at = [](const std::string& raw, std::size_t i) {
    std::uint64_t count = 0;
    std::memcpy(&count, raw.data() + 8 * i, 8);
    return count;
  };
  std::string raw;
  // Three counts are 24 bytes, that is 32 letters.
  EXPECT_TRUE(absl::Base64Unescape(base64.substr(0, 32), &raw));
  const std::uint64_t blocks = count_at(raw, 0), size = count_at(raw, 1), last = count_at(raw, 2);
  const std::size_t letters = (8 * (3 + blocks) + 2) / 3 * 4;
  std::string header, data, bytes;
  EXPECT_TRUE(absl::Base64Unescape(base64.substr(0, letters), &header));
  EXPECT_TRUE(absl::Base64Unescape(base64.substr(letters), &data));
  std::size_t at = 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    std::string block(b + 1 == blocks && last != 0 ? last : size, '\0');
    uLongf got = block.size();
    const std::uint64_t packed = count_at(header, 3 + b);
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(block.data()), &got,
                         reinterpret_cast<const Bytef*>(data.data()) + at, packed),
              Z_OK);
    EXPECT_EQ(got, block.size());
    at += packed;
    bytes += block;
  }
  EXPECT_EQ(at, data.size());
  return bytes;
}

// The values of the array `name`, the first one of that name.
template <class T>
std::vector<T> VtuValues(const std::string& xml, const std::string& name) {
  const std::size_t at = xml.find("Name=\"" + name + "\"");
  if (at == std::string::npos) {
    ADD_FAILURE() << "no array " << name;
    return {};
  }
  const std::size_t text = xml.find('>', at) + 1;
  const std::string bytes = VtuBytes(xml.substr(text, xml.find('<', text) - text));
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_IO_COMMON_VTU_VALUES_H_
