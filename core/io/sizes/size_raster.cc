// Rasters of target lengths.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>

#include "core/base/text.h"
#include "core/io/sizes/size_fields.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;

constexpr double kSameLength = 1.25;  // cells within this ratio are joined
constexpr std::size_t kMostCells = std::size_t{1} << 28;

// Joins cells to boxes, halving along the longest side.
class RasterSizes {
 public:
  RasterSizes(const SizeRaster& raster, const Box& within, FeatureId first, int dimension)
      : raster_(raster), within_(within), next_(first), d_(static_cast<std::size_t>(dimension)) {}

  absl::StatusOr<std::vector<Feature>> Run() {
    Add({0, 0, 0}, raster_.counts);
    if (features_.size() <= kMostSizes) return std::move(features_);
    return absl::InvalidArgumentError(Concat(raster_.file, ": more than ", kMostSizes,
                                             " sizing features; make the raster coarser"));
  }

 private:
  using Cell = std::array<std::size_t, 3>;

  double At(std::size_t x, std::size_t y, std::size_t z) const {
    return raster_.values[(z * raster_.counts[1] + y) * raster_.counts[0] + x];
  }

  double Place(std::size_t cell, std::size_t k) const {
    const double t = static_cast<double>(cell) / static_cast<double>(raster_.counts[k]);
    return raster_.box.lo[k] + t * (raster_.box.hi[k] - raster_.box.lo[k]);
  }

  void Add(const Cell& lo, const Cell& hi) {
    if (features_.size() > kMostSizes) return;
    Box box = {{0, 0, 0}, {0, 0, 0}};
    for (std::size_t k = 0; k < d_; ++k) {
      box.lo[k] = Place(lo[k], k), box.hi[k] = Place(hi[k], k);
      if (box.lo[k] > within_.hi[k] || box.hi[k] < within_.lo[k]) return;
    }
    double least = HUGE_VAL, most = 0;
    bool has_gap = false;
    for (std::size_t z = lo[2]; z < hi[2]; ++z) {
      for (std::size_t y = lo[1]; y < hi[1]; ++y) {
        for (std::size_t x = lo[0]; x < hi[0]; ++x) {
          const double value = At(x, y, z);
          has_gap |= !(value > 0);
          if (value > 0) least = std::min(least, value), most = std::max(most, value);
        }
      }
    }
    if (most == 0) return;
    if (!has_gap && most <= kSameLength * least) {
      features_.push_back(Feature::Size(next_++, box.lo, {SizeShape::kBox, least, 0, box.hi}));
      return;
    }
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (hi[k] - lo[k] > hi[axis] - lo[axis]) axis = k;
    }
    const std::size_t middle = (lo[axis] + hi[axis]) / 2;
    Cell lower = hi, upper = lo;
    lower[axis] = upper[axis] = middle;
    Add(lo, lower);
    Add(upper, hi);
  }

  const SizeRaster& raster_;
  const Box within_;
  FeatureId next_;
  const std::size_t d_;
  std::vector<Feature> features_;
};

template <class T>
void Convert(std::string_view bytes, bool is_swapped, std::vector<double>& values) {
  for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T)) {
    std::array<char, sizeof(T)> raw;
    std::copy_n(bytes.data() + i, sizeof(T), raw.begin());
    if (is_swapped) std::reverse(raw.begin(), raw.end());
    values.push_back(static_cast<double>(std::bit_cast<T>(raw)));
  }
}

struct NpyType {
  std::string_view name;  // without the mark of its byte order
  std::size_t bytes;
  void (*convert)(std::string_view, bool, std::vector<double>&);
};
constexpr NpyType kNpyTypes[] = {
    {"f8", 8, &Convert<double>},        {"f4", 4, &Convert<float>},
    {"i8", 8, &Convert<std::int64_t>},  {"i4", 4, &Convert<std::int32_t>},
    {"i2", 2, &Convert<std::int16_t>},  {"i1", 1, &Convert<std::int8_t>},
    {"u8", 8, &Convert<std::uint64_t>}, {"u4", 4, &Convert<std::uint32_t>},
    {"u2", 2, &Convert<std::uint16_t>}, {"u1", 1, &Convert<std::uint8_t>}};
static_assert(std::endian::native == std::endian::little, "< is not swapped");

