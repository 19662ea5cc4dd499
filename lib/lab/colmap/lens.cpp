#include "lab/colmap/lens.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Eigen::Vector2d;

enum Model {
  kSimplePinhole,
  kPinhole,
  kSimpleRadial,
  kRadial,
  kOpenCv,
  kOpenCvFisheye,
  kFullOpenCv,
  kFov,
  kSimpleRadialFisheye,
  kRadialFisheye,
  kThinPrismFisheye
};

struct ModelInfo {
  const char* name;
  int focal_lengths;
  int extra;  // parameters behind focal lengths and centre
};

// By COLMAP's numbers.
constexpr ModelInfo kModels[] = {{"SIMPLE_PINHOLE", 1, 0},
                                 {"PINHOLE", 2, 0},
                                 {"SIMPLE_RADIAL", 1, 1},
                                 {"RADIAL", 1, 2},
                                 {"OPENCV", 2, 4},
                                 {"OPENCV_FISHEYE", 2, 4},
                                 {"FULL_OPENCV", 2, 8},
                                 {"FOV", 2, 1},
                                 {"SIMPLE_RADIAL_FISHEYE", 1, 1},
                                 {"RADIAL_FISHEYE", 1, 2},
                                 {"THIN_PRISM_FISHEYE", 2, 8}};

const ModelInfo* InfoOf(int model) {
  return model >= 0 && model < static_cast<int>(std::size(kModels)) ? &kModels[model] : nullptr;
}

// COLMAP's pixels begin at the corner of the first one, ours at its centre.
constexpr double kCentrePx = 0.5;

// What p1 and p2 (Brown 1971) add.
Vector2d Tangential(const Vector2d& p, double p1, double p2) {
  const double r2 = p.squaredNorm(), xy = p.x() * p.y();
  return {2.0 * p1 * xy + p2 * (r2 + 2.0 * p.x() * p.x()), 2.0 * p2 * xy + p1 * (r2 + 2.0 * p.y() * p.y())};
}

// The point at the ray's angle in place of its tangent.
Vector2d Equidistant(const Vector2d& p) {
  const double r = p.norm();
  return r > 1e-12 ? Vector2d(p * (std::atan(r) / r)) : p;
}

// θ (1 + k1 θ² + k2 θ⁴ + ...) along the point's direction (Kannala and Brandt 2006).
Vector2d Fisheye(const Vector2d& p, const double* k, int count) {
  const Vector2d angle = Equidistant(p);
  const double theta2 = angle.squaredNorm();
  double factor = 0.0;
  for (int i = count - 1; i >= 0; --i) factor = (factor + k[i]) * theta2;
  return angle * (1.0 + factor);
}

// Devernay and Faugeras 2001.
Vector2d FieldOfView(const Vector2d& p, double omega) {
  const double r = p.norm(), slope = 2.0 * std::tan(omega / 2.0);
  if (std::abs(omega) < 1e-6) return p;
  return p * (r > 1e-9 ? std::atan(r * slope) / (r * omega) : slope / omega);
}

Vector2d FullOpenCv(const Vector2d& p, const double* e) {
  const double r2 = p.squaredNorm(), r4 = r2 * r2, r6 = r4 * r2;
  const double radial = (1.0 + e[0] * r2 + e[1] * r4 + e[4] * r6) / (1.0 + e[5] * r2 + e[6] * r4 + e[7] * r6);
  return p * radial + Tangential(p, e[2], e[3]);
}

// k1 k2 p1 p2 k3 k4 sx1 sy1 on equidistant points (Weng, Cohen and Herniou 1992).
Vector2d ThinPrism(const Vector2d& point, const double* e) {
  const Vector2d p = Equidistant(point);
  const double r2 = p.squaredNorm();
  const double radial = r2 * (e[0] + r2 * (e[1] + r2 * (e[4] + r2 * e[5])));
  return p * (1.0 + radial) + Tangential(p, e[2], e[3]) + Vector2d(e[6], e[7]) * r2;
}

bool IsFisheye(int model) {
  return model == kOpenCvFisheye || model == kSimpleRadialFisheye || model == kRadialFisheye ||
         model == kThinPrismFisheye;
}

}  // namespace

std::optional<std::string> ColmapModelName(int model) {
  const ModelInfo* info = InfoOf(model);
  return info == nullptr ? std::nullopt : std::optional<std::string>(info->name);
}

