#include "tests/core/plc/naive_plc.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

__extension__ typedef __int128 Wide;

// 2^-41 of the unit square, in units of 2^-52.
constexpr long double kLimit = 0x1p11L;

struct Place {
  std::int64_t x, y;
  friend bool operator==(const Place&, const Place&) = default;
};

Place PlaceOf(const Feature& f) {
  return {static_cast<std::int64_t>(std::ldexp(f.position[0], 52)),
          static_cast<std::int64_t>(std::ldexp(f.position[1], 52))};
}

Wide Cross(Place o, Place a, Place b) {
  return Wide(a.x - o.x) * (b.y - o.y) - Wide(a.y - o.y) * (b.x - o.x);
}
Wide Dot(Place o, Place a, Place b) {
  return Wide(a.x - o.x) * (b.x - o.x) + Wide(a.y - o.y) * (b.y - o.y);
}
int Sign(Wide w) { return w > 0 ? 1 : w < 0 ? -1 : 0; }

bool OnClosed(Place a, Place b, Place x) { return Cross(a, b, x) == 0 && Dot(x, a, b) <= 0; }

long double Distance(Place x, Place a, Place b) {
  const auto length = [](Wide square) { return std::sqrt(static_cast<long double>(square)); };
  if (a == b || Dot(a, b, x) <= 0) return length(Dot(a, x, x));
  if (Dot(b, a, x) <= 0) return length(Dot(b, x, x));
  return std::abs(static_cast<long double>(Cross(a, b, x))) / length(Dot(a, b, b));
}

// The order of reasons, should two features offend in several ways.
const std::vector<std::string> kOrder = {reason::kDuplicatePoint,  reason::kDuplicateSegment,
                                         reason::kSegmentsOverlap, reason::kPointOnSegment,
                                         reason::kSegmentsCross,   reason::kSmallAngle,
                                         reason::kTooClose};

class Checker {
 public:
  Checker(const FeatureMap& present, const std::vector<Edit>& batch)
      : before_(present), now_(present) {
    for (std::size_t i = 0; i < batch.size(); ++i) Act(batch[i], static_cast<long>(i));
    // An edit that changed nothing in the end is not to blame for anything.
    for (const auto& [id, f] : now_) {
      if (last_.contains(id) && last_[id] < error_at_ && IsAsBefore(f)) last_.erase(id);
    }
    for (const auto& [id, f] : now_) CheckAlone(f);
    for (const auto& [id, last] : last_) CheckUsers(id, last);
    for (const auto& [id, f] : now_) {
      for (const auto& [id2, f2] : now_) {
        if (id < id2) CheckPair(f, f2);
      }
    }
  }

  NaiveResult Result() {
    NaiveResult result;
    result.features = now_;
    result.ambiguous = ambiguous_;
    const auto first = std::min_element(found_.begin(), found_.end(),
                                        [](const auto& a, const auto& b) { return a.key < b.key; });
    if (first != found_.end() && first->problem.edit < error_at_) {
      result.problem = first->problem;
    } else if (error_) {
      result.problem = error_;
    }
    return result;
  }

 private:
  struct Found {
    // edit, segments after points, offender, kind of problem, the other
    std::tuple<long, int, FeatureId, int, FeatureId> key;
    NaiveProblem problem;
  };

  static constexpr long kNever = 1L << 60;

  void Act(const Edit& edit, long i) {
    const FeatureId id = edit.feature.id;
    const auto fail = [&](const char* reason) {
      if (error_) return;
      error_ = NaiveProblem{i, reason, {id}};
      error_at_ = i;
    };
    if (id == 0 || id >= FeatureId{0} - 65536) return fail(reason::kBadId);
    last_[id] = i;
    if (error_) return;
    const bool there = now_.contains(id);
    switch (edit.action) {
      case Edit::Action::kAdd:
        if (there) return fail(reason::kIdInUse);
        now_[id] = edit.feature;
        break;
      case Edit::Action::kSet:
        if (!there) return fail(reason::kUnknownFeature);
        now_[id] = edit.feature;
        break;
      case Edit::Action::kRemove:
        if (!there) return fail(reason::kUnknownFeature);
        now_.erase(id);
        break;
      case Edit::Action::kMove:
        if (!there) return fail(reason::kUnknownFeature);
        if (now_[id].kind != FeatureKind::kPoint) return fail(reason::kWrongKind);
        now_[id].position = edit.feature.position;
        break;
    }
  }

