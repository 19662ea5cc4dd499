#pragma once

#include <utility>

#include "diffsac/diffsac.h"

namespace diffsac::testing {

// Correspondences of diffsac.h with memory of their own, for tests that change them. As an argument they are views of
// it; a temporary one gives its memory away.

struct OwnedMatches {
  Eigen::Matrix<double, Eigen::Dynamic, 2> points1 = {}, points2 = {};
  Eigen::VectorXd snn_ratio = {};
  ImageSize size1 = {}, size2 = {};
  Eigen::Matrix<double, Eigen::Dynamic, 2> scale_rotation_changes = {};
  Eigen::VectorXd scores = {};
  operator Matches() const& { return {points1, points2, snn_ratio, size1, size2, scale_rotation_changes, scores}; }
  operator Matches() && {
    return {
        std::move(points1), std::move(points2), std::move(snn_ratio), size1, size2, std::move(scale_rotation_changes),
        std::move(scores)};
  }
};

struct OwnedMatches2D3D {
  Eigen::Matrix<double, Eigen::Dynamic, 3> points3d = {};
  Eigen::Matrix<double, Eigen::Dynamic, 2> points2d = {};
  Eigen::VectorXd snn_ratio = {}, scores = {};
  operator Matches2D3D() const& { return {points3d, points2d, snn_ratio, scores}; }
  operator Matches2D3D() && {
    return {std::move(points3d), std::move(points2d), std::move(snn_ratio), std::move(scores)};
  }
};

struct OwnedMatches3D3D {
  Eigen::Matrix<double, Eigen::Dynamic, 3> points1 = {}, points2 = {};
  Eigen::VectorXd snn_ratio = {}, scores = {};
  operator Matches3D3D() const& { return {points1, points2, snn_ratio, scores}; }
  operator Matches3D3D() && {
    return {std::move(points1), std::move(points2), std::move(snn_ratio), std::move(scores)};
  }
};

template <class Result>
bool MayBeChance(const Result& result) {
  return result.verdict == Verdict::kUnsupported;
}

template <class Result>
bool MayBeWrong(const Result& result) {
  return MayBeChance(result) || result.verdict == Verdict::kUnreliable;
}

}  // namespace diffsac::testing
