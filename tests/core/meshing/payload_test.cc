// The cover stored by an operation: never too small, and not needlessly large.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "core/meshing/elements.h"
#include "core/meshing/read_cover.h"
#include "core/sac/operation_table.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::payload_test {
namespace {

using geometry::Point;

constexpr std::uint64_t kSeed = 20261121;

template <int D>
using Direction = std::array<double, D>;

// By numbers symmetric about 0, some left out now and then: directions in which the ends of boxes
// and orthants matter.
template <int D>
Direction<D> AnyDirection(test::Random& random) {
  while (true) {
    Direction<D> u;
    double sum = 0;
    for (double& x : u) {
      x = random.Below(4) == 0 ? 0 : 2 * random.Unit() - 1;
      sum += x * x;
    }
    if (sum == 0 || sum > 1) continue;
    for (double& x : u) x /= std::sqrt(sum);
    return u;
  }
}

template <int D>
Point<D> Along(const Point<D>& p, const std::type_identity_t<Direction<D>>& u, double distance) {
  Point<D> y = p;
  for (int k = 0; k < D; ++k) y[k] += distance * u[k];
  return y;
}

// Balls through p, like those about the vertices of its Voronoi cell.
template <int D>
struct Balls {
  Point<D> p;
  std::vector<Direction<D>> directions;  // of the centres from p
  std::vector<double> radii;
  ReadCover<D> cover{Point<D>()};

  Balls(test::Random& random, double scale) {
    for (int k = 0; k < D; ++k) p[k] = scale * (random.Unit() - 0.5);
    cover = ReadCover<D>(p);
    const double size = std::ldexp(scale, -random.Below(15));
    for (int n = 1 + random.Below(7); n > 0; --n) {
      directions.push_back(AnyDirection<D>(random));
      radii.push_back(size * std::ldexp(random.Unit(), -random.Below(6)));
      cover.AddBall(Along(p, directions.back(), radii.back()), radii.back(), 0);
    }
  }
  Payload<D> Kept() const {
    Payload<D> payload;
    payload.SetCover(cover);
    return payload;
  }
  // How far from p the balls reach along u.
  double ReachAlong(const Direction<D>& u) const {
    double reach = 0;
    for (std::size_t i = 0; i < radii.size(); ++i) {
      double cosine = 0;
      for (int k = 0; k < D; ++k) cosine += directions[i][k] * u[k];
      reach = std::max(reach, 2 * radii[i] * cosine);
    }
    return reach;
  }
};

template <int D>
void ExpectNoPointOfABallIsLost() {
  test::Random random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    const Balls<D> balls(random, std::ldexp(1.0, random.Below(60) - 30));
    const Payload<D> payload = balls.Kept();
    for (std::size_t i = 0; i < balls.radii.size(); ++i) {
      const double r = balls.radii[i];
      const Point<D> centre = Along(balls.p, balls.directions[i], r);
      const Point<D> y = Along(centre, AnyDirection<D>(random), r * (1 - 1e-7));
      ASSERT_TRUE(payload.CoverMayHold(balls.p, y)) << "seed " << kSeed << ", round " << round;
    }
    const Direction<D> u = AnyDirection<D>(random);
    ASSERT_TRUE(payload.CoverMayHold(balls.p, Along(balls.p, u, balls.ReachAlong(u) * (1 - 1e-7))))
        << "seed " << kSeed << ", round " << round;
  }
}

TEST(Payload, RegionHoldsEveryPointOfItsBalls) {
  ExpectNoPointOfABallIsLost<2>();
  ExpectNoPointOfABallIsLost<3>();
}

template <int D>
void ExpectLittleBeyondTheBox(double unit) {
  test::Random random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    const Balls<D> balls(random, 1);
    const Payload<D> payload = balls.Kept();
    const double slack = std::sqrt(payload.radius2) * (unit + 1e-5);
    const Extent<D>& box = balls.cover.box();
    for (int k = 0; k < D; ++k) {
      Point<D> above = balls.p, below = balls.p;
      above[k] = box.hi[k] + slack;
      below[k] = box.lo[k] - slack;
      ASSERT_FALSE(payload.CoverMayHold(balls.p, above)) << "seed " << kSeed << ": " << round;
      ASSERT_FALSE(payload.CoverMayHold(balls.p, below)) << "seed " << kSeed << ": " << round;
    }
  }
}

TEST(Payload, RegionIsHardlyLargerThanItsBox) {
  ExpectLittleBeyondTheBox<2>(1.0 / 63);
  ExpectLittleBeyondTheBox<3>(1.0 / 31);
}

