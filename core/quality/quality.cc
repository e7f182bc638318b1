#include "dynmesh/quality.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/id_table.h"
#include "core/base/rounding.h"
#include "core/geometry/circumball.h"
#include "core/geometry/dihedral.h"
#include "core/geometry/products.h"
#include "core/quality/angle_steps.h"
#include "core/quality/degrees.h"
#include "core/quality/guarded_gaps.h"
#include "core/quality/seditious_edges.h"
#include "core/quality/tetrahedron_quality.h"
#include "core/quality/unsplit_gaps.h"

namespace dynmesh {
namespace {

struct Vector {
  double x, y;
};

double Cross(const Vector& u, const Vector& v) {
  return geometry::DifferenceOfProducts(u.x, v.y, u.y, v.x);
}

double Dot(const Vector& u, const Vector& v) { return u.x * v.x + u.y * v.y; }

// The greatest allowed ratio.
double Bound(double rho, double shortest_edge, double unit) {
  return rho * (1 + QualitySlack(shortest_edge, unit));
}

TriangleQuality Flat() {
  TriangleQuality flat;
  flat.radius_edge = std::numeric_limits<double>::infinity();
  flat.max_angle_deg = 180;
  flat.angles_deg = {0, 0, 180};
  return flat;
}

}  // namespace

TriangleQuality MeasureTriangle(const double* a, const double* b, const double* c) {
  // edge[i] is opposite to corner i, counter-clockwise.
  Vector edge[3] = {
      {c[0] - b[0], c[1] - b[1]}, {a[0] - c[0], a[1] - c[1]}, {b[0] - a[0], b[1] - a[1]}};
  double largest = 0;
  for (const Vector& e : edge) largest = std::max({largest, std::abs(e.x), std::abs(e.y)});
  if (!(largest > 0) || !std::isfinite(largest)) return Flat();
  // Scaled by a power of two, exactly: no product below overflows, and no relevant one underflows.
  const int scale = std::ilogb(largest);
  for (Vector& e : edge) e = {std::scalbn(e.x, -scale), std::scalbn(e.y, -scale)};
  double length[3];
  for (int i = 0; i < 3; ++i) length[i] = std::sqrt(Dot(edge[i], edge[i]));
  const int longest = static_cast<int>(std::max_element(length, length + 3) - length);
  const int shortest = static_cast<int>(std::min_element(length, length + 3) - length);
  // The two shorter edges have the least relative error.
  const double cross = Cross(edge[(longest + 1) % 3], edge[(longest + 2) % 3]);
  if (!(cross > 0)) return Flat();
  TriangleQuality q;
  q.shortest_edge = std::scalbn(length[shortest], scale);
  // R = abc / (2 cross); divided by the shortest edge, two factors remain.
  q.radius_edge = length[(shortest + 1) % 3] * length[(shortest + 2) % 3] / (2 * cross);
  for (int i = 0; i < 3; ++i) {
    const double dot = -Dot(edge[(i + 1) % 3], edge[(i + 2) % 3]);
    q.angles_deg[static_cast<std::size_t>(i)] = quality::Degrees(std::atan2(cross, dot));
  }
  q.min_angle_deg = *std::min_element(q.angles_deg.begin(), q.angles_deg.end());
  q.max_angle_deg = *std::max_element(q.angles_deg.begin(), q.angles_deg.end());
  return q;
}

double CoordinateUnit(std::span<const double> coordinates) {
  double largest = 0;
  for (const double c : coordinates) largest = std::max(largest, std::abs(c));
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  return UlpOf(largest);
}

double QualitySlack(double shortest_edge, double unit) {
  if (!(shortest_edge > 0) || std::isinf(shortest_edge)) return 0;
  // 2^k <= e^2 < 2^(k+1) with e = m 2^j, 1 <= m < 2: k is 2j or 2j + 1. Decided by m, since e^2 may
  // underflow.
  const int j = std::ilogb(shortest_edge);
  const double m = std::scalbn(shortest_edge, -j);
  return QualitySlackAt(2 * j + (m * m >= 2 ? 1 : 0), unit);
}

bool IsOverRho(const TriangleQuality& triangle, double rho, double unit) {
  if (std::isinf(triangle.radius_edge)) return true;
  return triangle.radius_edge > Bound(rho, triangle.shortest_edge, unit);
}

namespace {

template <int D>
using Rows = std::array<std::size_t, D + 1>;  // of a simplex's corners

// The verdict on a simplex, from its corners. Flat() stands for a simplex with an unknown vertex.
template <int D>
class Judge;

template <>
class Judge<2> {
 public:
  using Quality = TriangleQuality;

