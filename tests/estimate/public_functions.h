#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/cloud_scene.h"
#include "geometry/segments.h"

namespace diffsac::testing {

/// What any function of diffsac/diffsac.h answers.
struct Answer {
  Status status = Status::kNoModel;
  std::vector<Eigen::MatrixXd> models;  ///< One, or several; none without success.
  std::vector<int> labels;              ///< The mask, or the assignment.
  Diagnostics diagnostics = {};
  bool is_certain() const { return status == Status::kOk && !(diagnostics.log10_nfa > 0.0); }
};

/// A function of diffsac/diffsac.h with data that it is for. Rows are those of Problem::points.
struct PublicFunction {
  std::string name;
  int minimal = 0;         ///< γ.
  bool has_ratios = true;  ///< Whether it takes them.
  PointMatrix points;      ///< Right ones with little noise, every fourth wrong by far.
  std::vector<std::string> cameras = {};
  /// ratios: empty for none; K: of all images.
  std::function<Answer(const PointMatrix&, const Eigen::VectorXd& ratios, const Eigen::Matrix3d& K)> call = {};

  Answer operator()(const PointMatrix& rows, const Eigen::VectorXd& ratios = {}) const;
};

inline const Eigen::Matrix3d kCamera{{600.0, 0.0, 320.0}, {0.0, 600.0, 240.0}, {0.0, 0.0, 1.0}};

inline Answer PublicFunction::operator()(const PointMatrix& rows, const Eigen::VectorXd& ratios) const {
  return call(rows, ratios, kCamera);
}

template <class Result>
Answer AnswerOf(const Result& result) {
  Answer answer;
  answer.status = result.status;
  if constexpr (requires { result.model; }) {
    if (result.ok()) answer.models.push_back(result.model);
    answer.labels.assign(result.inliers.begin(), result.inliers.end());
    answer.diagnostics = result.diagnostics;
  } else {
    answer.diagnostics.num_nonfinite = result.num_nonfinite;
    answer.diagnostics.num_duplicates = result.num_duplicates;
    answer.labels.assign(result.assignment.begin(), result.assignment.end());
    if constexpr (requires { result.points; }) {
      answer.models.assign(result.points.begin(), result.points.end());
    } else {
      answer.models.assign(result.models.begin(), result.models.end());
    }
  }
  return answer;
}

/// Scene points before two cameras, `planes`: on so many planes, 0: anywhere. X Y Z u1 v1 u2 v2.
inline PointMatrix SceneRows(int count, int planes, std::uint64_t seed) {
  Rng rng = Rng(seed).Fork("scene");
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.15, Eigen::Vector3d(0.2, 1.0, 0.1).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(1.0, 0.1, 0.2);
  PointMatrix rows(count, 7);
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d X(rng.Uniform(-2.0, 2.0), rng.Uniform(-1.5, 1.5), rng.Uniform(4.0, 8.0));
    if (planes > 0) X[2] = i % planes == 0 ? 5.0 + 0.4 * X[0] : 7.0 - 0.6 * X[1];
    const auto seen = [&](const Eigen::Vector3d& x) -> Eigen::RowVector2d {
      return (kCamera * x).hnormalized().transpose() +
             Eigen::RowVector2d(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2));
    };
    rows.row(i) << X.transpose(), seen(X), seen(turn * X + shift);
    if (i % 4 == 3) rows.row(i).tail<2>() << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 480.0);
  }
  return rows;
}

/// Points of `instances` lines or planes, every fourth of none.
inline PointMatrix FlatRows(int count, int dimension, int instances, std::uint64_t seed) {
  Rng rng = Rng(seed).Fork("flat");
  PointMatrix rows(count, dimension);
  for (int i = 0; i < count; ++i) {
    for (int c = 0; c < dimension; ++c) rows(i, c) = rng.Uniform(0.0, 10.0);
    if (i % 4 == 3) continue;
    const double across = i % instances == 0 ? 0.4 * rows(i, 0) + 1.0 : 9.0 - 0.7 * rows(i, 0);
    rows(i, dimension - 1) = across + rng.Uniform(-0.02, 0.02);
  }
  return rows;
}

inline OwnedMatches MatchesOf(const PointMatrix& rows, const Eigen::VectorXd& ratios) {
  return {rows.leftCols(2), rows.rightCols(2), ratios, {640, 480}, {640, 480}};
}