// For each octant, the reach of the balls along directions all over it, including the edges.
TEST(Payload, InSpaceTheRegionIsHardlyLargerThanWhatBallsReachInEachOctant) {
  test::Random random(kSeed);
  constexpr int kSteps = 24;
  for (int round = 0; round < 300; ++round) {
    const Balls<3> balls(random, 1);
    const Payload<3> payload = balls.Kept();
    const double radius = std::sqrt(payload.radius2);
    for (int octant = 0; octant < 8; ++octant) {
      double reach = 0;
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; j <= kSteps; ++j) {
          const double turn = i * M_PI_2 / kSteps, rise = j * M_PI_2 / kSteps;
          Direction<3> u = {std::cos(turn) * std::cos(rise), std::sin(turn) * std::cos(rise),
                            std::sin(rise)};
          for (int k = 0; k < 3; ++k) u[k] = octant >> k & 1 ? u[k] : -u[k];
          reach = std::max(reach, balls.ReachAlong(u));
        }
      }
      const double told = balls.cover.Reach(octant);
      constexpr double kRounding = 1e-15;  // of the centres
      ASSERT_GE(told + kRounding, reach) << "seed " << kSeed << ", round " << round;
      ASSERT_LE(told * 0.99, reach + kRounding) << "seed " << kSeed << ", round " << round;
      const double out = ((told + radius / 15) * (1 + 1e-5) + kRounding) / std::sqrt(3);
      Point<3> y = balls.p;
      for (int k = 0; k < 3; ++k) y[k] += octant >> k & 1 ? out : -out;
      ASSERT_FALSE(payload.CoverMayHold(balls.p, y)) << "seed " << kSeed << ", round " << round;
    }
  }
}

TEST(Payload, RadiusIsHardlyLargerThanTheRegions) {
  test::Random random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    const Balls<3> balls(random, 1);
    const double kept = balls.Kept().radius2, r2 = balls.cover.radius2();
    ASSERT_GE(kept, r2) << "seed " << kSeed << ": " << round;
    ASSERT_LE(kept, r2 * (1 + 1.0 / 128 + 1e-6)) << "seed " << kSeed << ": " << round;
  }
}

// The cover that is certain despite doubt is the one stored for any cover within it.
template <int D>
void ExpectTheSameOfWhatMightBeMeant(double part) {
  test::Random random(kSeed);
  constexpr int kRounds = 20000;
  int certain = 0;
  for (int round = 0; round < kRounds; ++round) {
    const Balls<D> balls(random, 1);
    const double doubt = part * std::sqrt(balls.cover.radius2());
    Payload<D> payload;
    if (!payload.SetCover(balls.cover, doubt)) continue;
    ++certain;
    for (int i = 0; i < 8; ++i) {
      ReadCover<D> meant(balls.p);
      for (std::size_t b = 0; b < balls.radii.size(); ++b) {
        const Point<D> centre = Along(balls.p, balls.directions[b], balls.radii[b]);
        const auto change = [&] { return doubt / 8 * (2 * random.Unit() - 1); };
        meant.AddBall(Along(centre, AnyDirection<D>(random), change()), balls.radii[b] + change(),
                      doubt / 16 * random.Unit());
      }
      Payload<D> other;
      ASSERT_TRUE(other.SetCover(meant));
      ASSERT_EQ(other.radius2, payload.radius2) << "seed " << kSeed << ", round " << round;
      ASSERT_EQ(other.cover(), payload.cover()) << "seed " << kSeed << ", round " << round;
    }
  }
  EXPECT_GT(certain, kRounds / 20);  // few balls do not reach into all orthants: doubtful, too
}

TEST(Payload, IsCertainOnlyOfWhatDoubtDoesNotChange) {
  ExpectTheSameOfWhatMightBeMeant<2>(1e-6);
  ExpectTheSameOfWhatMightBeMeant<3>(1e-6);
  ExpectTheSameOfWhatMightBeMeant<2>(1e-3);
  ExpectTheSameOfWhatMightBeMeant<3>(1e-3);
}

template <int D>
void ExpectAllIfNothingIsKnown() {
  Point<D> p = {};
  p[0] = 1;
  const auto may_hold = [&](const ReadCover<D>& cover, double x, double y) {
    Payload<D> payload;
    payload.SetCover(cover);
    Point<D> q = p;
    q[0] += x;
    q[1] += y;
    return payload.CoverMayHold(p, q);
  };
  ReadCover<D> all(p);
  all.AddAll(4);
  EXPECT_TRUE(may_hold(all, 1.9, 0));
  EXPECT_TRUE(may_hold(all, 0, -1.9));
  EXPECT_TRUE(may_hold(all, -1.3, -1.3));
  EXPECT_FALSE(may_hold(all, 2.1, 0));
  // A squared radius beyond what a float holds.
  ReadCover<D> huge(p);
  Point<D> far = p;
  far[0] = 1e20;
  huge.AddBall(far, 1e20, 0);
  EXPECT_TRUE(may_hold(huge, 1e19, 0));
  EXPECT_TRUE(may_hold(huge, -1e19, 1e19));
  EXPECT_TRUE(may_hold(huge, 0, 0));
  ReadCover<D> unbounded(p);
  unbounded.AddAll(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(may_hold(unbounded, -0.5, -1));
}

TEST(Payload, RegionMayBeUnbounded) {
  ExpectAllIfNothingIsKnown<2>();
  ExpectAllIfNothingIsKnown<3>();
}

// There is one of these for each operation, which is to be a cache line or little more.
static_assert(sizeof(Payload<2>) == 12);
static_assert(sizeof(Payload<3>) == 16);
// Of a whole operation there is no padding that more of it would use.
template <int D>
struct Table : sac::OperationTable<Payload<D>> {
  static constexpr std::size_t kBytes = sizeof(typename sac::OperationTable<Payload<D>>::Operation);
};
static_assert(Table<2>::kBytes == 72);
static_assert(Table<3>::kBytes == 80);

}  // namespace
}  // namespace dynmesh::meshing::payload_test
