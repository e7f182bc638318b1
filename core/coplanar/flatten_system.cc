#include "core/coplanar/flatten_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/union_find.h"

namespace dynmesh::coplanar {

using geometry::Vector3;

namespace {

// Below this share of its length a vector is a combination of those before it.
constexpr double kIndependent = 1e-9;
// Of the gradient: then least squares are found.
constexpr double kFound = 1e-11;

double SumOfSquares(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return sum;
}

double SumOfSquares(const std::vector<Vector3>& values) {
  double sum = 0;
  for (const Vector3& v : values) sum += geometry::Dot(v, v);
  return sum;
}

}  // namespace

void FlattenSystem::AddPatch(const Vector3& normal, std::vector<Row> rows, double scale,
                             bool fixed) {
  Patch patch;
  patch.first = corners_.size();
  for (const Row& row : rows) {
    corners_.push_back(row.corner);
    heights_.push_back(row.height / scale);
    linear_.push_back({1, row.u, row.w});
  }
  patch.last = corners_.size();
  for (std::size_t k = 0; k < 3; ++k) patch.normal[k] = normal[k] / scale;
  patch.fixed = fixed;
  patches_.push_back(patch);
  // Gram and Schmidt.
  for (std::size_t k = 0; k < 3; ++k) {
    double before = 0, after = 0;
    for (std::size_t i = patch.first; i < patch.last; ++i) before += linear_[i][k] * linear_[i][k];
    for (int twice = 0; twice < 2; ++twice) {
      for (std::size_t j = 0; j < k; ++j) {
        double dot = 0;
        for (std::size_t i = patch.first; i < patch.last; ++i) dot += linear_[i][k] * linear_[i][j];
        for (std::size_t i = patch.first; i < patch.last; ++i) linear_[i][k] -= dot * linear_[i][j];
      }
    }
    for (std::size_t i = patch.first; i < patch.last; ++i) after += linear_[i][k] * linear_[i][k];
    const bool is_independent = after > kIndependent * kIndependent * before;
    const double by = is_independent ? 1 / std::sqrt(after) : 0;
    for (std::size_t i = patch.first; i < patch.last; ++i) linear_[i][k] *= by;
  }
}

void FlattenSystem::Project(std::vector<double>& values) const {
  for (const Patch& patch : patches_) {
    if (patch.fixed) continue;
    std::array<double, 3> dots{};
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      for (std::size_t k = 0; k < 3; ++k) dots[k] += values[i] * linear_[i][k];
    }
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      for (std::size_t k = 0; k < 3; ++k) values[i] -= dots[k] * linear_[i][k];
    }
  }
}

void FlattenSystem::Apply(const std::vector<Vector3>& motions, std::vector<double>& heights) const {
  for (const Patch& patch : patches_) {
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      const Vector3 &motion = motions[corners_[i]], &weight = weights_[corners_[i]];
      heights[i] = 0;
      for (std::size_t k = 0; k < 3; ++k) heights[i] += patch.normal[k] * weight[k] * motion[k];
    }
  }
  Project(heights);
}

void FlattenSystem::Transpose(const std::vector<double>& heights,
                              std::vector<Vector3>& motions) const {
  std::fill(motions.begin(), motions.end(), Vector3{});
  for (const Patch& patch : patches_) {
    for (std::size_t i = patch.first; i < patch.last; ++i) {
      const Vector3& weight = weights_[corners_[i]];
      for (std::size_t k = 0; k < 3; ++k) {
        motions[corners_[i]][k] += patch.normal[k] * weight[k] * heights[i];
      }
    }
  }
}

std::vector<std::vector<std::size_t>> FlattenSystem::Parts() const {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  UnionFind sets(patches_.size());
  std::vector<std::size_t> first(weights_.size(), kNone);  // patch, by corner
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Vector3& normal = patches_[p].normal;
    for (std::size_t i = patches_[p].first; i < patches_[p].last; ++i) {
      const Vector3& weight = weights_[corners_[i]];
      const bool moves =
          normal[0] * weight[0] != 0 || normal[1] * weight[1] != 0 || normal[2] * weight[2] != 0;
      if (!moves) continue;
      std::size_t& at = first[corners_[i]];
      if (at == kNone) at = p;
      sets.Unite(at, p);
    }
  }
  std::vector<std::vector<std::size_t>> parts;
  std::vector<std::size_t> part_of(patches_.size(), kNone);
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    std::size_t& part = part_of[sets.Find(p)];
    if (part == kNone) {
      part = parts.size();
      parts.emplace_back();
    }
    parts[part].push_back(p);
  }
  return parts;
}

