#include "client/cli/size_flags.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/common/text_reader.h"
#include "core/io/formats/mesh_input.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using text::Quoted;

constexpr double kGradeStep = 1.25;  // of target lengths from one capsule to the next

class Sizes {
 public:
  explicit Sizes(Input& input) : input_(input) {
    for (const Feature& f : input.features) {
      next_ = std::max(next_, f.id + 1);
      features_[f.id] = &f;
    }
  }

  absl::Status AddFile(const std::string& path) {
    absl::StatusOr<std::vector<Feature>> read =
        io::ReadSizes(path, {input_.features, input_.options, next_});
    if (!read.ok()) {
      return absl::Status(read.status().code(),
                          Concat("--size: ", text::View(read.status().message())));
    }
    for (Feature& f : *read) Add(std::move(f), Concat("--size ", path));
    return absl::OkStatus();
  }

  // "IDS=H": at the features, everywhere along or in them.
  absl::Status AddLength(const std::string& flag) {
    std::vector<double> h;
    const auto ids = Parse("--size-of", flag, 1, "IDS=H", h);
    if (!ids.ok()) return ids.status();
    if (!(h[0] > 0)) return Error("--size-of", flag, "the length must be above 0");
    for (const FeatureId id : *ids) {
      const Feature& f = *features_[id];
      if (Is<APolygon>(f, Not<APoint, ASegment, ASize>) && input_.options.dimension == 2) {
        Add(Feature::SizePolygon(0, f.rings, h[0]), Concat("--size-of ", flag));
      } else {
        AddAround(f, 0, h[0], Concat("--size-of ", flag));
      }
    }
    return absl::OkStatus();
  }

  // "IDS=HMIN,HMAX,DMIN,DMAX": HMIN up to the distance DMIN, from there linear to HMAX at DMAX.
  absl::Status AddGrade(const std::string& flag) {
    std::vector<double> v;
    const auto ids = Parse("--grade", flag, 4, "IDS=HMIN,HMAX,DMIN,DMAX", v);
    if (!ids.ok()) return ids.status();
    if (!(v[0] > 0 && v[1] > v[0] && v[2] >= 0 && v[3] > v[2])) {
      return Error("--grade", flag, "0 < HMIN < HMAX and 0 <= DMIN < DMAX are needed");
    }
    const auto distance_of = [&](double h) {
      return v[2] + (std::min(h, v[1]) - v[0]) / (v[1] - v[0]) * (v[3] - v[2]);
    };
    for (const FeatureId id : *ids) {
      for (double h = v[0]; h < v[1]; h *= kGradeStep) {
        AddAround(*features_[id], distance_of(kGradeStep * h), h, Concat("--grade ", flag));
      }
    }
    return absl::OkStatus();
  }

  void Finish() {
    for (Feature& f : added_) input_.features.push_back(std::move(f));
    auto places = std::make_shared<const std::map<FeatureId, std::string>>(std::move(places_));
    input_.where = [places, others = std::move(input_.where)](FeatureId id) {
      const auto it = places->find(id);
      return it == places->end() ? others(id) : it->second;
    };
  }

 private:
  static absl::Status Error(const char* name, const std::string& flag, const std::string& what) {
    return absl::InvalidArgumentError(Concat(name, " ", flag, ": ", what));
  }

  void Add(Feature f, const std::string& place) {
    f.id = next_++;
    places_[f.id] = place;
    added_.push_back(std::move(f));
  }

  std::array<double, 3> At(FeatureId id) const { return features_.at(id)->position; }

  // A point, a segment, or the edges of a polygon, and all within `radius`.
  void AddAround(const Feature& f, double radius, double h, const std::string& place) {
    Visit(
        f,
        [&](const APoint& p) {
          const SizeShape shape = radius > 0 ? SizeShape::kDisc : SizeShape::kPoint;
          Add(Feature::Size(0, p.position, {shape, h, radius, {}}), place);
        },
        [&](const ASegment& s) {
          Add(Feature::SizeCapsule(0, {At(s.ends[0]), At(s.ends[1])}, radius, h), place);
        },
        [&](const APolygon& p) {
          for (const std::vector<FeatureId>& ring : p.rings) {
            Path path;
            for (const FeatureId id : ring) path.push_back(At(id));
            path.push_back(path.front());
            Add(Feature::SizeCapsule(0, std::move(path), radius, h), place);
          }
        },
        Ignore<ASize>);  // Parse refuses these
  }

