// The accuracy of a field after many edits and their inverses ("ping-pong"), against the global
// Galerkin projection and under refinement.
#include <cstdio>

#include "core/transfer/overlay.h"
#include "tests/core/geometry/random_points.h"
#include "tests/core/transfer/field_lab.h"

namespace dynmesh {
namespace {

using testing::FieldFunction;
using testing::Index;
using testing::IsLive;
using testing::RowCount;
using testing::Sample;

double Smooth(const double* x) { return std::sin(6 * x[0] + 1) * std::sin(5 * x[1] + 2); }

// Around the box the mesh is coarse, whatever the edge asked for in it.
template <std::size_t D>
bool IsWithin(const SlotMesh& mesh, std::size_t cell) {
  bool within = true;
  for (std::size_t k = 0; k <= D; ++k) {
    for (std::size_t x = 0; x < D; ++x) {
      const double at = mesh.points()[Index(mesh.cells()[cell * (D + 1) + k]) * D + x];
      within &= at > 0.1 && at < 0.9;
    }
  }
  return within;
}

// The L2 distance to a function within the box: P1 at the midpoints of edges, exact to second
// order; means at centroids.
template <std::size_t D>
double Distance(const SlotMesh& mesh, FieldKind kind, const std::vector<double>& u,
                const FieldFunction& f) {
  double sum = 0, whole = 0;
  for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
    if (!IsLive(mesh, c) || !IsWithin<D>(mesh, c)) continue;
    const double measure = testing::MeasureOf(mesh, c);
    whole += measure;
    const auto corner = [&](std::size_t k) { return Index(mesh.cells()[c * (D + 1) + k]); };
    if (kind != FieldKind::kP1) {
      double centroid[D] = {};
      for (std::size_t k = 0; k <= D; ++k) {
        for (std::size_t x = 0; x < D; ++x) {
          centroid[x] += mesh.points()[corner(k) * D + x] / static_cast<double>(D + 1);
        }
      }
      sum += measure * std::pow(u[c] - f(centroid), 2);
      continue;
    }
    for (std::size_t a = 0; a <= D; ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        double middle[D];
        for (std::size_t x = 0; x < D; ++x) {
          middle[x] = (mesh.points()[corner(a) * D + x] + mesh.points()[corner(b) * D + x]) / 2;
        }
        const double value = (u[corner(a)] + u[corner(b)]) / 2;
        sum += measure / (D * (D + 1) / 2.0) * std::pow(value - f(middle), 2);
      }
    }
  }
  return std::sqrt(sum / whole);
}

// The whole field projected, to many digits.
template <std::size_t D>
void ProjectGlobally(const SlotMesh& mesh, std::vector<double>& u) {
  const auto overlay = transfer::Overlay<D>::Make(mesh);
  u.resize(mesh.ids().size(), 0);
  std::vector<double> right(u.size(), 0);
  std::vector<bool> is_new(mesh.regions().size(), false);
  for (std::size_t j = 0; j < overlay.to.size(); ++j) {
    is_new[Index(overlay.to[j].slot)] = true;
    for (const auto& piece : overlay.PiecesOf(j)) {
      for (std::size_t a = 0; a <= D; ++a) {
        for (std::size_t b = 0; b <= D; ++b) {
          right[Index(overlay.to[j].vertices[b])] +=
              piece.mass[a * (D + 1) + b] * u[Index(overlay.from[piece.from].vertices[a])];
        }
      }
    }
  }
  const auto multiply = [&](const std::vector<double>& x, std::vector<double>& y, bool kept_only) {
    for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
      if (!IsLive(mesh, c) || (kept_only && is_new[c])) continue;
      const double unit = testing::MeasureOf(mesh, c) / ((D + 1) * (D + 2));
      double sum = 0;
      for (std::size_t k = 0; k <= D; ++k) sum += x[Index(mesh.cells()[c * (D + 1) + k])];
      for (std::size_t k = 0; k <= D; ++k) {
        const std::size_t v = Index(mesh.cells()[c * (D + 1) + k]);
        y[v] += unit * (sum + x[v]);
      }
    }
  };
  multiply(u, right, true);
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  };
  std::vector<double> x = u, r(u.size(), 0), p, mp(u.size());
  multiply(x, r, false);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = right[i] - r[i];
  p = r;
  double rr = dot(r, r);
  for (int step = 0; step < 500 && rr > 1e-26 * dot(right, right); ++step) {
    std::fill(mp.begin(), mp.end(), 0.0);
    multiply(p, mp, false);
    const double alpha = rr / dot(p, mp);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += alpha * p[i], r[i] -= alpha * mp[i];
    const double next = dot(r, r);
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = r[i] + next / rr * p[i];
    rr = next;
  }
  u = x;
}

