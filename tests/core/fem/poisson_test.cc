// The purpose of min_dihedral: with it the matrix of linear elements for Poisson's equation has
// bounds that depend on angle and sizes only; without it, its entries are unbounded.
// matrix_bounds.h has the bounds and their derivation.
#include "tests/core/fem/poisson.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/io/script/edit_script.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/core/fem/matrix_bounds.h"
#include "tests/support/source_path.h"
#include "tests/support/workload.h"

namespace dynmesh::test {
namespace {

constexpr double kBound = 10;  // degrees

// --- Inputs ---------------------------------------------------------------------------------

struct Input {
  std::string name;
  std::vector<Feature> features;
  Box box;
  double max_edge = 0;
  bool is_whole = false;  // the whole mesh is the domain, else the part within walls
};

// Point and polygon features of a prism over a 2D polygon with counter-clockwise corners.
void AddPrism(const std::vector<std::pair<double, double>>& base, double z0, double z1,
              std::vector<Feature>* features) {
  const FeatureId first = features->size() + 1;
  const FeatureId n = base.size();
  for (const double z : {z0, z1}) {
    for (const auto& [x, y] : base) {
      features->push_back(Feature::Point(features->size() + 1, x, y, z));
    }
  }
  std::vector<FeatureId> bottom, top;
  for (FeatureId i = 0; i < n; ++i) bottom.push_back(first + i), top.push_back(first + n + i);
  features->push_back(Feature::Polygon(features->size() + 1, {bottom}));
  features->push_back(Feature::Polygon(features->size() + 1, {top}));
  for (FeatureId i = 0; i < n; ++i) {
    const FeatureId next = (i + 1) % n;
    features->push_back(
        Feature::Polygon(features->size() + 1, {{bottom[i], bottom[next], top[next], top[i]}}));
  }
}

void AddCube(double lo, double hi, std::vector<Feature>* features) {
  AddPrism({{lo, lo}, {hi, lo}, {hi, hi}, {lo, hi}}, lo, hi, features);
}

void AddPoints(int count, std::uint64_t seed, std::vector<Feature>* features) {
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const double x = random.Unit(), y = random.Unit();
    features->push_back(Feature::Point(features->size() + 1, x, y, random.Unit()));
  }
}

Input Cube(double max_edge) {
  Input input{"cube", {}, {}, max_edge};
  AddCube(0, 1, &input.features);
  return input;
}

// The features after an edit script of tests/regress.
Input Script(const std::string& name) {
  Input input{name + ", whole", {}, {}, 0, true};
  const auto script = io::ReadEditScript(test::SourcePath("tests/regress/") + name + ".dynmesh");
  EXPECT_TRUE(script.ok()) << script.status();
  if (!script.ok()) return input;
  const auto mesh = DynamicMesh::Create(script->Options());
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  for (const io::ScriptBatch& batch : script->batches) {
    const auto diff = (*mesh)->Apply(batch.edits);
    EXPECT_TRUE(diff.ok()) << diff.status();
  }
  input.features = (*mesh)->Features();
  input.box = script->Options().box;
  return input;
}

std::vector<Input> Inputs() {
  std::vector<Input> inputs;
  AddPoints(1000, 3, &inputs.emplace_back(Input{"points, whole", {}, {}, 0, true}).features);
  Input& in_box = inputs.emplace_back(Input{"points in a cube", {}, {}});
  AddCube(0, 1, &in_box.features);
  AddPoints(500, 11, &in_box.features);
  Input& far = inputs.emplace_back(
      Input{"cube in a box, whole", {}, {{-0.5, -0.5, -0.5}, {1.5, 1.5, 1.5}}, 0, true});
  AddCube(0, 1, &far.features);
  Input& nested = inputs.emplace_back(Input{"cube in a cube", {}, {}, 0.1});
  AddCube(0, 1, &nested.features);
  AddCube(0.3, 0.7, &nested.features);
  Input& corner = inputs.emplace_back(Input{"L", {}, {{0, 0, 0}, {2, 2, 1}}, 0.15});
  AddPrism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 0, 1, &corner.features);
  for (const char* name : {"growth-around-areas", "plates-tip-to-tip", "facet-lattice-ties"}) {
    inputs.push_back(Script(name));
  }
  inputs.push_back(Cube(0.07));
  return inputs;
}