// The text of a key's value in numpy's header.
std::string_view ValueOf(std::string_view header, std::string_view key) {
  const std::size_t at = header.find(key);
  if (at == std::string_view::npos) return {};
  const std::size_t colon = header.find(':', at);
  if (colon == std::string_view::npos) return {};
  std::string_view rest = header.substr(colon + 1);
  while (!rest.empty() && rest[0] == ' ') rest.remove_prefix(1);
  const std::size_t end = !rest.empty() && rest[0] == '(' ? rest.find(')') : rest.find(',');
  return rest.substr(0, end);
}

}  // namespace

absl::StatusOr<SizeRaster> ParseEsriAscii(TextReader reader) {
  SizeRaster raster;
  raster.file = reader.name();
  std::map<std::string, double> header;
  std::map<std::string, int> lines;
  double number = 0;
  bool has_row = false;
  while (!has_row && reader.Next()) {
    if (ParseDouble(reader.token(0), &number)) {
      has_row = true;
      break;
    }
    std::string key(reader.token(0));
    for (char& c : key) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const absl::StatusOr<double> value = reader.Double(1, key);
    if (!value.ok()) return value.status();
    header[key] = *value;
    lines[key] = reader.line();
  }
  const auto count_of = [&](const char* key, std::size_t& count) -> absl::Status {
    const auto it = header.find(key);
    if (it == header.end()) return reader.Error(Concat("the header has no count ", key));
    if (!(it->second >= 1 && it->second <= 1e9) || it->second != std::floor(it->second)) {
      return TextReader::ErrorAt(raster.file, lines[key],
                                 Concat(key, " must be a whole number from 1 to 10^9"));
    }
    count = static_cast<std::size_t>(it->second);
    return absl::OkStatus();
  };
  if (auto s = count_of("ncols", raster.counts[0]); !s.ok()) return s;
  if (auto s = count_of("nrows", raster.counts[1]); !s.ok()) return s;
  const double cell = header.contains("cellsize") ? header["cellsize"] : 0;
  if (!header.contains("cellsize")) {
    return reader.Error("the header has no cellsize: cells must be squares");
  }
  if (!(cell > 0)) {
    return TextReader::ErrorAt(raster.file, lines["cellsize"], "cellsize must be above 0");
  }
  const std::size_t cells = raster.counts[0] * raster.counts[1];
  if (cells > reader.text_size() || cells > kMostCells) {
    return reader.Error(Concat("the file is too short for ", cells, " values"));
  }
  raster.box = {{0, 0, 0}, {0, 0, 0}};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string start = k == 0 ? "xll" : "yll";
    const auto corner = header.find(start + "corner"), centre = header.find(start + "center");
    if (corner == header.end() && centre == header.end()) {
      return reader.Error(Concat("the header has no ", start, "corner and no ", start, "center"));
    }
    if (corner != header.end() && centre != header.end()) {
      return reader.Error(Concat("the header has both ", start, "corner and ", start, "center"));
    }
    raster.box.lo[k] = corner != header.end() ? corner->second : centre->second - cell / 2;
    raster.box.hi[k] = raster.box.lo[k] + cell * static_cast<double>(raster.counts[k]);
  }
  std::vector<double> rows;  // from the top
  while (has_row) {
    for (std::size_t i = 0; i < reader.size(); ++i) {
      const absl::StatusOr<double> value = reader.Double(i, "a value");
      if (!value.ok()) return value.status();
      const bool is_none = header.contains("nodata_value") && *value == header["nodata_value"];
      rows.push_back(is_none ? 0 : *value);
    }
    has_row = reader.Next();
  }
  if (rows.size() != cells) {
    return reader.Error(Concat("the file has ", rows.size(), " values, not ", cells));
  }
  for (std::size_t row = raster.counts[1]; row-- > 0;) {
    const auto first = rows.begin() + static_cast<std::ptrdiff_t>(row * raster.counts[0]);
    raster.values.insert(raster.values.end(), first,
                         first + static_cast<std::ptrdiff_t>(raster.counts[0]));
  }
  return raster;
}