/// All functions of the public header.
inline std::vector<PublicFunction> PublicFunctions() {
  using Ratios = Eigen::VectorXd;
  using K3 = Eigen::Matrix3d;
  const PointMatrix general = SceneRows(200, 0, 1), flat = SceneRows(200, 1, 2), walls = SceneRows(240, 2, 3);
  const PointMatrix room = RoomSegments(0.7, 0.15, 0.05, 30, 0.2, 20, Rng(2)).segments;
  const PointOptions within{.max_residual = 0.1};
  VanishingPointOptions vanishing;
  vanishing.size = {640, 480};
  const auto scene = [](const PointMatrix& rows, const Ratios& ratios) -> OwnedMatches2D3D {
    return {rows.leftCols(3), rows.rightCols(2), ratios};
  };
  const PointMatrix matches = general.rightCols(4);
  PointMatrix poses(200, 5);
  poses << general.leftCols(3), general.rightCols(2);
  std::vector<PublicFunction> all;
  const auto add = [&](const std::string& name, int minimal, bool has_ratios, const PointMatrix& points,
                       std::vector<std::string> cameras, auto call) {
    all.push_back({name, minimal, has_ratios, points, std::move(cameras),
                   [call](const PointMatrix& p, const Ratios& r, const K3& K) { return AnswerOf(call(p, r, K)); }});
  };
  for (const bool network : {true, false}) {
    ImageOptions options;
    options.guidance = network ? Guidance::kNetwork : Guidance::kNone;
    const std::string with = network ? "" : " without a network";
    add("EstimateFundamental" + with, 7, true, matches, {}, [=](const PointMatrix& p, const Ratios& r, const K3&) {
      return EstimateFundamental(MatchesOf(p, r), options);
    });
    add("EstimateEssential" + with, 5, true, matches, {"K1", "K2"},
        [=](const PointMatrix& p, const Ratios& r, const K3& K) {
          return EstimateEssential(MatchesOf(p, r), {K, K}, options);
        });
    add("EstimateHomography" + with, 4, true, flat.rightCols(4), {},
        [=](const PointMatrix& p, const Ratios& r, const K3&) { return EstimateHomography(MatchesOf(p, r), options); });
    vanishing.guidance = network ? Guidance::kNetwork : Guidance::kNone;
    add("EstimateVanishingPoints" + with, 2, false, room, {"K"}, [=](const PointMatrix& p, const Ratios&, const K3& K) {
      VanishingPointOptions calibrated = vanishing;
      calibrated.K = K;
      return EstimateVanishingPoints(p, calibrated);
    });
    add("EstimateVanishingPoints of an unknown camera" + with, 2, false, room, {},
        [=](const PointMatrix& p, const Ratios&, const K3&) { return EstimateVanishingPoints(p, vanishing); });
  }
  add("EstimateSharedFocal", 6, true, matches, {},
      [](const PointMatrix& p, const Ratios& r, const K3&) { return EstimateSharedFocal(MatchesOf(p, r)); });
  add("EstimateOneFocal", 6, true, matches, {"K1"},
      [](const PointMatrix& p, const Ratios& r, const K3& K) { return EstimateOneFocal(MatchesOf(p, r), K); });
  add("EstimateAbsolutePose", 3, true, poses, {"K"},
      [=](const PointMatrix& p, const Ratios& r, const K3& K) { return EstimateAbsolutePose(scene(p, r), K); });
  const auto clouds = [](const PointMatrix& rows, const Ratios& ratios) -> OwnedMatches3D3D {
    return {rows.leftCols(3), rows.rightCols(3), ratios};
  };
  PointMatrix cloud = MakeCloudScene(200, 0.25, 0.01, Rng(6)).points,
              larger = MakeCloudScene(200, 0.25, 0.02, Rng(7), 2.0).points;
  for (PointMatrix* rows : {&cloud, &larger}) {
    // Every fourth wrong.
    const PointMatrix ordered = *rows;
    for (int i = 0; i < 200; ++i) rows->row(i) = ordered.row(i % 4 == 3 ? i / 4 : 50 + i - (i + 1) / 4);
  }
  add("EstimateRigidMotion", 3, true, cloud, {}, [=](const PointMatrix& p, const Ratios& r, const K3&) {
    return EstimateRigidMotion(clouds(p, r), RegistrationOptions{.max_residual = 0.05});
  });
  add("EstimateSimilarity", 3, true, larger, {}, [=](const PointMatrix& p, const Ratios& r, const K3&) {
    return EstimateSimilarity(clouds(p, r), RegistrationOptions{.max_residual = 0.1});
  });
  add("EstimateLine", 2, false, FlatRows(100, 2, 1, 1), {},
      [=](const PointMatrix& p, const Ratios&, const K3&) { return EstimateLine(p, within); });
  add("EstimatePlane", 3, false, FlatRows(100, 3, 1, 2), {},
      [=](const PointMatrix& p, const Ratios&, const K3&) { return EstimatePlane(p, within); });
  add("EstimateMultipleFundamentals", 7, true, matches, {},
      [](const PointMatrix& p, const Ratios& r, const K3&) { return EstimateMultipleFundamentals(MatchesOf(p, r)); });
  add("EstimateMultipleEssentials", 5, true, matches, {"K1", "K2"},
      [](const PointMatrix& p, const Ratios& r, const K3& K) {
        return EstimateMultipleEssentials(MatchesOf(p, r), {K, K});
      });
  add("EstimateMultipleHomographies", 4, true, walls.rightCols(4), {},
      [](const PointMatrix& p, const Ratios& r, const K3&) { return EstimateMultipleHomographies(MatchesOf(p, r)); });
  add("EstimateMultipleAbsolutePoses", 3, true, poses, {"K"}, [=](const PointMatrix& p, const Ratios& r, const K3& K) {
    return EstimateMultipleAbsolutePoses(scene(p, r), K);
  });
  add("EstimateMultipleLines", 2, false, FlatRows(120, 2, 2, 3), {},
      [=](const PointMatrix& p, const Ratios&, const K3&) { return EstimateMultipleLines(p, within); });
  add("EstimateMultiplePlanes", 3, false, FlatRows(160, 3, 2, 4), {},
      [=](const PointMatrix& p, const Ratios&, const K3&) { return EstimateMultiplePlanes(p, within); });
  return all;
}

/// Lower for right ones, mostly; in [0, 1].
inline Eigen::VectorXd RatiosFor(const PublicFunction& function, std::uint64_t seed = 5) {
  Rng rng(seed);
  Eigen::VectorXd ratios(function.has_ratios ? function.points.rows() : 0);
  for (Eigen::Index i = 0; i < ratios.size(); ++i) ratios[i] = rng.Uniform(0.3, i % 4 == 3 ? 1.0 : 0.8);
  return ratios;
}

}  // namespace diffsac::testing
