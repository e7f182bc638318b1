#include "server/base/printable.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/str_format.h"
#include "core/base/text.h"
#include "core/base/utf8.h"

namespace dynmesh::server {

std::string Printable(absl::string_view bytes) {
  std::string printable;
  printable.reserve(bytes.size());
  while (!bytes.empty()) {
    char32_t character = 0;
    const std::size_t size = utf8::ReadCharacter(text::View(bytes), &character);
    const auto first = static_cast<std::uint8_t>(bytes[0]);
    if (size == 0 || first < 0x20 || first == 0x7F) {
      absl::StrAppendFormat(&printable, "\\x%02x", first);
      bytes.remove_prefix(1);
    } else {
      printable.append(bytes.data(), size);
      bytes.remove_prefix(size);
    }
  }
  return printable;
}

}  // namespace dynmesh::server