absl::StatusOr<SizeRaster> ParseNpy(const std::string& name, const std::string& bytes,
                                    const Box& box, int dimension) {
  const auto error = [&](std::string_view message) {
    return absl::InvalidArgumentError(Concat(name, ": ", message));
  };
  constexpr std::string_view kMagic = "\x93NUMPY";
  if (!bytes.starts_with(kMagic) || bytes.size() < 12) return error("not a file of numpy");
  const bool is_long = bytes[6] != 1;
  const std::size_t begin = is_long ? 12 : 10;
  std::size_t length = 0;
  for (std::size_t i = begin; i-- > 8;) {
    length = length * 256 + static_cast<unsigned char>(bytes[i]);
  }
  if (length > bytes.size() - begin) return error("the header is cut off");
  const std::string_view header = std::string_view(bytes).substr(begin, length);
  std::string_view type = ValueOf(header, "'descr'");
  if (type.size() > 2) type = type.substr(1, type.size() - 2);
  const char order = type.empty() ? '\0' : type[0];
  const auto known =
      std::find_if(std::begin(kNpyTypes), std::end(kNpyTypes),
                   [&](const NpyType& t) { return !type.empty() && t.name == type.substr(1); });
  if (known == std::end(kNpyTypes) || (order != '<' && order != '>' && order != '|')) {
    return error(Concat("type ", Quoted(type), " cannot be read: use float64 or float32"));
  }
  if (ValueOf(header, "'fortran_order'") != "False") {
    return error("the array is in Fortran's order: use numpy.ascontiguousarray");
  }
  std::string_view shape = ValueOf(header, "'shape'");
  if (!shape.empty()) shape.remove_prefix(1);
  std::vector<std::size_t> sides;
  for (std::string_view part : text::Split(shape, ',')) {
    while (!part.empty() && part[0] == ' ') part.remove_prefix(1);
    std::uint64_t side = 0;
    if (part.empty()) continue;
    if (!ParseUint64(part, &side) || side == 0 || side > kMostCells) {
      return error(Concat("the shape is ", Quoted(shape)));
    }
    sides.push_back(static_cast<std::size_t>(side));
  }
  if (sides.size() == static_cast<std::size_t>(dimension) + 1 && sides[0] == 1) {
    sides.erase(sides.begin());
  }
  if (sides.size() != static_cast<std::size_t>(dimension)) {
    return error(Concat("the array has ", sides.size(), " dimensions, the mesh ", dimension));
  }
  SizeRaster raster;
  raster.file = name;
  raster.dimension = dimension;
  raster.box = box;
  std::size_t cells = 1;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    raster.counts[sides.size() - 1 - k] = sides[k];
    if (sides[k] > kMostCells / cells) return error("the array is too large");
    cells *= sides[k];
  }
  const std::string_view data = std::string_view(bytes).substr(begin + length);
  if (data.size() != cells * known->bytes) {
    return error(Concat("the array has ", data.size(), " bytes, not ", cells * known->bytes));
  }
  known->convert(data, order == '>', raster.values);
  return raster;
}

absl::StatusOr<std::vector<Feature>> SizesOf(const SizeRaster& raster, const Box& within,
                                             FeatureId first, int dimension) {
  if (dimension != raster.dimension) {
    return absl::InvalidArgumentError(Concat(raster.file, ": the raster is of ", raster.dimension,
                                             " dimensions, the mesh of ", dimension));
  }
  for (const double value : raster.values) {
    if (std::isinf(value)) {
      return absl::InvalidArgumentError(Concat(raster.file, ": a length is infinite"));
    }
  }
  return RasterSizes(raster, within, first, dimension).Run();
}

absl::StatusOr<std::vector<Feature>> ReadAscFile(const std::string& path, const SizedInput& input) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  const absl::StatusOr<SizeRaster> raster = ParseEsriAscii(*std::move(reader));
  if (!raster.ok()) return raster.status();
  return SizesOf(*raster, input.options.box, input.first, input.options.dimension);
}

absl::StatusOr<std::vector<Feature>> ReadNpyFile(const std::string& path, const SizedInput& input) {
  const absl::StatusOr<std::string> bytes = ReadWholeFile(path);
  if (!bytes.ok()) return bytes.status();
  const absl::StatusOr<SizeRaster> raster =
      ParseNpy(path, *bytes, input.options.box, input.options.dimension);
  if (!raster.ok()) return raster.status();
  return SizesOf(*raster, input.options.box, input.first, input.options.dimension);
}

}  // namespace dynmesh::io
