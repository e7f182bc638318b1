#include "core/transfer/region_bounds.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/transfer/compensated_sum.h"

namespace dynmesh::transfer {
namespace {

// The least change d with shares * d = missing and values in the range is that of factors x, one a
// part: d_v is the mean of the factors of v's parts, as far as the range has room. The factors are
// the maximum of a concave function, piecewise quadratic; its gradient is what the parts miss.
// Newton's method finds it.
//
// Where no values will do, factors grow beyond all bounds. So each round of Newton's method also
// has flows between parts that share a vertex, proportional to the difference of the factors'
// growth in this round. They vanish from round to round if values in the range will do, and else
// become the least flows (method of multipliers).
class Multipliers {
 public:
  Multipliers(const Range& range, std::span<const PartShare> shares, std::size_t part_count,
              std::span<const double> weights, std::span<const double> values)
      : range_(range),
        shares_(shares),
        weights_(weights),
        values_(values),
        wanted_(part_count),
        x_(part_count, 0),
        former_(part_count, 0),
        missing_(part_count),
        bounded_(values.begin(), values.end()) {
    std::vector<Sum> wanted(part_count);
    Sum size;
    for (const PartShare& share : shares)
      wanted[share.part].Add(share.amount * values[share.vertex]);
    for (std::size_t p = 0; p < part_count; ++p) wanted_[p] = wanted[p].value();
    for (std::size_t v = 0; v < values.size(); ++v) {
      size.Add(weights[v]);
      scale_ = std::max(scale_, std::abs(values[v]));
    }
    scale_ *= size.value();
    least_ = 1e-8 * size.value();
    FindWalls();
  }

  // Values in the range, which keep the sums as far as it has room.
  const std::vector<double>& Solve() {
    constexpr int kMostRounds = 40;
    constexpr double kStuck = 0.9;
    double before = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      former_ = x_;
      Maximise();
      const double rest = GreatestFlow();
      if (rest <= kRounding * scale_ || (round > 0 && rest > kStuck * before)) break;
      before = rest;
    }
    return bounded_;
  }

 private:
  static constexpr double kRounding = 4e-16;
  // What a difference of factors makes flow, relative to how it changes values: little, so few
  // rounds do.
  static constexpr double kFlow = 1e-4;

  struct Wall {
    std::uint32_t a, b;  // parts
    double weight;
  };

  void FindWalls() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> weights;
    for (std::size_t s = 0; s < shares_.size(); ++s) {
      for (std::size_t t = s + 1; t < shares_.size() && shares_[t].vertex == shares_[s].vertex;
           ++t) {
        const auto parts = std::minmax(shares_[s].part, shares_[t].part);
        if (const double whole = weights_[shares_[s].vertex]; whole > 0) {
          weights[parts] += shares_[s].amount * shares_[t].amount / whole;
        }
      }
    }
    for (const auto& [parts, weight] : weights) {
      walls_.push_back({parts.first, parts.second, kFlow * weight});
    }
  }

  static double FlowThrough(const Wall& wall, const std::vector<double>& x,
                            const std::vector<double>& former) {
    return wall.weight * ((x[wall.a] - former[wall.a]) - (x[wall.b] - former[wall.b]));
  }

  double GreatestFlow() const {
    double most = 0;
    for (const Wall& wall : walls_) {
      most = std::max(most, std::abs(FlowThrough(wall, x_, former_)));
    }
    return most;
  }

  // Sets `bounded_` and `missing_` for these factors.
  void Evaluate(const std::vector<double>& x) {
    std::vector<Sum> missing(wanted_.size());
    for (std::size_t p = 0; p < wanted_.size(); ++p) missing[p].Add(wanted_[p]);
    ForEachVertex([&](std::size_t v, std::span<const PartShare> of_one) {
      bounded_[v] = std::clamp(values_[v] + Change(x, v, of_one), range_.low, range_.high);
      for (const PartShare& share : of_one) missing[share.part].Add(-share.amount * bounded_[v]);
    });
    for (const Wall& wall : walls_) {
      const double flow = FlowThrough(wall, x, former_);
      missing[wall.a].Add(-flow), missing[wall.b].Add(flow);
    }
    for (std::size_t p = 0; p < missing.size(); ++p) missing_[p] = missing[p].value();
  }

  double Change(const std::vector<double>& x, std::size_t v,
                std::span<const PartShare> of_one) const {
    double sum = 0;
    for (const PartShare& share : of_one) sum += share.amount * x[share.part];
    return weights_[v] > 0 ? sum / weights_[v] : 0;
  }

  template <class F>
  void ForEachVertex(const F& f) const {
    for (std::size_t s = 0; s < shares_.size();) {
      std::size_t end = s + 1;
      while (end < shares_.size() && shares_[end].vertex == shares_[s].vertex) ++end;
      f(shares_[s].vertex, shares_.subspan(s, end - s));
      s = end;
    }
  }

  // Newton's method. Leaves the factors in `x_`, and what belongs to them.
  void Maximise() {
    constexpr int kMostSteps = 50;
    Evaluate(x_);
    for (int step = 0; step < kMostSteps && Greatest(missing_) > kRounding * scale_; ++step) {
      const std::vector<double> direction = Direction();
      const double slope = Dot(direction, missing_);
      if (!(slope > 0) || !Search(direction, slope)) return;
    }
  }

  // Goes in the direction, to about the maximum if that is on the way. False if that is no step.
  bool Search(const std::vector<double>& direction, double slope) {
    constexpr int kMostHalves = 50;
    constexpr double kEnough = 0.1;
    const std::vector<double> start = x_;
    double low = 0, high = 1, at = 1;
    for (int i = 0; i < kMostHalves; ++i) {
      for (std::size_t p = 0; p < x_.size(); ++p) x_[p] = start[p] + at * direction[p];
      Evaluate(x_);
      const double here = Dot(direction, missing_);
      if (std::abs(here) <= kEnough * slope || (at == 1 && here > 0)) return true;
      (here > 0 ? low : high) = at;
      at = 0.5 * (low + high);
    }
    return low > 0;
  }

