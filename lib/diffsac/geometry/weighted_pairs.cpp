#include "diffsac/geometry/weighted_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

constexpr int kLanes = kEquationLanes;
constexpr int kFirst = 6;

/// What normalisation asks of one column.
struct ColumnSums {
  double mean;
  double largest;
};

DIFFSAC_VECTOR_CLONES
void SumColumn(const double* values, const double* weights, int count, ColumnSums* out) {
  double sum[kLanes] = {}, largest[kLanes] = {};
  for (int begin = 0; begin < count; begin += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const double value = values[begin + l], size = std::abs(value);
      sum[l] += weights[begin + l] * value;
      largest[l] = size > largest[l] ? size : largest[l];
    }
  }
  *out = {TotalOf(sum), *std::max_element(largest, largest + kLanes)};
}

/// Moves the column's mean to 0 and returns the weighted sum of squares.
DIFFSAC_VECTOR_CLONES
double Centre(double* values, const double* weights, int count, double mean) {
  double sum[kLanes] = {};
  for (int begin = 0; begin < count; begin += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const double value = values[begin + l] - mean;
      values[begin + l] = value;
      sum[l] += weights[begin + l] * (value * value);
    }
  }
  return TotalOf(sum);
}

/// The products of the second image's coordinates, each times the weight.
struct EpipolarTerms {
  static constexpr int kSecond = 6;
  static void Second(double x, double y, double w, int i, double (&out)[kSecond][kEquationBlock]) {
    out[0][i] = w * x * x;
    out[1][i] = w * x * y;
    out[2][i] = w * x;
    out[3][i] = w * y * y;
    out[4][i] = w * y;
    out[5][i] = w;
  }
};

struct TransferTerms {
  static constexpr int kSecond = 4;
  static void Second(double x, double y, double w, int i, double (&out)[kSecond][kEquationBlock]) {
    out[0][i] = w;
    out[1][i] = w * x;
    out[2][i] = w * y;
    out[3][i] = w * (x * x + y * y);
  }
};

template <class Terms>
struct MomentSums {
  EquationLanes lanes[Terms::kSecond][kFirst] = {};
};

/// A block of products at a time, so that a row of sums stays in registers while the block goes by.
template <class Terms>
[[gnu::always_inline]] inline void AddMoments(const double* const* columns, double scale1, double scale2, int count,
                                              MomentSums<Terms>* sums) {
  alignas(sizeof(EquationLanes)) EquationColumn first[kFirst], second[Terms::kSecond];
  for (int begin = 0; begin < count; begin += kEquationBlock) {
    const int size = std::min(kEquationBlock, count - begin);
    for (int i = 0; i < size; ++i) {
      const double x = scale1 * columns[0][begin + i], y = scale1 * columns[1][begin + i];
      first[0][i] = x * x;
      first[1][i] = x * y;
      first[2][i] = x;
      first[3][i] = y * y;
      first[4][i] = y;
      first[5][i] = 1.0;
      Terms::Second(scale2 * columns[2][begin + i], scale2 * columns[3][begin + i], columns[4][begin + i], i, second);
    }
    for (int j = 0; j < Terms::kSecond; ++j) AddProducts<kFirst>(second[j], first, size, sums->lanes[j]);
  }
}

DIFFSAC_VECTOR_CLONES
void AddEpipolar(const double* const* columns, double scale1, double scale2, int count,
                 MomentSums<EpipolarTerms>* sums) {
  AddMoments(columns, scale1, scale2, count, sums);
}

DIFFSAC_VECTOR_CLONES
void AddTransfer(const double* const* columns, double scale1, double scale2, int count,
                 MomentSums<TransferTerms>* sums) {
  AddMoments(columns, scale1, scale2, count, sums);
}

template <class Terms>
Eigen::Matrix<double, Terms::kSecond, kFirst> Totals(const MomentSums<Terms>& sums) {
  Eigen::Matrix<double, Terms::kSecond, kFirst> result;
  for (int j = 0; j < Terms::kSecond; ++j)
    for (int k = 0; k < kFirst; ++k) result(j, k) = TotalOf(sums.lanes[j][k]);
  return result;
}

}  // namespace

bool WeightedPairs::Collect(const PointMatrix& points, const Eigen::VectorXd& weights) {
  if (points.cols() != 4 || weights.size() != points.rows()) return false;
  std::vector<int> rows(points.rows());
  int count = 0;
  bool valid = true;
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
    // Without a branch: whether a point counts cannot be foreseen.
    rows[count] = i;
    count += weights[i] > 0.0 ? 1 : 0;
    valid &= weights[i] >= 0.0 && weights[i] <= std::numeric_limits<double>::max();
  }
  if (!valid) return false;
  positive_ = count;
  columns_.resize(count + kLanes, Eigen::NoChange);
  double* columns[5];
  for (int j = 0; j < 5; ++j) columns[j] = columns_.col(j).data();
  for (int i = 0; i < count; ++i) {
    const double* p = points.data() + 4 * static_cast<Eigen::Index>(rows[i]);
    for (int j = 0; j < 4; ++j) columns[j][i] = p[j];
    columns[4][i] = weights[rows[i]];
  }
  count_ = (count + kLanes - 1) / kLanes * kLanes;
  for (int i = count; i < count_; ++i) {
    for (int j = 0; j < 4; ++j) columns[j][i] = columns[j][count - 1];
    columns[4][i] = 0.0;
  }
  return true;
}

bool WeightedPairs::Gather(const PointMatrix& points, const Eigen::VectorXd& weights, int min_positive) {
  return Collect(points, weights) && positive_ >= min_positive && Normalize();
}

bool WeightedPairs::Normalize() {
  double* columns[5];
  for (int j = 0; j < 5; ++j) columns[j] = columns_.col(j).data();
  double totals[kLanes] = {};
  for (int i = 0; i < count_; ++i) totals[i % kLanes] += columns[4][i];
  const double total = TotalOf(totals);
  if (!(total > 0.0) || !std::isfinite(total)) return false;
  double largest[2] = {}, square[2] = {}, mean[4];
  for (int j = 0; j < 4; ++j) {
    ColumnSums sums;
    SumColumn(columns[j], columns[4], count_, &sums);
    mean[j] = sums.mean / total;
    largest[j / 2] = std::max(largest[j / 2], sums.largest);
    square[j / 2] += Centre(columns[j], columns[4], count_, mean[j]);
  }
  return MakeNormalization(mean[0], mean[1], square[0] / total, largest[0], &normalization_.first) &&
         MakeNormalization(mean[2], mean[3], square[1] / total, largest[1], &normalization_.second);
}

Eigen::Matrix<double, 6, 6> WeightedPairs::EpipolarMoments() const {
  const double* columns[5];
  for (int j = 0; j < 5; ++j) columns[j] = columns_.col(j).data();
  MomentSums<EpipolarTerms> sums;
  AddEpipolar(columns, normalization_.first.scale, normalization_.second.scale, count_, &sums);
  return Totals(sums);
}

Eigen::Matrix<double, 4, 6> WeightedPairs::TransferMoments() const {
  const double* columns[5];
  for (int j = 0; j < 5; ++j) columns[j] = columns_.col(j).data();
  MomentSums<TransferTerms> sums;
  AddTransfer(columns, normalization_.first.scale, normalization_.second.scale, count_, &sums);
  return Totals(sums);
}

}  // namespace diffsac
