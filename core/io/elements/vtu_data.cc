#include "core/io/elements/vtu_data.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "absl/strings/escaping.h"
#include "core/base/text.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// The attributes `a="b"` of a tag's inside.
bool ParseAttributes(std::string_view inside, XmlTag& tag) {
  std::size_t i = 0;
  const auto skip = [&] {
    while (i < inside.size() && IsBlank(inside[i])) ++i;
  };
  for (skip(); i < inside.size(); skip()) {
    const std::size_t equals = inside.find('=', i);
    if (equals == std::string_view::npos || equals + 1 >= inside.size()) return false;
    std::string_view name = inside.substr(i, equals - i);
    while (!name.empty() && IsBlank(name.back())) name.remove_suffix(1);
    i = equals + 1;
    skip();
    if (i >= inside.size() || (inside[i] != '"' && inside[i] != '\'')) return false;
    const std::size_t end = inside.find(inside[i], i + 1);
    if (end == std::string_view::npos) return false;
    tag.attributes[name] = inside.substr(i + 1, end - i - 1);
    i = end + 1;
  }
  return true;
}

// Deflate codes at most 258 bytes with 2 bits.
constexpr std::uint64_t kMostRatio = 258 * 8 / 2;

// Where the tag that begins at `at` ends: its '>' that is in no quotes.
std::size_t EndOfTag(std::string_view text, std::size_t at) {
  if (text.substr(at, 4) == "<!--") return text.find("-->", at);
  if (text.substr(at, 2) == "<!") return text.find('>', at);
  char quote = '\0';
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at;
    }
  }
  return std::string_view::npos;
}

class Decoder {
 public:
  Decoder(const std::string& name, const XmlTag& array, const VtuPacking& packing,
          std::uint64_t most_bytes)
      : name_(name), array_(array), packing_(packing), most_bytes_(most_bytes) {}

  // The bytes of the values.
  absl::StatusOr<std::string> Read() const {
    std::string base64;
    std::string_view source = array_.text;
    if (array_.Get("format") == "appended") {
      std::uint64_t offset = 0;
      if (!ParseUint64(array_.Get("offset"), &offset) || offset > packing_.appended.size()) {
        return Error("an array's offset lies outside of the appended data");
      }
      source = packing_.appended.substr(static_cast<std::size_t>(offset));
    }
    // No more text than the most values can take, with the counts of blocks. No overflow:
    // most_bytes_ is below 2^40 (27 values of 8 bytes for each of fewer than 2^31 cells).
    const std::uint64_t most = 2 * most_bytes_ + 4096;
    for (const char c : source) {
      if (IsBlank(c)) continue;
      if (base64.size() >= 4 * most) break;
      base64.push_back(c);
    }
    return packing_.is_compressed ? ReadCompressed(base64) : ReadPlain(base64);
  }

 private:
  absl::Status Error(std::string_view message) const {
    return TextReader::ErrorAt(name_, array_.line,
                               Concat("array ", Quoted(array_.Get("Name")), ": ", message));
  }
  absl::Status Broken() const { return Error("no base64 of as many bytes as it announces"); }

  // `bytes` bytes from the start of a base64 text, and the letters that they take.
  absl::StatusOr<std::pair<std::string, std::size_t>> Bytes(std::string_view base64,
                                                            std::uint64_t bytes) const {
    if (bytes > base64.size()) return Broken();
    const auto letters = static_cast<std::size_t>((bytes + 2) / 3 * 4);
    std::string raw;
    if (letters > base64.size() ||
        !absl::Base64Unescape(std::string(base64.substr(0, letters)), &raw) || raw.size() < bytes) {
      return Broken();
    }
    raw.resize(static_cast<std::size_t>(bytes));
    return std::pair(std::move(raw), letters);
  }

  std::uint64_t CountAt(const std::string& raw, std::uint64_t i) const {
    std::uint64_t count = 0;
    std::memcpy(&count, raw.data() + packing_.count_bytes * i, packing_.count_bytes);
    return count;
  }

  absl::StatusOr<std::string> ReadPlain(std::string_view base64) const {
    const auto header = Bytes(base64, packing_.count_bytes);
    if (!header.ok()) return header.status();
    const std::uint64_t size = CountAt(header->first, 0);
    if (size > most_bytes_) return Error("more values than the file has points or cells for");
    auto all = Bytes(base64, packing_.count_bytes + size);
    if (!all.ok()) return all.status();
    return all->first.substr(packing_.count_bytes);
  }

  absl::StatusOr<std::string> ReadCompressed(std::string_view base64) const {
    const auto counts = Bytes(base64, 3 * packing_.count_bytes);
    if (!counts.ok()) return counts.status();
    const std::uint64_t blocks = CountAt(counts->first, 0), size = CountAt(counts->first, 1),
                        last = CountAt(counts->first, 2);
    if (blocks > base64.size() || (blocks > 1 && size > most_bytes_ / (blocks - 1)) ||
        (blocks > 0 && last > most_bytes_)) {
      return Error("more values than the file has points or cells for");
    }
    const auto header = Bytes(base64, (3 + blocks) * packing_.count_bytes);
    if (!header.ok()) return header.status();
    std::uint64_t packed = 0;
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::uint64_t part = CountAt(header->first, 3 + b);
      if (part > base64.size()) return Broken();
      packed += part;
    }
    const auto data = Bytes(base64.substr(header->second), packed);
    if (!data.ok()) return data.status();
    std::string bytes;
    std::size_t at = 0;
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::uint64_t whole = b + 1 == blocks && last != 0 ? last : size;
      if (whole > most_bytes_) return Error("more values than the file has points or cells for");
      const auto part = static_cast<std::size_t>(CountAt(header->first, 3 + b));
      if (whole / kMostRatio > part) return Error("a block of more bytes than zlib can unpack");
      std::string block(static_cast<std::size_t>(whole), '\0');
      uLongf got = block.size();
      if (uncompress(reinterpret_cast<Bytef*>(block.data()), &got,
                     reinterpret_cast<const Bytef*>(data->first.data()) + at, part) != Z_OK ||
          got != block.size()) {
        return Error("a block that zlib cannot unpack");
      }
      at += part;
      bytes += block;
    }
    return bytes;
  }

  const std::string& name_;
  const XmlTag& array_;
  const VtuPacking& packing_;
  const std::uint64_t most_bytes_;
};