  // "IDS=V,V,...": ids of points, segments and polygons; `all` is every segment and polygon.
  absl::StatusOr<std::vector<FeatureId>> Parse(const char* name, const std::string& flag,
                                               std::size_t values, const char* form,
                                               std::vector<double>& numbers) const {
    const std::size_t equals = flag.find('=');
    if (equals == std::string::npos) return Error(name, flag, Concat("expected ", form));
    const std::string_view left = std::string_view(flag).substr(0, equals);
    for (const std::string_view part :
         text::Split(std::string_view(flag).substr(equals + 1), ',')) {
      double number = 0;
      if (!io::ParseDouble(part, &number)) {
        return Error(name, flag, Concat("expected ", form, ", found ", Quoted(part)));
      }
      numbers.push_back(number);
    }
    if (numbers.size() != values) return Error(name, flag, Concat("expected ", form));
    std::vector<FeatureId> ids;
    if (left == "all") {
      for (const auto& [id, f] : features_) {
        if (Is<ASegment, APolygon>(*f, Not<APoint, ASize>)) ids.push_back(id);
      }
      return ids;
    }
    for (const std::string_view part : text::Split(left, ',')) {
      std::uint64_t id = 0;
      const bool is_number = io::ParseUint64(part, &id);
      const auto it = features_.find(id);
      if (!is_number || it == features_.end() ||
          Is<ASize>(*it->second, Not<APoint, ASegment, APolygon>)) {
        return Error(name, flag, Concat("there is no point, segment or polygon ", Quoted(part)));
      }
      if (!HasPoints(*it->second)) {
        return Error(name, flag, Concat("feature ", id, " names points that are not there"));
      }
      ids.push_back(id);
    }
    return ids;
  }

  bool HasPoints(const Feature& f) const {
    bool has = true;
    ForEachPointOf(f, [&](FeatureId id) { has = has && features_.contains(id); });
    return has;
  }

  Input& input_;
  FeatureId next_ = 1;
  std::map<FeatureId, const Feature*> features_;
  std::vector<Feature> added_;
  std::map<FeatureId, std::string> places_;
};

}  // namespace

void AddSizeFlags(CLI::App& command, SizeFlags& flags) {
  const auto add = [&](const char* name, std::vector<std::string>& values, const std::string& what,
                       const char* type) {
    command.add_option(name, values, what)->type_name(type)->take_all()->allow_extra_args(false);
  };
  add("--size", flags.files,
      Concat("Target lengths from ",
             io::ListOfFormats([](const io::Format& f) { return f.read_sizes != nullptr; }, "or",
                               true)),
      "FILE");
  add("--size-of", flags.of,
      "A target length along points and segments, in 2D polygons, by ids, or all", "IDS=H");
  add("--grade", flags.grades,
      "A target length by the distance from points, segments and edges of polygons: HMIN up to "
      "DMIN, growing to HMAX at DMAX, beyond that any",
      "IDS=HMIN,HMAX,DMIN,DMAX");
}

absl::Status ApplySizeFlags(const SizeFlags& flags, Input& input) {
  if (flags.files.empty() && flags.of.empty() && flags.grades.empty()) return absl::OkStatus();
  Sizes sizes(input);
  for (const std::string& path : flags.files) {
    if (auto s = sizes.AddFile(path); !s.ok()) return s;
  }
  for (const std::string& flag : flags.of) {
    if (auto s = sizes.AddLength(flag); !s.ok()) return s;
  }
  for (const std::string& flag : flags.grades) {
    if (auto s = sizes.AddGrade(flag); !s.ok()) return s;
  }
  sizes.Finish();
  return absl::OkStatus();
}

}  // namespace dynmesh::cli