  bool IsAsBefore(const Feature& f) const {
    const auto it = before_.find(f.id);
    if (it == before_.end() || it->second.kind != f.kind) return false;
    if (f.kind == FeatureKind::kSegment) return it->second.ends == f.ends;
    return it->second.position[0] == f.position[0] && it->second.position[1] == f.position[1];
  }
  long Last(FeatureId id) const { return last_.contains(id) ? last_.at(id) : -1; }
  bool IsPoint(FeatureId id) const {
    return now_.contains(id) && now_.at(id).kind == FeatureKind::kPoint;
  }
  bool HasPlace(FeatureId id) const {
    if (!IsPoint(id)) return false;
    const auto& at = now_.at(id).position;
    return std::abs(at[0]) <= 2 && std::abs(at[1]) <= 2;  // false for NaN
  }
  bool Whole(const Feature& s) const {
    return HasPlace(s.ends[0]) && HasPlace(s.ends[1]) && s.ends[0] != s.ends[1];
  }
  long Blame(const Feature& f) const {
    long blame = Last(f.id);
    if (f.kind == FeatureKind::kSegment) {
      blame = std::max({blame, Last(f.ends[0]), Last(f.ends[1])});
    }
    return blame;
  }

  void Report(long edit, int rank, const std::string& reason, std::vector<FeatureId> features) {
    const auto at = std::find(kOrder.begin(), kOrder.end(), reason);
    // What is wrong with a feature by itself comes first.
    const int order = at == kOrder.end() ? -1 : static_cast<int>(at - kOrder.begin());
    const FeatureId other = features.size() > 1 ? features[1] : 0;
    found_.push_back({{edit, rank, features[0], order, other}, {edit, reason, features}});
  }

  void CheckAlone(const Feature& f) {
    if (f.kind == FeatureKind::kPoint) {
      const double x = f.position[0], y = f.position[1];
      if (!std::isfinite(x) || !std::isfinite(y)) {
        Report(Last(f.id), 0, reason::kNotFinite, {f.id});
      } else if (x < 0 || x > 1 || y < 0 || y > 1) {
        Report(Last(f.id), 0, reason::kOutsideBox, {f.id});
      }
      return;
    }
    if (f.ends[0] == f.ends[1]) {
      Report(Last(f.id), 1, reason::kDegenerateSegment, {f.id, f.ends[0]});
      return;
    }
    std::vector<FeatureId> features = {f.id};
    for (const FeatureId end : f.ends) {
      if (!IsPoint(end) && Last(end) <= Last(f.id)) features.push_back(end);
    }
    if (features.size() > 1) Report(Last(f.id), 1, reason::kUnknownEnd, features);
  }

  // Point `id` was removed (or became something else) last in edit `last`.
  void CheckUsers(FeatureId id, long last) {
    if (IsPoint(id)) return;
    std::vector<FeatureId> features = {id};
    for (const auto& [user, f] : now_) {
      if (f.kind != FeatureKind::kSegment || Last(user) >= last || f.ends[0] == f.ends[1]) continue;
      if ((f.ends[0] == id || f.ends[1] == id)) features.push_back(user);
    }
    if (features.size() > 1) Report(last, 0, reason::kPointInUse, features);
  }

  void CheckPair(const Feature& f, const Feature& g) {
    const bool f_point = f.kind == FeatureKind::kPoint, g_point = g.kind == FeatureKind::kPoint;
    if (f_point ? !HasPlace(f.id) : !Whole(f)) return;
    if (g_point ? !HasPlace(g.id) : !Whole(g)) return;
    const std::string reason = f_point && g_point ? PointPoint(f, g)
                               : f_point          ? PointSegment(f, g)
                               : g_point          ? PointSegment(g, f)
                                                  : SegmentSegment(f, g);
    if (reason.empty()) return;
    // The later is the offender.
    const auto f_key = std::tuple(Blame(f), f_point ? 0 : 1, f.id);
    const auto g_key = std::tuple(Blame(g), g_point ? 0 : 1, g.id);
    const auto& key = std::max(f_key, g_key);
    const FeatureId offender = std::get<2>(key), other = offender == f.id ? g.id : f.id;
    Report(std::get<0>(key), std::get<1>(key), reason, {offender, other});
  }