  Judge(const Mesh& mesh, const IdTable& row_of, const MeshOptions& options, double unit,
        std::span<const Feature> features)
      : coordinates_(mesh.vertices.coordinates),
        rho_(options.quality),
        unit_(unit),
        seditious_(mesh, row_of),
        guarded_(mesh, row_of, rho_),
        unsplit_(mesh, features, rho_) {}

  static Quality Flat() { return dynmesh::Flat(); }
  Quality Measure(const Rows<2>& rows) const {
    return MeasureTriangle(At(rows[0]), At(rows[1]), At(rows[2]));
  }
  SimplexVerdict operator()(const Rows<2>& rows, const Quality& q) {
    using enum SimplexVerdict;
    if (!IsOverRho(q, rho_, unit_)) return kGood;
    double shortest = std::numeric_limits<double>::infinity();  // of the other edges
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = rows[k], r = rows[(k + 1) % 3];
      if (seditious_.Has(p, r)) continue;
      const double dx = At(p)[0] - At(r)[0];
      const double dy = At(p)[1] - At(r)[1];
      shortest = std::min(shortest, std::sqrt(dx * dx + dy * dy));
    }
    const double circumradius = q.radius_edge * q.shortest_edge;
    const double most = Bound(rho_, shortest, unit_) * shortest;
    if (shortest > q.shortest_edge && (circumradius <= most || std::isinf(shortest))) {
      return kSmallInputAngle;
    }
    if (unsplit_.Has(rows)) return kUnsplit;
    return guarded_.Has(rows) ? kTerminationGuard : kOverRho;
  }

 private:
  const double* At(std::size_t row) const { return &coordinates_[2 * row]; }

  const std::vector<double>& coordinates_;
  const double rho_, unit_;
  const quality::SeditiousEdges seditious_;
  quality::GuardedGaps guarded_;
  const quality::UnsplitGaps unsplit_;
};

template <>
class Judge<3> {
 public:
  using Quality = TetrahedronQuality;

  Judge(const Mesh& mesh, const IdTable& row_of, const MeshOptions& options, double unit,
        std::span<const Feature>)
      : coordinates_(mesh.vertices.coordinates),
        containing_dimensions_(mesh.vertices.containing_dimensions),
        rho_(options.quality),
        unit_(unit),
        seditious_(mesh, row_of),
        dihedral_(options.min_dihedral) {}

  static Quality Flat() { return quality::FlatTetrahedron(); }
  Quality Measure(const Rows<3>& rows) const {
    return MeasureTetrahedron(At(rows[0]), At(rows[1]), At(rows[2]), At(rows[3]));
  }
  SimplexVerdict operator()(const Rows<3>& rows, const Quality& q) const {
    const double bound = Bound(rho_, q.shortest_edge, unit_);
    if (quality::IsOverBound(CornersOf(rows), q, bound)) {
      return IsExcused(rows, q) ? SimplexVerdict::kSmallInputAngle : SimplexVerdict::kOverRho;
    }
    return DihedralAngles(rows, q) == Angles::kBelow ? SimplexVerdict::kBelowDihedral
                                                     : SimplexVerdict::kGood;
  }
  bool HasDihedralBound() const { return dihedral_.degrees() > 0; }
  // Of the dihedral angles; kExcused: some are below the bound, but none that counts.
  enum class Angles { kGood, kExcused, kBelow };
  // As the mesher decides it; below for inverted tetrahedra, too. An angle opposite to a seditious
  // edge does not count, nor does any if two opposite edges are seditious and a corner is inside a
  // facet: such a tetrahedron is a trapezoid across a small angle between facets.
  Angles DihedralAngles(const Rows<3>& rows, const Quality& q) const {
    if (!HasDihedralBound()) return Angles::kGood;
    if (std::isinf(q.radius_edge)) return Angles::kBelow;
    if (!dihedral_.IsBelow(CornersOf(rows))) return Angles::kGood;
    Rows<3> sorted = rows;
    std::sort(sorted.begin(), sorted.end(), [this](std::size_t p, std::size_t r) {
      return std::lexicographical_compare(At(p), At(p) + 3, At(r), At(r) + 3);
    });
    const bool is_below = dihedral_.IsBelowSorted(CornersOf(sorted), [&](int i, int j) {
      return seditious_.Has(sorted[static_cast<std::size_t>(i)],
                            sorted[static_cast<std::size_t>(j)]);
    });
    return is_below && !IsTrapezoid(rows) ? Angles::kBelow : Angles::kExcused;
  }
  std::array<double, 3> CentroidOf(const Rows<3>& rows) const {
    std::array<double, 3> mean = {0, 0, 0};
    for (const std::size_t row : rows) {
      for (std::size_t k = 0; k < 3; ++k) mean[k] += At(row)[k] / 4;
    }
    return mean;
  }

