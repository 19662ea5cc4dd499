#include "diffsac/geometry/calibration.h"

#include <catch2/catch.hpp>

#include "diffsac/core/status.h"

namespace diffsac {

// What is refused, and by which words: tests/estimate/contract_test.cpp, of every function that takes a K.
TEST_CASE("a calibration matrix stays as it is, and one times a number becomes it") {
  Eigen::Matrix3d K;
  K << 1234.567, 0.1, 321.3, 0.0, 1230.1, 241.7, 0.0, 0.0, 1.0;
  CHECK(IsCalibration(K));
  CHECK(CheckedCalibration(K, "K") == K);
  CHECK_FALSE(IsCalibration(2.0 * K));
  CHECK(CheckedCalibration(2.0 * K, "K") == K);
  CHECK(CheckedCalibration(K / 3.0, "K").isApprox(K, 1e-14));
  Eigen::Matrix3d computed = K;
  computed(1, 0) = -1e-14;
  computed(2, 0) = 1e-19;
  computed(2, 2) = 1.0 - 1e-16;
  CHECK(CheckedCalibration(computed, "K").isApprox(K, 1e-14));
  CHECK(IsCalibration(CheckedCalibration(computed, "K")));
  CHECK_THROWS_AS(CheckedCalibration(K.transpose(), "K"), Error);
}

}  // namespace diffsac
