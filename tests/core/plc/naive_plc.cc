#include "tests/core/plc/naive_plc.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
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
                                         reason::kTooClose,        reason::kEncroached};

class Checker {
 public:
  Checker(const FeatureMap& present, const std::vector<Edit>& batch)
      : before_(present), now_(present) {
    for (std::size_t i = 0; i < batch.size(); ++i) Act(batch[i], static_cast<long>(i));
    // An edit without a net effect is not to blame for anything.
    for (const auto& [id, f] : now_) {
      if (last_.contains(id) && last_[id] < error_at_ && IsAsBefore(f)) last_.erase(id);
    }
    for (const auto& [id, f] : now_) CheckAlone(f);
    for (const auto& [id, last] : last_) CheckUsers(id, last);
    CollectThings();
    for (std::size_t i = 0; i < things_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) CheckPair(things_[j], things_[i]);
    }
    CheckTies();
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
  using Pair = std::pair<FeatureId, FeatureId>;
  struct Found {
    // edit, segments after points, offender, which edge of a polygon, kind of problem, other
    std::tuple<long, int, FeatureId, Pair, int, FeatureId> key;
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
    const bool there = now_.contains(id);
    if (edit.action == Edit::Action::kSetLabel) {  // changes no geometry, so it takes no blame
      if (!there) fail(reason::kUnknownFeature);
      return;
    }
    last_[id] = i;
    if (error_) return;
    const bool is_set = edit.feature.kind == FeatureKind::kPolygon && id >= FeatureId{1} << 63;
    switch (edit.action) {
      case Edit::Action::kAdd:
        if (there) return fail(reason::kIdInUse);
        if (is_set) return fail(reason::kBadId);
        now_[id] = edit.feature;
        break;
      case Edit::Action::kSet:
        if (!there) return fail(reason::kUnknownFeature);
        if (is_set) return fail(reason::kBadId);
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
      case Edit::Action::kSetLabel:
        break;
    }
  }