 private:
  const double* At(std::size_t row) const { return &coordinates_[3 * row]; }
  bool IsTrapezoid(const Rows<3>& rows) const {
    const auto is_in_facet = [&](std::size_t row) { return containing_dimensions_[row] == 2; };
    if (std::ranges::none_of(rows, is_in_facet)) return false;
    const auto is_side = [&](std::size_t i, std::size_t j) {
      return seditious_.Has(rows[i], rows[j]);
    };
    return (is_side(0, 1) && is_side(2, 3)) || (is_side(0, 2) && is_side(1, 3)) ||
           (is_side(0, 3) && is_side(1, 2));
  }
  // Of one over rho: is it within rho of its shortest edge that counts? Corners that seditious
  // edges join stand for one: of the edges between two such groups the longest counts. (The other
  // corners of the groups hide the gaps of the shorter ones from the mesher.)
  bool IsExcused(const Rows<3>& rows, const Quality& q) const {
    if (std::isinf(q.radius_edge)) return false;
    std::array<std::size_t, 4> group = {0, 1, 2, 3};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (group[i] == group[j] || !seditious_.Has(rows[i], rows[j])) continue;
        std::ranges::replace(group, std::size_t{group[i]}, std::size_t{group[j]});
      }
    }
    std::array<std::array<double, 4>, 4> longest2 = {};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        double d2 = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const double d = At(rows[i])[k] - At(rows[j])[k];
          d2 += d * d;
        }
        double& most2 = longest2[std::max(group[i], group[j])][std::min(group[i], group[j])];
        most2 = std::max(most2, d2);
      }
    }
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (longest2[i][j] > 0) shortest = std::min(shortest, std::sqrt(longest2[i][j]));
      }
    }
    if (!(shortest > q.shortest_edge) || std::isinf(shortest)) return shortest > q.shortest_edge;
    const double bound = Bound(rho_, shortest, unit_) * (shortest / q.shortest_edge);
    return !quality::IsOverBound(CornersOf(rows), q, bound);
  }
  std::array<geometry::Point3, 4> CornersOf(const Rows<3>& rows) const {
    std::array<geometry::Point3, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) std::copy_n(At(rows[k]), 3, corners[k].c.begin());
    return corners;
  }

  const std::vector<double>& coordinates_;
  const std::vector<std::uint8_t>& containing_dimensions_;
  const double rho_, unit_;
  const quality::SeditiousEdges seditious_;
  const geometry::DihedralBound dihedral_;
};

// Calls f(index, rows) for each simplex, in order. `rows` is null if it names an unknown vertex.
template <int D, class F>
void ForEachRows(const Mesh& mesh, const IdTable& row_of, F f) {
  constexpr std::size_t kCorners = D + 1, kTogether = 64;  // whose vertices are looked up together
  std::array<IdTable::Number, kTogether * kCorners> found;
  const std::span<const VertexId> ids = mesh.simplices;
  for (std::size_t from = 0; from < mesh.simplex_count(); from += kTogether) {
    const std::size_t count = std::min(kTogether, mesh.simplex_count() - from);
    const std::span numbers = std::span(found).first(count * kCorners);
    row_of.FindAll(ids.subspan(from * kCorners, numbers.size()), numbers);
    for (const IdTable::Number row : numbers) {
      if (row != IdTable::kNone)
        __builtin_prefetch(&mesh.vertices.coordinates[D * std::size_t{row}]);
    }
    for (std::size_t s = 0; s < count; ++s) {
      Rows<D> rows;
      bool known = true;
      for (std::size_t k = 0; k < kCorners; ++k) {
        rows[k] = numbers[s * kCorners + k];
        known = known && rows[k] != IdTable::kNone;
      }
      f(from + s, known ? &rows : nullptr);
    }
  }
}

