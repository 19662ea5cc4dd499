#include "diffsac/geometry/manifolds.h"

#include <cmath>

#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/svd3.h"

namespace diffsac {
HomographyManifold HomographyManifold::From(const Matrix3Parameters& model) { return {model / model.norm()}; }

Eigen::Matrix<double, 9, 8> HomographyManifold::Tangent() const {
  // The reflection that maps e_last to ±h has h's orthogonal complement as its other columns.
  Matrix3Parameters axis = h;
  axis[8] += h[8] < 0.0 ? -1.0 : 1.0;
  const double beta = 2.0 / axis.squaredNorm();
  return Eigen::Matrix<double, 9, 9>::Identity().leftCols<8>() - beta * axis * axis.head<8>().transpose();
}

HomographyManifold HomographyManifold::Retract(const Eigen::Matrix<double, 8, 1>& step) const {
  return {(h + Tangent() * step).normalized()};
}

FundamentalManifold FundamentalManifold::From(const Matrix3Parameters& model) {
  const Svd3 svd = ComputeRotationSvd3(AsMatrix(model));
  return {Eigen::Quaterniond(svd.u), Eigen::Quaterniond(svd.v), std::atan2(svd.values[1], svd.values[0])};
}

Matrix3Parameters FundamentalManifold::Parameters() const {
  const Eigen::Matrix3d a = u.toRotationMatrix(), b = v.toRotationMatrix();
  return Flatten(std::cos(angle) * a.col(0) * b.col(0).transpose() + std::sin(angle) * a.col(1) * b.col(1).transpose());
}

Eigen::Matrix<double, 9, 7> FundamentalManifold::Tangent() const {
  const Eigen::Matrix3d a = u.toRotationMatrix(), b = v.toRotationMatrix();
  const double c = std::cos(angle), s = std::sin(angle);
  // d(U exp[ω]ₓ) turns columns of U into each other: about 1: u2 → u3; about 2: u1 → −u3; about 3: u1 → u2, u2 → −u1.
  const auto outer = [&](int i, int j) -> Eigen::Matrix3d { return a.col(i) * b.col(j).transpose(); };
  Eigen::Matrix<double, 9, 7> tangent;
  tangent.col(0) = Flatten(s * outer(2, 1));
  tangent.col(1) = Flatten(-c * outer(2, 0));
  tangent.col(2) = Flatten(c * outer(1, 0) - s * outer(0, 1));
  tangent.col(3) = Flatten(s * outer(1, 2));
  tangent.col(4) = Flatten(-c * outer(0, 2));
  tangent.col(5) = Flatten(c * outer(0, 1) - s * outer(1, 0));
  tangent.col(6) = Flatten(c * outer(1, 1) - s * outer(0, 0));
  return tangent;
}

FundamentalManifold FundamentalManifold::Retract(const Eigen::Matrix<double, 7, 1>& step) const {
  return {(u * ExpRotation(step.head<3>())).normalized(), (v * ExpRotation(step.segment<3>(3))).normalized(),
          angle + step[6]};
}

EssentialManifold EssentialManifold::From(const Matrix3Parameters& model) {
  const Svd3 svd = ComputeRotationSvd3(AsMatrix(model));
  Eigen::Matrix3d quarter_turn;
  quarter_turn << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  return {Eigen::Quaterniond(Eigen::Matrix3d(svd.u * quarter_turn * svd.v.transpose())), svd.u.col(2)};
}

Matrix3Parameters EssentialManifold::Parameters() const {
  return Flatten(std::sqrt(0.5) * CrossMatrix(translation) * rotation.toRotationMatrix());
}

Eigen::Matrix<double, 9, 5> EssentialManifold::Tangent() const {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  const Eigen::Matrix3d e = CrossMatrix(translation) * r;
  const Eigen::Matrix<double, 3, 2> plane = PlaneBasis(translation);
  Eigen::Matrix<double, 9, 5> tangent;
  for (int i = 0; i < 3; ++i) tangent.col(i) = Flatten(e * CrossMatrix(Eigen::Vector3d::Unit(i)));
  for (int i = 0; i < 2; ++i) tangent.col(3 + i) = Flatten(CrossMatrix(plane.col(i)) * r);
  return std::sqrt(0.5) * tangent;
}

EssentialManifold EssentialManifold::Retract(const Eigen::Matrix<double, 5, 1>& step) const {
  return {(rotation * ExpRotation(step.head<3>())).normalized(),
          (translation + PlaneBasis(translation) * step.tail<2>()).normalized()};
}

template <UnknownFocal kUnknown, bool kHeld>
FocalManifold<kUnknown, kHeld> FocalManifold<kUnknown, kHeld>::From(const FocalParameters& model) {
  return {EssentialManifold::From(model.head<9>()), {std::log(model[9]), std::log(model[10])}};
}

template <UnknownFocal kUnknown, bool kHeld>
FocalParameters FocalManifold<kUnknown, kHeld>::Model() const {
  return AsFocalParameters(essential.Parameters(), std::exp(log_focal[0]), std::exp(log_focal[1]));
}

template <UnknownFocal kUnknown, bool kHeld>
Matrix3Parameters FocalManifold<kUnknown, kHeld>::Parameters() const {
  return WithFocals(essential.Parameters(), std::exp(log_focal[0]), std::exp(log_focal[1]));
}

template <UnknownFocal kUnknown, bool kHeld>
auto FocalManifold<kUnknown, kHeld>::Tangent() const -> TangentMatrix {
  const double focal1 = std::exp(log_focal[0]), focal2 = std::exp(log_focal[1]);
  const Eigen::Matrix<double, 9, 5> of_essential = essential.Tangent();
  TangentMatrix tangent;
  for (int i = 0; i < 5; ++i) tangent.col(i) = WithFocals(of_essential.col(i), focal1, focal2);
  if constexpr (!kHeld) {
    // f of the second image stands in the last row, that of the first in the last column.
    const Matrix3Parameters f = Parameters();
    for (int i = 0; i < 9; ++i) {
      const double row = i / 3 == 2 ? 1.0 : 0.0, column = i % 3 == 2 ? 1.0 : 0.0;
      tangent(i, kFreedom - 1) = f[i] * (kUnknown == UnknownFocal::kBoth ? row + column : row);
      if constexpr (kFocals == 2) tangent(i, 5) = f[i] * column;
    }
  }
  return tangent;
}

template <UnknownFocal kUnknown, bool kHeld>
auto FocalManifold<kUnknown, kHeld>::Retract(const Step& step) const -> FocalManifold {
  FocalManifold moved = *this;
  moved.essential = essential.Retract(step.template head<5>());
  if constexpr (!kHeld) {
    moved.log_focal[1] += step[kFreedom - 1];
    if constexpr (kUnknown != UnknownFocal::kSecond) moved.log_focal[0] += step[5];
  }
  return moved;
}

template struct FocalManifold<UnknownFocal::kBoth, false>;
template struct FocalManifold<UnknownFocal::kBoth, true>;
template struct FocalManifold<UnknownFocal::kSecond, false>;
template struct FocalManifold<UnknownFocal::kSecond, true>;
template struct FocalManifold<UnknownFocal::kEach, false>;
template struct FocalManifold<UnknownFocal::kEach, true>;

}  // namespace diffsac