template <class T>
void Convert(const std::string& bytes, VtuValues& values) {
  std::vector<T> raw(bytes.size() / sizeof(T));
  if (!raw.empty()) std::memcpy(raw.data(), bytes.data(), raw.size() * sizeof(T));
  for (const T value : raw) {
    values.reals.push_back(static_cast<double>(value));
    if constexpr (std::is_integral_v<T>) {
      values.wholes.push_back(static_cast<std::int64_t>(value));
    }
  }
}

struct Type {
  std::string_view name;
  std::size_t bytes;
  void (*convert)(const std::string&, VtuValues&);
};
constexpr Type kDataTypes[] = {
    {"Float32", 4, &Convert<float>},      {"Float64", 8, &Convert<double>},
    {"Int8", 1, &Convert<std::int8_t>},   {"UInt8", 1, &Convert<std::uint8_t>},
    {"Int16", 2, &Convert<std::int16_t>}, {"UInt16", 2, &Convert<std::uint16_t>},
    {"Int32", 4, &Convert<std::int32_t>}, {"UInt32", 4, &Convert<std::uint32_t>},
    {"Int64", 8, &Convert<std::int64_t>}, {"UInt64", 8, &Convert<std::uint64_t>}};

}  // namespace

absl::StatusOr<std::vector<XmlTag>> ParseXmlTags(const std::string& name, std::string_view text) {
  std::vector<XmlTag> tags;
  int line = 1;
  std::size_t seen = 0;
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at + 1)) {
    line += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(seen),
                                        text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    seen = at;
    const std::size_t end = EndOfTag(text, at);
    if (end == std::string_view::npos)
      return TextReader::ErrorAt(name, line, "a tag without an end");
    if (text[at + 1] == '?' || text[at + 1] == '!') {
      at = end;
      continue;
    }
    std::string_view inside = text.substr(at + 1, end - at - 1);
    if (!inside.empty() && inside.back() == '/') inside.remove_suffix(1);
    XmlTag& tag = tags.emplace_back();
    tag.line = line;
    const auto blank = std::find_if(inside.begin(), inside.end(), IsBlank);
    const auto length = static_cast<std::size_t>(blank - inside.begin());
    tag.name = inside.substr(0, length);
    if (!ParseAttributes(inside.substr(length), tag)) {
      return TextReader::ErrorAt(name, line, "a tag whose attributes are no NAME=\"VALUE\"");
    }
    tag.text = text.substr(end + 1, text.find('<', end) - end - 1);
    at = end;
  }
  return tags;
}

absl::StatusOr<VtuValues> ReadVtuValues(const std::string& name, const XmlTag& array,
                                        const VtuPacking& packing, std::uint64_t most) {
  const auto error = [&](std::string_view message) {
    return TextReader::ErrorAt(name, array.line,
                               Concat("array ", Quoted(array.Get("Name")), ": ", message));
  };
  const auto type =
      std::find_if(std::begin(kDataTypes), std::end(kDataTypes),
                   [&](const Type& known) { return known.name == array.Get("type"); });
  if (type == std::end(kDataTypes)) return error(Concat("type ", Quoted(array.Get("type"))));
  VtuValues values;
  if (array.Get("format") == "ascii") {
    std::string_view rest = array.text;
    while (!rest.empty()) {
      const std::size_t begin = static_cast<std::size_t>(
          std::find_if_not(rest.begin(), rest.end(), IsBlank) - rest.begin());
      rest.remove_prefix(begin);
      const auto length =
          static_cast<std::size_t>(std::find_if(rest.begin(), rest.end(), IsBlank) - rest.begin());
      if (length == 0) break;
      const std::string_view word = rest.substr(0, length);
      rest.remove_prefix(length);
      double real = 0;
      std::int64_t whole = 0;
      if (type->name[0] != 'F' && ParseInt64(word, &whole)) {
        values.wholes.push_back(whole);
        real = static_cast<double>(whole);
      } else if (!ParseDouble(word, &real) || type->name[0] != 'F') {
        return error(Concat("no value of type ", type->name, ": ", Quoted(word)));
      }
      values.reals.push_back(real);
    }
    return values;
  }
  if (array.Get("format") != "binary" && array.Get("format") != "appended") {
    return error(
        Concat("format ", Quoted(array.Get("format")), ": expected ascii, binary or appended"));
  }
  const absl::StatusOr<std::string> bytes =
      Decoder(name, array, packing, most * type->bytes).Read();
  if (!bytes.ok()) return bytes.status();
  type->convert(*bytes, values);
  return values;
}

}  // namespace dynmesh::io