template <int D>
std::vector<SimplexVerdict> Judged(const Mesh& mesh, const MeshOptions& options,
                                   std::span<const Feature> features) {
  const IdTable row_of(mesh.vertices.ids);
  Judge<D> judge(mesh, row_of, options, CoordinateUnit(mesh.vertices.coordinates), features);
  std::vector<SimplexVerdict> verdicts;
  verdicts.reserve(mesh.simplex_count());
  ForEachRows<D>(mesh, row_of, [&](std::size_t, const Rows<D>* rows) {
    verdicts.push_back(rows == nullptr ? SimplexVerdict::kOverRho
                                       : judge(*rows, judge.Measure(*rows)));
  });
  return verdicts;
}

// Buckets of equal width up to 180 degrees.
template <std::size_t kSteps>
void Count(double angle_deg, std::array<std::uint64_t, kSteps>& histogram) {
  const double width = 180.0 / kSteps;
  ++histogram[std::min<std::size_t>(kSteps - 1, static_cast<std::size_t>(angle_deg / width))];
}

void CountAngles(const TriangleQuality& q, QualityReport& report) {
  for (const double angle : q.angles_deg) Count(angle, report.angle_histogram);
}

// The shares are counts here.
void CountAngles(const TetrahedronQuality& q, QualityReport& report) {
  for (const double angle : q.angles_deg) Count(angle, report.dihedral_histogram);
  report.share_below_5_deg += q.min_angle_deg < 5;
  report.share_below_10_deg += q.min_angle_deg < 10;
}

// Keeps `worst` sorted, the least first, at most kWorstDihedral. Later calls have greater indices.
void NoteWorst(const WorstTetrahedron& t, std::vector<WorstTetrahedron>& worst) {
  if (worst.size() == kWorstDihedral) {
    if (t.angle_deg >= worst.back().angle_deg) return;
    worst.pop_back();
  }
  const auto is_less = [](double angle, const WorstTetrahedron& u) { return angle < u.angle_deg; };
  worst.insert(std::upper_bound(worst.begin(), worst.end(), t.angle_deg, is_less), t);
}

void CountSlivers(const Judge<2>&, const Rows<2>*, const TriangleQuality&, std::uint64_t,
                  QualityReport&) {}

void CountSlivers(const Judge<3>& judge, const Rows<3>* rows, const TetrahedronQuality& q,
                  std::uint64_t index, QualityReport& report) {
  if (rows == nullptr) {
    report.below_dihedral += judge.HasDihedralBound();
    return;
  }
  const Judge<3>::Angles angles = judge.DihedralAngles(*rows, q);
  report.below_dihedral += angles == Judge<3>::Angles::kBelow;
  report.exempt_dihedral += angles == Judge<3>::Angles::kExcused;
  NoteWorst({q.min_angle_deg, index, judge.CentroidOf(*rows)}, report.worst_dihedral);
}

// Counts most simplices without measuring them: those that are good for certain, are no extreme of
// the report, and have their angles inside of steps. What it cannot tell for certain is measured.
template <int D>
class QuickCount;

template <>
class QuickCount<2> {
 public:
  QuickCount(const MeshOptions& options, QualityReport& report)
      : report_(report), most_ratio2_(options.quality * options.quality * (1 - kSlack)) {
    Notice();
  }

