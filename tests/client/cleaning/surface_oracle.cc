#include "tests/client/cleaning/surface_oracle.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <cstdio>
#include <sstream>

namespace dynmesh::cleaning {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using ExactPoint = Kernel::Point_3;

ExactPoint Exact(const Place3& p) { return {p[0], p[1], p[2]}; }

template <std::size_t N>
bool BoxesMeet(const std::array<Place3, 3>& a, const std::array<Place3, N>& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    double lo_a = a[0][k], hi_a = lo_a, lo_b = b[0][k], hi_b = lo_b;
    for (const Place3& p : a) lo_a = std::min(lo_a, p[k]), hi_a = std::max(hi_a, p[k]);
    for (const Place3& p : b) lo_b = std::min(lo_b, p[k]), hi_b = std::max(hi_b, p[k]);
    if (lo_a > hi_b || lo_b > hi_a) return false;
  }
  return true;
}

template <class Corners>
std::string Text(const Corners& corners) {
  std::ostringstream text;
  text.precision(17);
  for (const Place3& p : corners) text << " (" << p[0] << ", " << p[1] << ", " << p[2] << ")";
  return text.str();
}

}  // namespace

std::string FaultOf(const PlainSurface& surface) {
  std::vector<Kernel::Triangle_3> exact;
  for (const auto& t : surface.triangles) {
    exact.emplace_back(Exact(t[0]), Exact(t[1]), Exact(t[2]));
    if (exact.back().is_degenerate()) return "degenerate:" + Text(t);
  }
  for (std::size_t i = 0; i < exact.size(); ++i) {
    for (std::size_t j = i + 1; j < exact.size(); ++j) {
      const auto &s = surface.triangles[i], &t = surface.triangles[j];
      if (!BoxesMeet(s, t)) continue;
      std::vector<Place3> shared;
      for (const Place3& p : s) {
        if (std::find(t.begin(), t.end(), p) != t.end()) shared.push_back(p);
      }
      bool good = false;
      const auto meet = CGAL::intersection(exact[i], exact[j]);
      if (!meet) {
        good = shared.empty();
      } else if (const auto* p = boost::get<ExactPoint>(&*meet)) {
        good = shared.size() == 1 && *p == Exact(shared[0]);
      } else if (const auto* e = boost::get<Kernel::Segment_3>(&*meet)) {
        good = shared.size() == 2 &&
               ((e->source() == Exact(shared[0]) && e->target() == Exact(shared[1])) ||
                (e->source() == Exact(shared[1]) && e->target() == Exact(shared[0])));
      }
      if (!good) return "faces meet:" + Text(s) + " and" + Text(t);
    }
  }
  for (const auto& e : surface.segments) {
    const Kernel::Segment_3 segment(Exact(e[0]), Exact(e[1]));
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const auto& t = surface.triangles[i];
      if (!BoxesMeet(t, e)) continue;
      const auto has = [&](const Place3& p) { return std::find(t.begin(), t.end(), p) != t.end(); };
      if (has(e[0]) && has(e[1])) continue;
      const auto meet = CGAL::intersection(segment, exact[i]);
      if (!meet) continue;
      const auto* p = boost::get<ExactPoint>(&*meet);
      const bool good =
          p != nullptr && ((has(e[0]) && *p == Exact(e[0])) || (has(e[1]) && *p == Exact(e[1])));
      if (!good) return "a segment and a face meet:" + Text(e) + " and" + Text(t);
    }
  }
  return "";
}

}  // namespace dynmesh::cleaning