  bool TooClose(long double distance) {
    if (std::abs(distance - kLimit) < 0.02L * kLimit && distance != kLimit) ambiguous_ = true;
    return distance < kLimit;
  }

  std::string PointPoint(const Feature& f, const Feature& g) {
    const Place p = PlaceOf(f), q = PlaceOf(g);
    if (p == q) return reason::kDuplicatePoint;
    return TooClose(Distance(p, q, q)) ? reason::kTooClose : "";
  }

  std::string PointSegment(const Feature& f, const Feature& s) {
    if (s.ends[0] == f.id || s.ends[1] == f.id) return "";
    const Place x = PlaceOf(f), a = PlaceOf(now_.at(s.ends[0])), b = PlaceOf(now_.at(s.ends[1]));
    if (OnClosed(a, b, x)) return reason::kPointOnSegment;
    return TooClose(Distance(x, a, b)) ? reason::kTooClose : "";
  }

  std::string SegmentSegment(const Feature& s, const Feature& t) {
    const Place a = PlaceOf(now_.at(s.ends[0])), b = PlaceOf(now_.at(s.ends[1]));
    const Place c = PlaceOf(now_.at(t.ends[0])), d = PlaceOf(now_.at(t.ends[1]));
    if (std::minmax(s.ends[0], s.ends[1]) == std::minmax(t.ends[0], t.ends[1])) {
      return reason::kDuplicateSegment;
    }
    if (s.ends[0] == t.ends[0]) return Shared(a, b, d);
    if (s.ends[0] == t.ends[1]) return Shared(a, b, c);
    if (s.ends[1] == t.ends[0]) return Shared(b, a, d);
    if (s.ends[1] == t.ends[1]) return Shared(b, a, c);
    const int sc = Sign(Cross(a, b, c)), sd = Sign(Cross(a, b, d));
    const int ta = Sign(Cross(c, d, a)), tb = Sign(Cross(c, d, b));
    if (sc == 0 && sd == 0) {
      // More than a point in common: an end well inside, or the same two places.
      const auto inside = [](Place p, Place q, Place x) { return Dot(x, p, q) < 0; };
      const bool same = (a == c && b == d) || (a == d && b == c);
      return same || inside(a, b, c) || inside(a, b, d) || inside(c, d, a) || inside(c, d, b)
                 ? reason::kSegmentsOverlap
                 : "";
    }
    return sc * sd < 0 && ta * tb < 0 ? reason::kSegmentsCross : "";
  }

  std::string Shared(Place apex, Place a, Place b) {
    if (apex == a || apex == b) return "";  // duplicate points, said elsewhere
    const Wide dot = Dot(apex, a, b);
    if (dot <= 0) return "";
    if (Cross(apex, a, b) == 0) return reason::kSegmentsOverlap;
    const long double squares =
        static_cast<long double>(Dot(apex, a, a)) * static_cast<long double>(Dot(apex, b, b));
    const long double sine = std::sin(std::numbers::pi_v<long double> / 180'000);
    const long double bound = sine * sine * (1 - 1e-6L) * squares;
    const long double c = static_cast<long double>(Cross(apex, a, b));
    if (std::abs(c * c - bound) < 1e-9L * bound) ambiguous_ = true;
    return c * c < bound ? reason::kSmallAngle : "";
  }

  const FeatureMap& before_;
  FeatureMap now_;
  std::map<FeatureId, long> last_;
  std::optional<NaiveProblem> error_;
  long error_at_ = kNever;
  std::vector<Found> found_;
  bool ambiguous_ = false;
};

}  // namespace

NaiveResult NaiveCheck(const FeatureMap& present, const std::vector<Edit>& batch) {
  return Checker(present, batch).Result();
}

}  // namespace dynmesh::plc