  // Of Newton's method: (A D A' + walls) direction = missing, where D has the vertices with room on
  // both sides; by conjugate gradients, scaled by the diagonal.
  std::vector<double> Direction() const {
    const std::size_t n = x_.size();
    std::vector<double> diagonal(n, least_), direction(n, 0), r = missing_, z(n), p, ap(n);
    ForEachVertex([&](std::size_t v, std::span<const PartShare> of_one) {
      if (!HasRoom(v)) return;
      for (const PartShare& share : of_one) {
        diagonal[share.part] += share.amount * share.amount / weights_[v];
      }
    });
    for (const Wall& wall : walls_)
      diagonal[wall.a] += wall.weight, diagonal[wall.b] += wall.weight;
    const auto scaled = [&] {
      for (std::size_t k = 0; k < n; ++k) z[k] = r[k] / diagonal[k];
      return Dot(z, r);
    };
    double rz = scaled();
    const double enough = 1e-30 * rz;
    p = z;
    for (std::size_t step = 0; step < 2 * n + 10 && rz > enough; ++step) {
      for (std::size_t k = 0; k < n; ++k) ap[k] = least_ * p[k];
      ForEachVertex([&](std::size_t v, std::span<const PartShare> of_one) {
        if (!HasRoom(v)) return;
        const double change = Change(p, v, of_one);
        for (const PartShare& share : of_one) ap[share.part] += share.amount * change;
      });
      for (const Wall& wall : walls_) {
        const double flow = wall.weight * (p[wall.a] - p[wall.b]);
        ap[wall.a] += flow, ap[wall.b] -= flow;
      }
      const double pap = Dot(p, ap);
      if (!(pap > 0)) break;
      const double alpha = rz / pap;
      for (std::size_t k = 0; k < n; ++k) direction[k] += alpha * p[k], r[k] -= alpha * ap[k];
      const double next = scaled();
      for (std::size_t k = 0; k < n; ++k) p[k] = z[k] + next / rz * p[k];
      rz = next;
    }
    return direction;
  }

  bool HasRoom(std::size_t v) const {
    return weights_[v] > 0 && bounded_[v] > range_.low && bounded_[v] < range_.high;
  }

  static double Greatest(const std::vector<double>& a) {
    double most = 0;
    for (const double x : a) most = std::max(most, std::abs(x));
    return most;
  }

  static double Dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  }

  const Range range_;
  const std::span<const PartShare> shares_;
  const std::span<const double> weights_, values_;
  std::vector<double> wanted_;
  std::vector<double> x_, former_;  // factors: now, and when the round began
  std::vector<double> missing_;
  std::vector<double> bounded_;
  std::vector<Wall> walls_;
  double scale_ = 0;  // of integrals
  double least_ = 0;  // keeps the matrix definite
};

// What of the integral over a part is missing, relative to the whole, is a flow and not rounding.
constexpr double kNoFlow = 1e-13;

// What each part lost or gained, as flows from the first that lost to the first that gained. What
// one part has left may be what several others have each less than `rounding` of.
std::vector<PartFlow> Losses(std::span<const PartShare> shares, std::size_t part_count,
                             std::span<const double> before, std::span<const double> after,
                             double rounding) {
  std::vector<Sum> sums(part_count);
  for (const PartShare& share : shares) {
    sums[share.part].Add(share.amount * (before[share.vertex] - after[share.vertex]));
  }
  std::vector<double> lost;
  for (const Sum& sum : sums) lost.push_back(sum.value());
  std::vector<PartFlow> flows;
  // Between parts that lost more than `least_from` and that gained more than `least_to`.
  const auto flow = [&](double least_from, double least_to) {
    std::uint32_t from = 0, to = 0;
    while (true) {
      while (from < part_count && lost[from] <= least_from) ++from;
      while (to < part_count && -lost[to] <= least_to) ++to;
      if (from == part_count || to == part_count) return;
      const double amount = std::min(lost[from], -lost[to]);
      flows.push_back({from, to, amount});
      lost[from] -= amount, lost[to] += amount;
    }
  };
  flow(rounding, rounding);
  flow(rounding, 0);
  flow(0, rounding);
  std::sort(flows.begin(), flows.end(), [](const PartFlow& f, const PartFlow& g) {
    return std::pair(f.from, f.to) < std::pair(g.from, g.to);
  });
  return flows;
}

}  // namespace

std::vector<PartFlow> ClampInParts(const Range& range, std::span<const PartShare> shares,
                                   std::size_t part_count, std::span<const double> weights,
                                   std::span<double> values) {
  const bool inside = std::all_of(values.begin(), values.end(), [&](double value) {
    return value >= range.low && value <= range.high;
  });
  if (inside) return {};
  if (!(range.low < range.high)) {
    std::fill(values.begin(), values.end(), range.low);
    return {};
  }
  const std::vector<double> before(values.begin(), values.end());
  Multipliers multipliers(range, shares, part_count, weights, before);
  const std::vector<double>& bounded = multipliers.Solve();
  Sum rest, size;  // rest: rounding, if factors are large
  for (std::size_t v = 0; v < values.size(); ++v) {
    rest.Add(weights[v] * (before[v] - bounded[v])), size.Add(weights[v] * std::abs(before[v]));
    values[v] = bounded[v];
  }
  Clamp(range, weights, rest.value(), values);
  return Losses(shares, part_count, before, values, kNoFlow * size.value());
}

}  // namespace dynmesh::transfer
