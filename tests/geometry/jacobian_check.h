#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>

namespace diffsac::testing {

/// Checks an analytic derivative against central finite differences: function(x) is a vector of doubles, `jacobian` its
/// derivative at x (rows: values, columns: arguments). The tolerance is relative to the largest entry; a step of 1e-5
/// leaves about ten digits.
template <class Function>
void CheckJacobian(const Function& function, const Eigen::VectorXd& x, const Eigen::MatrixXd& jacobian,
                   double tolerance = 1e-7, double step = 1e-5) {
  const double size = std::max(1e-12, jacobian.cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd ahead = x, behind = x;
    const double h = step * std::max(1.0, std::abs(x[i]));
    ahead[i] += h;
    behind[i] -= h;
    const Eigen::VectorXd numeric = (function(ahead) - function(behind)) / (2.0 * h);
    REQUIRE(numeric.size() == jacobian.rows());
    CAPTURE(i, numeric.transpose(), jacobian.col(i).transpose());
    CHECK((numeric - jacobian.col(i)).cwiseAbs().maxCoeff() <= tolerance * size);
  }
}

}  // namespace diffsac::testing