struct Errors {
  double sampled = 0;    // of the function's own interpolant
  double carried = 0;    // after the edits
  double projected = 0;  // the same by the global projection, of P1
};

// In each of `rounds` rounds points are added all over the mesh, one per `share` vertices, and
// removed.
template <std::size_t D>
Errors PingPong(FieldOptions options, double max_edge, int rounds, double share, bool globally) {
  std::mt19937_64 random(11);
  MeshOptions mesh_options = testing::UnitBox(static_cast<int>(D));
  mesh_options.max_edge = max_edge;
  auto mesh = std::move(DynamicMesh::Create(mesh_options)).value();
  SlotMesh slots = SlotMesh::FromMesh(mesh->Snapshot()).value();
  std::vector<double> u = Sample(slots, options.kind, Smooth), w = u;
  Errors errors;
  errors.sampled = Distance<D>(slots, options.kind, u, Smooth);
  std::uniform_real_distribution<double> draw(0, 1);
  const auto count = static_cast<FeatureId>(static_cast<double>(slots.vertex_count()) / share);
  for (int round = 0; round < rounds; ++round) {
    EditBatch come, go;
    for (FeatureId id = 1; id <= count; ++id) {
      const double x = draw(random), y = draw(random), z = draw(random);
      come.push_back(Edit::Add(Feature::Point(id, x, y, z)));
      go.push_back(Edit::Remove(id));
    }
    for (const EditBatch* batch : {&come, &go}) {
      const auto diff = mesh->Apply(*batch);
      EXPECT_TRUE(diff.ok()) << diff.status();
      EXPECT_TRUE(slots.Apply(*diff).ok());
      u.resize(RowCount(slots, options.kind), 0);
      auto transfer = Transfer::Make(slots);
      EXPECT_TRUE(transfer.ok() && transfer->Carry(options, u).ok());
      if (globally) ProjectGlobally<D>(slots, w);
    }
  }
  errors.carried = Distance<D>(slots, options.kind, u, Smooth);
  if (globally) errors.projected = Distance<D>(slots, options.kind, w, Smooth);
  std::printf("h %.4f, %zu vertices: sampled %.3e, carried %.3e, projected %.3e\n", max_edge,
              slots.vertex_count(), errors.sampled, errors.carried, errors.projected);
  return errors;
}

double Slope(const Errors& coarse, const Errors& fine, double ratio) {
  return std::log(coarse.carried / fine.carried) / std::log(ratio);
}

TEST(Accuracy, P1IsAsGoodAsTheGlobalProjection) {
  const Errors plane = PingPong<2>({.kind = FieldKind::kP1}, 0.1, 100, 10, true);
  EXPECT_LE(plane.carried, 1.2 * plane.projected);
  const Errors space = PingPong<3>({.kind = FieldKind::kP1}, 0.25, 6, 10, true);
  EXPECT_LE(space.carried, 1.2 * space.projected);
}

TEST(Accuracy, FallsWithTheSquareOfTheEdge) {
  for (const FieldKind kind : {FieldKind::kP1, FieldKind::kP0Linear}) {
    const Errors coarse = PingPong<2>({.kind = kind}, 0.05, 100, 10, false);
    const Errors fine = PingPong<2>({.kind = kind}, 0.025, 100, 10, false);
    EXPECT_GE(Slope(coarse, fine, 2), 1.9) << static_cast<int>(kind);
  }
}

TEST(Accuracy, OfPlainMeansFallsWithTheEdge) {
  const Errors coarse = PingPong<2>({.kind = FieldKind::kP0}, 0.05, 100, 10, false);
  const Errors fine = PingPong<2>({.kind = FieldKind::kP0}, 0.025, 100, 10, false);
  EXPECT_GE(Slope(coarse, fine, 2), 0.9);
}

}  // namespace
}  // namespace dynmesh