Domain MeshOf(const Input& input, double min_dihedral) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = kDefaultQuality3D;
  options.box = input.box;
  options.max_edge = input.max_edge;
  options.min_dihedral = min_dihedral;
  const auto mesh = BuildMesh(input.features, options);
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return mesh.ok() ? DomainOf(*mesh, input.is_whole) : Domain{};
}

// --- Solutions ------------------------------------------------------------------------------

constexpr double kPi = std::numbers::pi;

// 0 on the border of the unit cube.
Solution Sines(double /*width*/) {
  const auto u = [](const Vector& x) {
    return std::sin(kPi * x[0]) * std::sin(kPi * x[1]) * std::sin(kPi * x[2]);
  };
  return {u, [u](const Vector& x) { return 3 * kPi * kPi * u(x); },
          [](const Vector& x) {
            Vector s, c;
            for (std::size_t i = 0; i < 3; ++i) {
              s[i] = std::sin(kPi * x[i]), c[i] = kPi * std::cos(kPi * x[i]);
            }
            return Vector{c[0] * s[1] * s[2], s[0] * c[1] * s[2], s[0] * s[1] * c[2]};
          }};
}

// Not 0 there. It grows by e to the domain's width, however wide that is.
Solution Exponential(double width) {
  const double a = 1 / width;
  const auto u = [a](const Vector& x) {
    return std::exp(a * x[0]) * std::sin(2 * a * x[1]) * std::cos(a * x[2]);
  };
  return {
      u, [u, a](const Vector& x) { return 4 * a * a * u(x); },
      [a](const Vector& x) {
        const double e = a * std::exp(a * x[0]);
        const double s = std::sin(2 * a * x[1]), c = std::cos(a * x[2]);
        return Vector{e * s * c, 2 * e * std::cos(2 * a * x[1]) * c, -e * s * std::sin(a * x[2])};
      }};
}

// --- The matrix -----------------------------------------------------------------------------

// Solves for a vector with components in all eigenvectors.
Solved ExtremesOf(const StiffnessMatrix& matrix) {
  Random random(5);
  std::vector<double> b(matrix.size());
  for (double& x : b) x = random.Unit() - 0.5;
  constexpr int kMostIterations = 3000;
  return ConjugateGradients(matrix, b, false, 1e-10, kMostIterations);
}

double Rayleigh(const StiffnessMatrix& matrix, const std::vector<double>& x) {
  const std::vector<double> y = matrix.Times(x);
  double above = 0, below = 0;
  for (std::size_t i = 0; i < x.size(); ++i) above += x[i] * y[i], below += x[i] * x[i];
  return above / below;
}

// The extreme eigenvalues found lie within the true ones. Compares them with those found with other
// vectors: one step of inverse iteration, and twenty of power iteration from the greatest entry on.
void CheckExtremes(const StiffnessMatrix& matrix, const Solved& found) {
  EXPECT_LE(found.least, 1.001 * Rayleigh(matrix, found.x));
  std::vector<double> x(matrix.size(), 0);
  const auto& diagonal = matrix.diagonal();
  const auto greatest = std::max_element(diagonal.begin(), diagonal.end());
  x[static_cast<std::size_t>(greatest - diagonal.begin())] = 1;
  for (int i = 0; i < 20; ++i) {
    x = matrix.Times(x);
    const double most = *std::max_element(x.begin(), x.end());
    for (double& value : x) value /= most;
  }
  EXPECT_GE(found.greatest, 0.999 * Rayleigh(matrix, x));
}

struct Outcome {
  Shape shape;
  bool is_solved = false;  // then the rest counts
  Solved plain, scaled;
  Errors errors;
};

using SolutionOf = std::function<Solution(double width)>;

