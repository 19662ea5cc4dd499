#include "diffsac/problem/chance_share.h"

#include <catch2/catch.hpp>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

TEST_CASE("shares of an image are areas over its area, 1 at most") {
  CHECK(DiscShare({200.0, 100.0}, 10.0) == Approx(std::acos(-1.0) * 100.0 / 20000.0));
  CHECK(DiscShare({2.0, 1.0}, 10.0) == 1.0);
  CHECK(DiscShare({0.0, 1.0}, 10.0) == 1.0);
  CHECK(EpipolarBandShare({300.0, 400.0}, 1.0) == Approx(2.0 * std::sqrt(2.0) * 500.0 / 120000.0));
}

TEST_CASE("an image whose size is unknown is the box of its points") {
  PointMatrix points(3, 2);
  points << 10, 5, 30, 5, 20, 65;
  CHECK(ImageExtent({640, 480}, points) == Eigen::Vector2d(640, 480));
  CHECK(ImageExtent({}, points) == Eigen::Vector2d(20, 60));
  CHECK(ImageExtent({}, points.topRows(0)) == Eigen::Vector2d(0, 0));
}

TEST_CASE("points that all lie on one axis-parallel line or plane are no chance") {
  PointMatrix line(101, 2);
  for (int i = 0; i <= 100; ++i) line.row(i) << 0.1 * i, 5.0;
  CHECK(SlabShare(line, 0.1) == Approx(0.2 * std::sqrt(2.0) / 10.0).epsilon(0.01));
  PointMatrix turned = line;
  turned << 0.6 * line.col(0) - 0.8 * line.col(1), 0.8 * line.col(0) + 0.6 * line.col(1);
  CHECK(SlabShare(turned, 0.1) == Approx(SlabShare(line, 0.1)));
  Problem problem{Task::kLine, line, 0.1};
  CHECK(Log10NfaOf(problem, 101, 0.1) < -100.0);
  CHECK(Log10NfaOf(problem, 4, 0.1) > 0.0);
  PointMatrix plane = PointMatrix::Random(300, 3);
  plane.col(2).setZero();
  problem = {Task::kPlane, plane, 0.01};
  CHECK(Log10NfaOf(problem, 300, 0.01) < -100.0);
  CHECK(SlabShare(plane.topRows(0), 0.1) == 1.0);
  CHECK(SlabShare(plane.topRows(1), 0.1) == 1.0);
}

}  // namespace
}  // namespace diffsac
