#include "diffsac/problem/vanishing_point_pool.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <numbers>

#include "diffsac/geometry/vanishing_point.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"
#include "geometry/segments.h"

namespace diffsac {
namespace {

double AngleDegrees(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180.0 / std::numbers::pi;
}

// Segments of two directions of a room, and others.
struct Room {
  Eigen::Matrix3d directions;
  PointMatrix segments;
  Eigen::VectorXd lengths;

  Room() {
    directions = Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.3, 1.0, 0.2).normalized()).toRotationMatrix();
    segments = testing::Stacked(testing::Stacked(testing::SegmentsTowards(directions.col(0), 40, 0.003, Rng(1)),
                                                 testing::SegmentsTowards(directions.col(1), 30, 0.003, Rng(2))),
                                testing::RandomSegments(30, Rng(3)));
    lengths = (segments.rightCols(2) - segments.leftCols(2)).rowwise().norm();
  }

  std::vector<Eigen::Vector3d> Hypotheses(int count) const {
    UniformSampler sampler(static_cast<int>(segments.rows()), 2, Rng(4));
    const std::vector<int> sets = DrawSets(sampler, 2, count);
    std::vector<Eigen::Vector3d> models;
    Eigen::Vector3d model;
    for (std::size_t i = 0; i < sets.size(); i += 2)
      if (VanishingPoint::SolveMinimal(segments, sets.data() + i, &model) > 0) models.push_back(model);
    return models;
  }
};

double Nearest(const VanishingPointPool& pool, const Eigen::Vector3d& direction) {
  double least = 90.0;
  for (const Eigen::Vector3d& model : pool.models) least = std::min(least, AngleDegrees(model, direction));
  return least;
}

}  // namespace

TEST_CASE("a pool has the directions of the segments first, and the third that no segment shows") {
  const Room room;
  const VanishingPointPool pool = MakeVanishingPointPool(room.segments, room.lengths, room.Hypotheses(500));
  REQUIRE(pool.models.size() > 3);
  CHECK(pool.models.size() <= kPoolSize);
  CHECK(AngleDegrees(pool.models[0], room.directions.col(0)) < 0.5);
  CHECK(AngleDegrees(pool.models[1], room.directions.col(1)) < 0.5);
  CHECK(Nearest(pool, room.directions.col(2)) < 0.5);
  for (std::size_t i = 0; i < pool.models.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) CHECK(AngleDegrees(pool.models[i], pool.models[j]) >= 0.99);
}

TEST_CASE("features have their sizes and are finite, of segments without length too") {
  Room room;
  room.segments.row(3).tail<2>() = room.segments.row(3).head<2>();
  const VanishingPointPool pool = MakeVanishingPointPool(room.segments, room.lengths, room.Hypotheses(200));
  const auto count = static_cast<Eigen::Index>(pool.models.size());
  CHECK(pool.features.rows() == count);
  CHECK(pool.features.cols() == kPoolFeatures);
  CHECK(pool.pairs.rows() == count * count);
  CHECK(pool.pairs.cols() == kPoolPairs);
  CHECK(pool.features.allFinite());
  CHECK(pool.pairs.allFinite());
}

TEST_CASE("the mirror image has the same features but for the odd ones, which change their sign") {
  const Room room;
  PointMatrix mirrored = room.segments;
  mirrored.col(0) *= -1.0;
  mirrored.col(2) *= -1.0;
  std::vector<Eigen::Vector3d> hypotheses = room.Hypotheses(300), others = hypotheses;
  for (Eigen::Vector3d& model : others) model[0] *= -1.0;
  const VanishingPointPool one = MakeVanishingPointPool(room.segments, room.lengths, hypotheses);
  const VanishingPointPool two = MakeVanishingPointPool(mirrored, room.lengths, others);
  REQUIRE(one.models.size() == two.models.size());
  const Eigen::Index even = kPoolFeatures - kPoolOddFeatures;
  CHECK((one.features.leftCols(even) - two.features.leftCols(even)).cwiseAbs().maxCoeff() < 1e-3f);
  CHECK((one.features.rightCols(kPoolOddFeatures) + two.features.rightCols(kPoolOddFeatures)).cwiseAbs().maxCoeff() <
        1e-3f);
  CHECK((one.pairs - two.pairs).cwiseAbs().maxCoeff() < 1e-2f);
}

TEST_CASE("no hypotheses make an empty pool") {
  const Room room;
  const VanishingPointPool pool = MakeVanishingPointPool(room.segments, room.lengths, {});
  CHECK(pool.models.empty());
  CHECK(pool.features.rows() == 0);
}

}  // namespace diffsac