  // False: it is not counted.
  bool Count(const double* a, const double* b, const double* c) {
    const Vector e0 = {c[0] - b[0], c[1] - b[1]}, e1 = {a[0] - c[0], a[1] - c[1]},
                 e2 = {b[0] - a[0], b[1] - a[1]};
    const double l0 = Dot(e0, e0), l1 = Dot(e1, e1), l2 = Dot(e2, e2);
    const double longest = std::max({l0, l1, l2}), shortest = std::min({l0, l1, l2});
    const double cross = e0.x * e1.y - e0.y * e1.x;
    // Then rounding changes it by less than 1e-11 of itself, and nothing over- or underflows.
    if (!(cross > 1e-4 * longest) || !(longest < 1e100) || !(shortest > 1e-100)) return false;
    const double middle = l0 + l1 + l2 - longest - shortest;
    const double part = 1 / cross;
    if (!(middle * longest * part * part < 4 * std::min(most_ratio2_, worst_ratio2_))) return false;
    const double cot[3] = {-Dot(e1, e2) * part, -Dot(e2, e0) * part, -Dot(e0, e1) * part};
    std::size_t step[3];
    bool is_certain = true;
    for (int i = 0; i < 3; ++i) {
      const double slack = kSlack * (1 + std::fabs(cot[i]));
      step[i] = steps_.StepOf(cot[i]);
      is_certain &= steps_.IsInside(step[i], cot[i], slack) && cot[i] + slack < of_least_ &&
                    cot[i] - slack > of_greatest_;
    }
    if (!is_certain) return false;
    for (const std::size_t s : step) ++report_.angle_histogram[s];
    return true;
  }
  // The report may have new extremes.
  void Notice() {
    const std::array extremes = {report_.worst_radius_edge, report_.min_angle_deg,
                                 report_.max_angle_deg};
    if (extremes == noticed_) return;
    noticed_ = extremes;
    worst_ratio2_ = report_.worst_radius_edge * report_.worst_radius_edge * (1 - kSlack);
    of_least_ = quality::CotangentOf(report_.min_angle_deg);
    of_greatest_ = quality::CotangentOf(report_.max_angle_deg);
  }

 private:
  // Relative; many times what rounding makes.
  static constexpr double kSlack = 1e-9;

  QualityReport& report_;
  const double most_ratio2_;
  std::array<double, 3> noticed_ = {-1, -1, -1};
  double worst_ratio2_ = 0, of_least_ = 0, of_greatest_ = 0;
  const quality::AngleSteps<18> steps_{&quality::CotangentOf};
};

template <>
class QuickCount<3> {
 public:
  QuickCount(const MeshOptions& options, QualityReport& report)
      : report_(report),
        most_ratio2_(options.quality * options.quality * (1 - kRatioSlack)),
        of_bound_(options.min_dihedral > 0 ? KeyOf(options.min_dihedral)
                                           : std::numeric_limits<double>::infinity()) {
    Notice();
  }

  bool Count(const double* p, const double* q, const double* r, const double* t) {
    using geometry::Cross;
    using geometry::Dot;
    using geometry::Vector3;
    const auto minus = [](const double* x, const double* y) {
      return Vector3{x[0] - y[0], x[1] - y[1], x[2] - y[2]};
    };
    const Vector3 u = minus(q, p), v = minus(r, p), w = minus(t, p);
    const Vector3 uv = minus(r, q), uw = minus(t, q), vw = minus(t, r);
    const double uu = Dot(u, u), vv = Dot(v, v), ww = Dot(w, w);
    const double shortest = std::min({uu, vv, ww, Dot(uv, uv), Dot(uw, uw), Dot(vw, vw)});
    const double most2 = uu + vv + ww;  // at least half of the product of any two edges
    if (!(most2 < 1e50) || !(shortest > 1e-50)) return false;
    const geometry::Circumball ball(u, uu, v, vv, w, ww, false);
    // Then the ratio is right to 1e-8.
    if (!(ball.error * ball.error < 1e-18 * ball.r2)) return false;
    if (!(ball.r2 < std::min(most_ratio2_, worst_ratio2_) * shortest)) return false;
    const Vector3 n[4] = {Cross(uw, uv), Cross(v, w), Cross(w, u), Cross(u, v)};
    double part[4], least = most2 * most2;  // of the squared lengths
    for (int i = 0; i < 4; ++i) {
      const double n2 = Dot(n[i], n[i]);
      least = std::min(least, n2);
      part[i] = 1 / n2;
    }
    // Normals are right to a thousand roundings of products of edges, directions then to 1e-7.
    if (!(least > 1.3e-12 * most2 * most2)) return false;
    std::size_t step[6];
    double most = -1;
    bool is_certain = true;
    for (std::size_t i = 0, e = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j, ++e) {
        const double at = -Dot(n[i], n[j]), key = at * std::fabs(at) * part[i] * part[j];
        most = std::max(most, key);
        step[e] = steps_.StepOf(key);
        is_certain &= steps_.IsInside(step[e], key, kSlack) && key - kSlack > of_greatest_;
      }
    }
    if (!is_certain || !(most + kSlack < std::min(of_tenth_, of_bound_))) return false;
    for (const std::size_t s : step) ++report_.dihedral_histogram[s];
    const std::size_t of_least = steps_.StepOf(most);
    report_.share_below_5_deg += of_least < 1;
    report_.share_below_10_deg += of_least < 2;
    return true;
  }
  void Notice() {
    const auto& worst = report_.worst_dihedral;
    const double tenth = worst.size() < kWorstDihedral ? 180 : worst.back().angle_deg;
    const std::array extremes = {report_.worst_radius_edge, tenth, report_.max_angle_deg};
    if (extremes == noticed_) return;
    noticed_ = extremes;
    worst_ratio2_ = report_.worst_radius_edge * report_.worst_radius_edge * (1 - kRatioSlack);
    of_tenth_ = KeyOf(tenth);
    of_greatest_ = KeyOf(report_.max_angle_deg);
  }

 private:
  // A key changes by no more than its angle.
  static constexpr double kSlack = 1e-6, kRatioSlack = 1e-7;

  static double KeyOf(double degrees) { return quality::SignedSquaredCosineOf(degrees); }

  QualityReport& report_;
  const double most_ratio2_, of_bound_;
  // Of the greatest of the angles in the list of the worst, and of the greatest angle.
  std::array<double, 3> noticed_ = {-1, -1, -1};
  double worst_ratio2_ = 0, of_tenth_ = 0, of_greatest_ = 0;
  const quality::AngleSteps<36> steps_{&quality::SignedSquaredCosineOf};
};

