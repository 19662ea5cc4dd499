// Lines and planes do not depend on where the axes of the coordinates are.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"

namespace diffsac {
namespace {

constexpr double kThreshold = 0.03, kRounding = 1e-8;

template <int D>
using Points = Eigen::Matrix<double, Eigen::Dynamic, D>;
template <int D>
using Turn = Eigen::Transform<double, D, Eigen::Isometry>;

/// Uniform in x and y with noise σ in z.
Eigen::Vector3d OnFloor(Rng& rng, double sigma) {
  return {rng.Uniform(-5.0, 5.0), rng.Uniform(-3.0, 3.0), sigma * rng.Normal()};
}

struct Cloud {
  const char* name;
  std::function<Eigen::Vector3d(int, Rng&)> point;
  std::size_t planes;
};

const std::vector<Cloud>& Clouds() {
  static const std::vector<Cloud> clouds = {{"flat floor", [](int, Rng& rng) { return OnFloor(rng, 0.01); }, 1},
                                            {"exact plane", [](int, Rng& rng) { return OnFloor(rng, 0.0); }, 1},
                                            {"thin slab", [](int, Rng& rng) { return OnFloor(rng, 0.02); }, 1},
                                            {"two walls",
                                             [](int i, Rng& rng) {
                                               const Eigen::Vector3d p = OnFloor(rng, 0.01);
                                               return i % 2 == 0 ? p : Eigen::Vector3d(p[0], -3.0 + p[2], p[1] + 3.0);
                                             },
                                             2},
                                            {"floor among outliers",
                                             [](int i, Rng& rng) {
                                               const Eigen::Vector3d p = OnFloor(rng, 0.01);
                                               return i % 2 == 0 ? p
                                                                 : Eigen::Vector3d(p[0], p[1], rng.Uniform(-1.5, 1.5));
                                             },
                                             1}};
  return clouds;
}

Points<3> Draw(const Cloud& cloud, int count) {
  Rng rng(3);
  Points<3> points(count, 3);
  for (int i = 0; i < count; ++i) points.row(i) = cloud.point(i, rng).transpose();
  return points;
}

template <int D>
Points<D> Moved(const Points<D>& points, const Turn<D>& turn) {
  return (points * turn.linear().transpose()).rowwise() + turn.translation().transpose();
}

/// n · x + d = 0 in the coordinates before the turn, with the sign of `like`.
template <int D>
Eigen::Matrix<double, D + 1, 1> Back(const Eigen::Matrix<double, D + 1, 1>& model, const Turn<D>& turn,
                                     const Eigen::Matrix<double, D + 1, 1>& like) {
  Eigen::Matrix<double, D + 1, 1> back;
  back << turn.linear().transpose() * model.template head<D>(),
      model[D] + model.template head<D>().dot(turn.translation());
  return back.dot(like) < 0.0 ? Eigen::Matrix<double, D + 1, 1>(-back) : back;
}

/// Angles of every size about the axes and between them; a permutation of the axes; a translation.
std::vector<Turn<3>> Turns() {
  std::vector<Turn<3>> turns;
  for (const double degrees : {0.0, 1e-3, 1.0, 37.0, 90.0})
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 2, 3)})
      turns.emplace_back(Eigen::Translation3d(3.0, -2.0, 10.0) *
                         Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()));
  turns.push_back(Turn<3>::Identity());
  turns.back().linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return turns;
}

template <int D, class One, class Several>
void CheckAlike(const Points<D>& points, const std::vector<Turn<D>>& turns, const One& one, const Several& several) {
  const auto model = one(points, PointOptions{.max_residual = kThreshold});
  const auto models = several(points, PointOptions{.max_residual = kThreshold});
  REQUIRE(model.ok());
  for (const Turn<D>& turn : turns) {
    CAPTURE(turn.matrix());
    const Points<D> moved = Moved<D>(points, turn);
    const auto turned = one(moved, PointOptions{.max_residual = kThreshold});
    CHECK((Back<D>(turned.model, turn, model.model) - model.model).norm() < kRounding);
    CHECK(turned.inliers == model.inliers);
    CHECK(turned.sigma == Approx(model.sigma).margin(1e-12));
    CHECK(turned.diagnostics.log10_nfa == Approx(model.diagnostics.log10_nfa));
    const auto all = several(moved, PointOptions{.max_residual = kThreshold});
    CHECK(all.assignment == models.assignment);
    REQUIRE(all.models.size() == models.models.size());
    for (std::size_t k = 0; k < all.models.size(); ++k)
      CHECK((Back<D>(all.models[k], turn, models.models[k]) - models.models[k]).norm() < kRounding);
  }
}

TEST_CASE("a turn of the coordinates turns planes and changes nothing else") {
  for (const Cloud& cloud : Clouds()) {
    CAPTURE(cloud.name);
    CheckAlike<3>(Draw(cloud, 300), Turns(), EstimatePlane, EstimateMultiplePlanes);
  }
}

TEST_CASE("a turn of the coordinates turns lines and changes nothing else") {
  std::vector<Turn<2>> turns;
  for (const double degrees : {0.0, 1e-3, 1.0, 37.0, 90.0})
    turns.emplace_back(Eigen::Translation2d(3.0, -2.0) * Eigen::Rotation2Dd(degrees * std::numbers::pi / 180.0));
  turns.push_back(Turn<2>::Identity());
  turns.back().linear() << 0, 1, 1, 0;
  // The clouds seen from the side: lines along the axes.
  for (const Cloud& cloud : Clouds()) {
    CAPTURE(cloud.name);
    CheckAlike<2>(Draw(cloud, 300).rightCols<2>(), turns, EstimateLine, EstimateMultipleLines);
  }
}

TEST_CASE("several planes or lines are found where all points lie on one along the axes") {
  for (const Cloud& cloud : Clouds()) {
    CAPTURE(cloud.name);
    const Points<3> points = Draw(cloud, 300);
    CHECK(EstimateMultiplePlanes(points, PointOptions{.max_residual = kThreshold}).models.size() == cloud.planes);
    CHECK(EstimateMultipleLines(points.rightCols<2>(), PointOptions{.max_residual = kThreshold}).models.size() ==
          cloud.planes);
  }
}

TEST_CASE("points of no structure give no planes and no lines, thin as they may be") {
  for (const double thickness : {4.0, 0.6}) {
    Rng rng(5);
    Points<3> points(300, 3);
    for (int i = 0; i < 300; ++i)
      points.row(i) << rng.Uniform(-5.0, 5.0), rng.Uniform(-3.0, 3.0), thickness * rng.Uniform(-0.5, 0.5);
    CAPTURE(thickness);
    CHECK(EstimateMultiplePlanes(points, PointOptions{.max_residual = kThreshold}).models.empty());
    CHECK(EstimateMultipleLines(points.rightCols<2>(), PointOptions{.max_residual = kThreshold}).models.empty());
  }
}

}  // namespace
}  // namespace diffsac