  bool IsAsBefore(const Feature& f) const {
    const auto it = before_.find(f.id);
    if (it == before_.end() || it->second.kind != f.kind) return false;
    if (it->second.unsplit != f.unsplit) return false;
    if (f.kind == FeatureKind::kSegment) return it->second.ends == f.ends;
    if (f.kind == FeatureKind::kPolygon) return it->second.rings == f.rings;
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

  void Report(long edit, int rank, const std::string& reason, std::vector<FeatureId> features,
              Pair ends = {}) {
    const auto at = std::find(kOrder.begin(), kOrder.end(), reason);
    // Errors of a feature by itself come first.
    const int order = at == kOrder.end() ? -1 : static_cast<int>(at - kOrder.begin());
    const FeatureId other = features.size() > 1 ? features[1] : 0;
    found_.push_back({{edit, rank, features[0], ends, order, other}, {edit, reason, features}});
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
    if (f.kind == FeatureKind::kPolygon) {
      if (const auto fault = FindRingFault(f); !fault.empty()) {
        Report(Last(f.id), 1, reason::kBadPolygon, fault);
        return;
      }
      std::vector<FeatureId> features = {f.id};
      for (const FeatureId corner : Corners(f)) {
        if (!IsPoint(corner) && Last(corner) <= Last(f.id)) features.push_back(corner);
      }
      if (features.size() > 1) Report(Last(f.id), 1, reason::kUnknownEnd, features);
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
      if (Last(user) >= last) continue;
      const bool uses = f.kind == FeatureKind::kSegment
                            ? f.ends[0] != f.ends[1] && (f.ends[0] == id || f.ends[1] == id)
                            : FindRingFault(f).empty() && Corners(f).contains(id);
      if (f.kind != FeatureKind::kPoint && uses) features.push_back(user);
    }
    if (features.size() > 1) Report(last, 0, reason::kPointInUse, features);
  }

  // The 2D objects: points, segments, and edges of polygons, each once.
  struct Thing {
    Feature f;
    long blame = 0;
    bool is_edge = false;
  };

  void CollectThings() {
    std::map<Pair, long> segments;  // the least blame
    for (const auto& [id, f] : now_) {
      if (f.kind == FeatureKind::kPoint && HasPlace(id)) things_.push_back({f, Blame(f)});
      if (f.kind != FeatureKind::kSegment || !Whole(f)) continue;
      things_.push_back({f, Blame(f)});
      const auto [it, is_new] = segments.try_emplace(std::minmax(f.ends[0], f.ends[1]), Blame(f));
      it->second = std::min(it->second, Blame(f));
    }
    std::map<Pair, Thing> edges;
    for (const auto& [id, f] : now_) {
      if (f.kind != FeatureKind::kPolygon || !FindRingFault(f).empty()) continue;
      const std::set<FeatureId> corners = Corners(f);
      const auto is_point = [&](FeatureId corner) { return IsPoint(corner); };
      if (!std::all_of(corners.begin(), corners.end(), is_point)) continue;
      for (const auto& [p, q] : Edges(f)) {
        const Feature edge = Feature::Segment(id, p, q);
        if (!Whole(edge)) continue;
        // An edge that the polygon had before is as before, whatever else it became.
        const auto was = before_.find(id);
        const std::vector<Pair> had =
            was != before_.end() && was->second.kind == FeatureKind::kPolygon ? Edges(was->second)
                                                                              : std::vector<Pair>();
        const bool is_old = std::find(had.begin(), had.end(), Pair(p, q)) != had.end();
        const long blame = std::max({is_old ? -1 : Last(id), Last(p), Last(q)});
        const auto [it, is_new] = edges.try_emplace({p, q}, Thing{edge, blame, true});
        if (!is_new && blame < it->second.blame) it->second = {edge, blame, true};
      }
    }
    for (const auto& [pair, edge] : edges) {
      if (!segments.contains(pair) || segments[pair] > edge.blame) things_.push_back(edge);
    }
  }

  static std::vector<Pair> Edges(const Feature& polygon) {
    std::vector<Pair> edges;
    for (const auto& ring : polygon.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        edges.push_back(std::minmax(ring[i], ring[(i + 1) % ring.size()]));
      }
    }
    return edges;
  }
  static std::set<FeatureId> Corners(const Feature& polygon) {
    std::set<FeatureId> corners;
    for (const auto& ring : polygon.rings) corners.insert(ring.begin(), ring.end());
    return corners;
  }
  // The features to name if the rings do not form a polygon, else none.
  static std::vector<FeatureId> FindRingFault(const Feature& polygon) {
    if (polygon.rings.empty()) return {polygon.id};
    for (const auto& ring : polygon.rings) {
      if (ring.size() < 3) return {polygon.id};
      std::map<FeatureId, int> visits;
      for (const FeatureId point : ring) ++visits[point];
      for (const auto& [point, count] : visits) {
        if (count > 1) return {polygon.id, point};
      }
    }
    std::map<Pair, int> uses;
    for (const Pair& edge : Edges(polygon)) ++uses[edge];
    for (const auto& [edge, count] : uses) {
      if (count > 1) return {polygon.id, edge.first, edge.second};
    }
    return {};
  }

  void CheckPair(const Thing& s, const Thing& t) {
    const Feature &f = s.f, &g = t.f;
    const bool f_point = f.kind == FeatureKind::kPoint, g_point = g.kind == FeatureKind::kPoint;
    std::string reason = f_point && g_point ? PointPoint(f, g)
                         : f_point          ? PointSegment(f, g)
                         : g_point          ? PointSegment(g, f)
                                            : SegmentSegment(f, g);
    if (reason == reason::kDuplicateSegment && (s.is_edge || t.is_edge)) reason = "";
    if (reason.empty() && Encroach(f, g)) reason = reason::kEncroached;
    if (reason.empty()) return;
    // The later is the offender.
    const auto f_key = KeyOf(s), g_key = KeyOf(t);
    const auto& key = std::max(f_key, g_key);
    const FeatureId offender = std::get<2>(key), other = offender == f.id ? g.id : f.id;
    Report(std::get<0>(key), std::get<1>(key), reason, {offender, other}, std::get<3>(key));
  }

  // The order in which things are entered.
  static std::tuple<long, int, FeatureId, Pair> KeyOf(const Thing& thing) {
    const Pair ends = thing.is_edge ? Pair(std::minmax(thing.f.ends[0], thing.f.ends[1])) : Pair();
    return {thing.blame, thing.f.kind == FeatureKind::kPoint ? 0 : 1, thing.f.id, ends};
  }

  // Negative if the point is in the circle over the segment, 0 on it.
  Wide CircleSide(const Feature& point, const Feature& s) const {
    if (point.id == s.ends[0] || point.id == s.ends[1]) return 1;
    return Dot(PlaceOf(point), PlaceOf(now_.at(s.ends[0])), PlaceOf(now_.at(s.ends[1])));
  }