FlattenSystem FlattenSystem::PartOf(const std::vector<std::size_t>& patches,
                                    std::vector<std::size_t>* corners) const {
  corners->clear();
  for (const std::size_t p : patches) {
    corners->insert(corners->end(),
                    corners_.begin() + static_cast<std::ptrdiff_t>(patches_[p].first),
                    corners_.begin() + static_cast<std::ptrdiff_t>(patches_[p].last));
  }
  std::sort(corners->begin(), corners->end());
  corners->erase(std::unique(corners->begin(), corners->end()), corners->end());
  std::vector<Vector3> weights;
  for (const std::size_t c : *corners) weights.push_back(weights_[c]);
  FlattenSystem part(std::move(weights));
  for (const std::size_t p : patches) {
    Patch patch = patches_[p];
    patch.first = part.corners_.size();
    for (std::size_t i = patches_[p].first; i < patches_[p].last; ++i) {
      const auto at = std::lower_bound(corners->begin(), corners->end(), corners_[i]);
      part.corners_.push_back(static_cast<std::size_t>(at - corners->begin()));
      part.heights_.push_back(heights_[i]);
      part.linear_.push_back(linear_[i]);
    }
    patch.last = part.corners_.size();
    part.patches_.push_back(patch);
  }
  return part;
}

std::vector<Vector3> FlattenSystem::Solve(double enough, int most_steps) {
  std::vector<Vector3> motions(weights_.size(), Vector3{});
  std::vector<std::size_t> corners;
  for (const std::vector<std::size_t>& patches : Parts()) {
    FlattenSystem part = PartOf(patches, &corners);
    const std::vector<Vector3> of_part = part.SolvePart(enough, most_steps);
    // A corner moves in one part at most.
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) motions[corners[i]][k] += of_part[i][k];
    }
    taken_ += part.taken_;
  }
  return motions;
}

std::vector<Vector3> FlattenSystem::SolvePart(double enough, int most_steps) {
  std::vector<double> rest = heights_;
  for (double& height : rest) height = -height;
  Project(rest);  // what is projected once stays so: gradients need no projection
  std::vector<Vector3> motions(weights_.size(), Vector3{}), gradient(weights_.size());
  std::vector<double> step(rest.size());
  Transpose(rest, gradient);
  std::vector<Vector3> way = gradient;
  double slope = SumOfSquares(gradient);
  const double first = slope;
  for (int i = 0; i < most_steps && slope > kFound * kFound * first; ++i) {
    const bool is_enough = std::all_of(rest.begin(), rest.end(),
                                       [&](double height) { return std::abs(height) <= enough; });
    if (is_enough) break;
    taken_ += corners_.size();
    Apply(way, step);
    const double length = SumOfSquares(step);
    if (!(length > 0)) break;
    const double by = slope / length;
    for (std::size_t c = 0; c < way.size(); ++c) {
      for (std::size_t k = 0; k < 3; ++k) motions[c][k] += by * way[c][k];
    }
    for (std::size_t j = 0; j < rest.size(); ++j) rest[j] -= by * step[j];
    Transpose(rest, gradient);
    const double next = SumOfSquares(gradient);
    for (std::size_t c = 0; c < way.size(); ++c) {
      for (std::size_t k = 0; k < 3; ++k) {
        way[c][k] = gradient[c][k] + next / slope * way[c][k];
      }
    }
    slope = next;
  }
  for (std::size_t c = 0; c < motions.size(); ++c) {
    for (std::size_t k = 0; k < 3; ++k) motions[c][k] *= weights_[c][k];
  }
  return motions;
}

}  // namespace dynmesh::coplanar