template <int D>
void Measure(const Mesh& mesh, const MeshOptions& options, std::span<const Feature> features,
             QualityReport& report) {
  const IdTable row_of(mesh.vertices.ids);
  Judge<D> judge(mesh, row_of, options, CoordinateUnit(mesh.vertices.coordinates), features);
  QuickCount<D> quick(options, report);
  const auto count_quickly = [&](const Rows<D>& rows) {
    const auto at = [&](std::size_t k) { return &mesh.vertices.coordinates[D * rows[k]]; };
    if constexpr (D == 2) {
      return quick.Count(at(0), at(1), at(2));
    } else {
      return quick.Count(at(0), at(1), at(2), at(3));
    }
  };
  ForEachRows<D>(mesh, row_of, [&](std::size_t i, const Rows<D>* rows) {
    if (rows != nullptr && count_quickly(*rows)) return;
    const auto q = rows != nullptr ? judge.Measure(*rows) : Judge<D>::Flat();
    const SimplexVerdict verdict = rows != nullptr ? judge(*rows, q) : SimplexVerdict::kOverRho;
    CountSlivers(judge, rows, q, i, report);
    report.worst_radius_edge = std::max(report.worst_radius_edge, q.radius_edge);
    report.min_angle_deg = std::min(report.min_angle_deg, q.min_angle_deg);
    report.max_angle_deg = std::max(report.max_angle_deg, q.max_angle_deg);
    quick.Notice();
    report.over_rho += IsOverRho(verdict);
    report.exempt += IsExempt(verdict);
    report.exempt_by_guard += verdict == SimplexVerdict::kTerminationGuard;
    report.exempt_by_unsplit += verdict == SimplexVerdict::kUnsplit;
    CountAngles(q, report);
  });
}

}  // namespace

std::vector<SimplexVerdict> JudgeSimplices(const Mesh& mesh, const MeshOptions& options,
                                           std::span<const Feature> features) {
  if (mesh.dimension == 2) return Judged<2>(mesh, options, features);
  return mesh.dimension == 3 ? Judged<3>(mesh, options, features) : std::vector<SimplexVerdict>();
}

QualityReport MeasureQuality(const Mesh& mesh, const MeshOptions& options,
                             std::span<const Feature> features) {
  QualityReport report;
  const bool in_space = mesh.dimension == 3;
  if ((!in_space && mesh.dimension != 2) || mesh.simplex_count() == 0) return report;
  report.min_angle_deg = 180;
  in_space ? Measure<3>(mesh, options, features, report)
           : Measure<2>(mesh, options, features, report);
  const auto all = static_cast<double>(mesh.simplex_count());
  report.share_below_5_deg /= all;
  report.share_below_10_deg /= all;
  return report;
}

}  // namespace dynmesh