  bool Encroach(const Feature& f, const Feature& g) {
    const bool f_point = f.kind == FeatureKind::kPoint, g_point = g.kind == FeatureKind::kPoint;
    if (f_point && g_point) return false;
    if (f_point) return g.unsplit && CircleSide(f, g) < 0;
    if (g_point) return f.unsplit && CircleSide(g, f) < 0;
    return f.unsplit != g.unsplit && (f.unsplit ? Crosses(g, f) : Crosses(f, g));
  }

  // `f` may be split, `s` may not.
  bool Crosses(const Feature& f, const Feature& s) {
    const Place a = PlaceOf(now_.at(s.ends[0])), b = PlaceOf(now_.at(s.ends[1])),
                c = PlaceOf(now_.at(f.ends[0])), d = PlaceOf(now_.at(f.ends[1]));
    const auto is_acute = [&](Place apex, Place p, Place q) {
      const auto dot = static_cast<long double>(Dot(apex, p, q));
      const long double squares =
          static_cast<long double>(Dot(apex, p, p)) * static_cast<long double>(Dot(apex, q, q));
      if (dot > 0 && dot * dot < 1e-12L * squares) ambiguous_ = true;
      return dot > 0;
    };
    if (s.ends[0] == f.ends[0]) return is_acute(a, b, d);
    if (s.ends[0] == f.ends[1]) return is_acute(a, b, c);
    if (s.ends[1] == f.ends[0]) return is_acute(b, a, d);
    if (s.ends[1] == f.ends[1]) return is_acute(b, a, c);
    const long double mx = (static_cast<long double>(a.x) + static_cast<long double>(b.x)) / 2,
                      my = (static_cast<long double>(a.y) + static_cast<long double>(b.y)) / 2;
    const auto cx = static_cast<long double>(c.x), cy = static_cast<long double>(c.y),
               ux = static_cast<long double>(d.x) - cx, uy = static_cast<long double>(d.y) - cy;
    const long double u2 = ux * ux + uy * uy;
    const long double t =
        u2 > 0 ? std::clamp(((mx - cx) * ux + (my - cy) * uy) / u2, 0.0L, 1.0L) : 0;
    const long double away = std::hypot(cx + t * ux - mx, cy + t * uy - my);
    const long double bound =
        std::sqrt(static_cast<long double>(Dot(a, b, b))) / 2 * (1 + 1e-6L) + kLimit;
    if (std::abs(away - bound) < 1e-9L * bound) ambiguous_ = true;
    return away < bound;
  }

  // Two points on the circle over an unsplit segment, one on each side.
  void CheckTies() {
    std::vector<const Thing*> points;
    for (const Thing& thing : things_) {
      if (thing.f.kind == FeatureKind::kPoint) points.push_back(&thing);
    }
    for (const Thing& s : things_) {
      if (s.f.kind == FeatureKind::kPoint || !s.f.unsplit) continue;
      const Place a = PlaceOf(now_.at(s.f.ends[0])), b = PlaceOf(now_.at(s.f.ends[1]));
      for (const Thing* p : points) {
        for (const Thing* q : points) {
          if (CircleSide(p->f, s.f) != 0 || CircleSide(q->f, s.f) != 0) continue;
          if (Sign(Cross(a, b, PlaceOf(p->f))) * Sign(Cross(a, b, PlaceOf(q->f))) >= 0) continue;
          // Found when the last of the three is entered, if that is s or p.
          const auto last = std::max({KeyOf(s), KeyOf(*p), KeyOf(*q)});
          if (last == KeyOf(*q)) continue;
          const bool is_s = last == KeyOf(s);
          Report(std::get<0>(last), std::get<1>(last), reason::kEncroached,
                 {std::get<2>(last), is_s ? p->f.id : s.f.id}, std::get<3>(last));
        }
      }
    }
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
    if (apex == a || apex == b) return "";  // duplicate points, reported elsewhere
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
  std::vector<Thing> things_;
  std::vector<Found> found_;
  bool ambiguous_ = false;
};

}  // namespace

NaiveResult NaiveCheck(const FeatureMap& present, const std::vector<Edit>& batch) {
  return Checker(present, batch).Result();
}

}  // namespace dynmesh::plc