Outcome Look(const Input& input, double min_dihedral, const SolutionOf& solution_of) {
  const Domain domain = MeshOf(input, min_dihedral);
  Outcome outcome;
  if (domain.cells.empty()) return outcome;
  const Shape& shape = outcome.shape = ShapeOf(domain, kBound);
  std::printf(
      "%s, h %g, %s: %zu vertices, %zu tetrahedra; %d below %g degrees, angles %.4g to %.5g\n",
      input.name.c_str(), input.max_edge, min_dihedral > 0 ? "on" : "off", domain.points.size(),
      domain.cells.size(), shape.slivers, kBound, shape.least_angle, shape.greatest_angle);
  if (shape.flat > 0) {
    std::printf("    %d without a volume\n", shape.flat);
    return outcome;
  }
  const auto [lo, hi] = BoxOf(domain);
  const double width = std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]});
  const StiffnessMatrix matrix(domain);
  outcome.errors = SolvePoisson(domain, matrix, solution_of(width), &outcome.scaled);
  outcome.plain = ExtremesOf(matrix);
  outcome.is_solved = outcome.plain.has_converged && outcome.scaled.has_converged;
  std::printf(
      "    largest entry %.3g, scaled %.3g; condition%s %.3g, bound %.3g; scaled %.3g, bound %.3g\n"
      "    %d steps; errors %.4g in L2, %.4g of the gradient\n",
      matrix.largest_entry(), matrix.largest_scaled_entry(),
      outcome.plain.has_converged ? "" : " over", outcome.plain.condition(),
      shape.greatest_bound / shape.least_bound, outcome.scaled.condition(), shape.scaled_bound,
      outcome.scaled.iterations, outcome.errors.l2, outcome.errors.h1);
  if (min_dihedral > 0) CheckExtremes(matrix, outcome.plain);
  return outcome;
}

// --- Tests ----------------------------------------------------------------------------------

// x^a y^b z^c over the tetrahedron of 0 and the unit vectors: a! b! c! / (a + b + c + 3)!.
TEST(Poisson, IntegralsOfDegreeFiveAreExact) {
  const Corners p = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int a = 0; a <= 5; ++a) {
    for (int b = 0; a + b <= 5; ++b) {
      for (int c = 0; a + b + c <= 5; ++c) {
        const double found = Integrate(p, [&](const Vector& x) {
          return std::pow(x[0], a) * std::pow(x[1], b) * std::pow(x[2], c);
        });
        const double exact = std::tgamma(a + 1) * std::tgamma(b + 1) * std::tgamma(c + 1) /
                             std::tgamma(a + b + c + 4);
        EXPECT_NEAR(found, exact, 1e-12 * exact + 1e-16) << a << " " << b << " " << c;
      }
    }
  }
}

TEST(Poisson, MatricesHaveBoundsIfDihedralAnglesHave) {
  constexpr double kRounding = 1 + 1e-8;
  int unbounded = 0;
  for (const Input& input : Inputs()) {
    SCOPED_TRACE(input.name);
    const Outcome off = Look(input, 0, Exponential), on = Look(input, kBound, Exponential);
    const Shape& shape = on.shape;
    ASSERT_TRUE(on.is_solved);
    EXPECT_EQ(shape.slivers, 0);
    EXPECT_LE(shape.worst_difference, 1e-9);
    EXPECT_LE(shape.worst_cotangent, CotangentOf(kBound) * kRounding);
    EXPECT_LE(shape.worst_entry, CotangentOf(kBound) * kRounding);
    EXPECT_LE(on.plain.greatest, shape.greatest_bound);
    EXPECT_GE(on.plain.least, shape.least_bound);
    EXPECT_LE(on.plain.condition(), shape.greatest_bound / shape.least_bound);
    EXPECT_LE(on.scaled.greatest, 4 * kRounding);
    EXPECT_LE(on.scaled.condition(), shape.scaled_bound);
    // A sliver is an entry that is too large.
    if (off.shape.slivers > off.shape.flat) {
      EXPECT_GT(off.shape.worst_cotangent, CotangentOf(kBound));
    }
    unbounded += off.shape.slivers > 0;
    if (off.is_solved) {
      EXPECT_LE(on.errors.l2, 1.05 * off.errors.l2);
      EXPECT_LE(on.errors.h1, 1.05 * off.errors.h1);
    }
  }
  EXPECT_GE(unbounded, 7);  // else there was nothing to bound
}

TEST(Poisson, ErrorsFallWithEdgesAsTheoryHasIt) {
  for (const SolutionOf& solution_of : {SolutionOf(Sines), SolutionOf(Exponential)}) {
    std::optional<Errors> before;
    for (const double max_edge : {0.28, 0.14, 0.07}) {
      const Outcome on = Look(Cube(max_edge), kBound, solution_of);
      ASSERT_TRUE(on.is_solved);
      if (before) {
        const double l2 = std::log2(before->l2 / on.errors.l2);
        const double h1 = std::log2(before->h1 / on.errors.h1);
        std::printf("    orders %.3f and %.3f\n", l2, h1);
        EXPECT_GE(l2, 1.6);
        EXPECT_LE(l2, 2.4);
        EXPECT_GE(h1, 0.8);
        EXPECT_LE(h1, 1.2);
      }
      before = on.errors;
    }
  }
}

}  // namespace
}  // namespace dynmesh::test