std::optional<int> ColmapModelNumber(std::string_view name) {
  for (int model = 0; InfoOf(model) != nullptr; ++model)
    if (InfoOf(model)->name == name) return model;
  return std::nullopt;
}

int ColmapParameterCount(int model) {
  const ModelInfo* info = InfoOf(model);
  return info == nullptr ? 0 : info->focal_lengths + 2 + info->extra;
}

ColmapLens::ColmapLens(const ColmapCamera& camera, const std::string& place) : model_(camera.model) {
  const ModelInfo* info = InfoOf(camera.model);
  if (info == nullptr)
    throw Error(place + ": unknown camera model " + std::to_string(camera.model) + " (COLMAP 3.8 has 0 to 10)");
  const std::vector<double>& p = camera.parameters;
  const auto expected = static_cast<std::size_t>(ColmapParameterCount(camera.model));
  if (p.size() != expected)
    throw Error(place + ": expected " + std::to_string(expected) + " parameters for " + info->name + ", found " +
                std::to_string(p.size()));
  const bool finite = std::all_of(p.begin(), p.end(), [](double value) { return std::isfinite(value); });
  if (!finite || !(p[0] > 0.0) || (info->focal_lengths == 2 && !(p[1] > 0.0)))
    throw Error(place + ": expected finite parameters and positive focal lengths");
  const double* centre = p.data() + info->focal_lengths;
  K_ << p[0], 0.0, centre[0] - kCentrePx, 0.0, p[info->focal_lengths - 1], centre[1] - kCentrePx, 0.0, 0.0, 1.0;
  std::copy(centre + 2, centre + 2 + info->extra, extra_);
  straight_ = !IsFisheye(model_) && std::all_of(extra_, extra_ + 8, [](double value) { return value == 0.0; });
}

Vector2d ColmapLens::DistortNormalized(const Vector2d& p) const {
  const double* e = extra_;
  const double r2 = p.squaredNorm();
  switch (model_) {
    case kSimpleRadial:
    case kRadial:
      return p * (1.0 + r2 * (e[0] + r2 * e[1]));
    case kOpenCv:
      return p * (1.0 + r2 * (e[0] + r2 * e[1])) + Tangential(p, e[2], e[3]);
    case kFullOpenCv:
      return FullOpenCv(p, e);
    case kFov:
      return FieldOfView(p, e[0]);
    case kOpenCvFisheye:
    case kSimpleRadialFisheye:
    case kRadialFisheye:
      return Fisheye(p, e, 4);
    case kThinPrismFisheye:
      return ThinPrism(p, e);
    default:
      return p;
  }
}

Vector2d ColmapLens::Distort(const Vector2d& pixel) const {
  if (straight_) return pixel;
  const Vector2d point = (K_.inverse() * pixel.homogeneous()).hnormalized();
  return (K_ * DistortNormalized(point).homogeneous()).hnormalized();
}

std::optional<Vector2d> ColmapLens::Undistort(const Vector2d& pixel) const {
  if (straight_) return pixel;
  constexpr double kStep = 1e-6, kDone = 1e-10;
  const Vector2d seen = (K_.inverse() * pixel.homogeneous()).hnormalized();
  // Newton's method, with differences for derivatives.
  Vector2d point = seen;
  for (int i = 0; i < 100; ++i) {
    const Vector2d residual = DistortNormalized(point) - seen;
    Eigen::Matrix2d jacobian;
    for (int c = 0; c < 2; ++c) {
      const Vector2d step = kStep * Vector2d::Unit(c);
      jacobian.col(c) = (DistortNormalized(point + step) - DistortNormalized(point - step)) / (2.0 * kStep);
    }
    // Where the lens folds the image over, there is no way back.
    if (!(jacobian.determinant() > 0.0)) return std::nullopt;
    point -= jacobian.inverse() * residual;
    // That was one step more than it takes.
    if (residual.norm() < kDone) return (K_ * point.homogeneous()).hnormalized();
  }
  return std::nullopt;
}

Vector2d LensCamera::Undistort(const Vector2d& pixel) const {
  return lens ? lens->Undistort(pixel).value_or(Vector2d::Constant(std::nan(""))) : pixel;
}

LensCamera CameraOfColmap(const ColmapCamera& camera, const std::string& place) {
  const ColmapLens lens(camera, place);
  return {lens.K(), camera.size, lens, camera};
}

}  // namespace diffsac
