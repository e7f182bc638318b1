#include "core/coplanar/plane_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dynmesh::coplanar {

using geometry::Difference;
using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

namespace {

void Normalize(Vector3& v) {
  const double length = std::sqrt(Dot(v, v));
  for (double& x : v) x /= length;
}

}  // namespace

PlaneFit::PlaneFit(const std::vector<Point3>& corners, const Vector3& normal,
                   const std::vector<double>& errors)
    : normal_(normal), weights_(corners.size(), 1) {
  if (!errors.empty()) {
    largest_error_ = *std::max_element(errors.begin(), errors.end());
    for (std::size_t i = 0; i < errors.size(); ++i) {
      // An error of 0 is a very small one.
      const double error = std::max(errors[i] / largest_error_, 1e-6);
      weights_[i] = 1 / (error * error);
    }
  }
  const Point3& from = corners.front();  // sums of differences keep their digits
  Vector3 sum = {0, 0, 0};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3 d = Difference(corners[i].c, from.c);
    for (std::size_t k = 0; k < 3; ++k) sum[k] += weights_[i] * d[k];
    weight_ += weights_[i];
  }
  for (int k = 0; k < 3; ++k) centre_[k] = from[k] + sum[static_cast<std::size_t>(k)] / weight_;
  Normalize(normal_);
  SetAxes();
  for (int i = 0; i < 3; ++i) {
    if (!Tilt(corners)) break;
  }
}

void PlaneFit::SetAxes() {
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (std::abs(normal_[k]) < std::abs(normal_[least])) least = k;
  }
  Vector3 axis = {0, 0, 0};
  axis[least] = 1;
  u_ = geometry::Cross(axis, normal_);
  Normalize(u_);
  w_ = geometry::Cross(normal_, u_);
}

// To the least squares of heights; false if that changes nothing, or corners are on a line.
bool PlaneFit::Tilt(const std::vector<Point3>& corners) {
  sums_ = {};
  double uh = 0, wh = 0, hs = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3 d = Difference(corners[i].c, centre_.c);
    const double u = Dot(u_, d), w = Dot(w_, d), h = weights_[i] * Dot(normal_, d);
    sums_.uu += weights_[i] * u * u;
    sums_.uw += weights_[i] * u * w;
    sums_.ww += weights_[i] * w * w;
    uh += u * h;
    wh += w * h;
    hs += h;
  }
  for (std::size_t k = 0; k < 3; ++k) centre_.c[k] += hs / weight_ * normal_[k];
  const double det = sums_.uu * sums_.ww - sums_.uw * sums_.uw;
  if (!(det > 1e-24 * (sums_.uu + sums_.ww) * (sums_.uu + sums_.ww))) return false;
  const double a = (uh * sums_.ww - wh * sums_.uw) / det;
  const double b = (wh * sums_.uu - uh * sums_.uw) / det;
  if (std::abs(a) + std::abs(b) < 1e-17) return false;
  for (std::size_t k = 0; k < 3; ++k) normal_[k] -= a * u_[k] + b * w_[k];
  Normalize(normal_);
  SetAxes();
  return true;
}

double PlaneFit::ErrorAt(const Point3& p) const {
  const Vector3 d = Difference(p.c, centre_.c);
  const double u = Dot(u_, d), w = Dot(w_, d);
  const double det = sums_.uu * sums_.ww - sums_.uw * sums_.uw;
  const double far = u * u * sums_.ww - 2 * u * w * sums_.uw + w * w * sums_.uu;
  return largest_error_ * std::min(std::sqrt(1 / weight_ + (det > 0 ? far / det : 0)), kMostErrors);
}

double RoundingAlong(const geometry::Vector3& normal, const geometry::Vector3& rounding) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += std::abs(normal[k]) * rounding[k];
  return sum;
}

std::vector<double> RoundingsAlong(Vector3 normal, const std::vector<std::uint32_t>& corners,
                                   const std::vector<Vector3>& roundings) {
  Normalize(normal);
  std::vector<double> along;
  for (const std::uint32_t c : corners) along.push_back(RoundingAlong(normal, roundings[c]));
  return along;
}

}  // namespace dynmesh::coplanar
