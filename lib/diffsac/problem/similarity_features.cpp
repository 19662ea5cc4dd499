#include "diffsac/problem/similarity_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "diffsac/geometry/vector_clones.h"
#include "diffsac/problem/neighbor_lanes.h"
#include "diffsac/problem/turn_scale_histogram.h"

namespace diffsac {
namespace {

constexpr int kNeighbors = kEight;
// Keeps small steps from deciding.
constexpr float kLeastStep = 0.02f, kMostError = 100.0f, kSupportError = 0.3f, kLeastError = 1e-3f;
constexpr float kMostScaleDifference = 2.0f;
constexpr float kPi = std::numbers::pi_v<float>;
// More than any keypoints differ in size: single precision holds the products.
constexpr double kMostLogScale = 6.0;

// Matches, a column for each value, in order of the matches or of the good ones.
struct Columns {
  PlanePoints first, second;
  std::vector<float> log_scale, turn, along, across, scale;  // along + i across = scale · exp(i turn)
};

Columns ColumnsOf(const PointMatrix& coordinates, const PointMatrix& scale_rotation_changes) {
  const auto count = static_cast<std::size_t>(coordinates.rows());
  Columns columns{ImagePlane(coordinates, 0), ImagePlane(coordinates, 1), {}, {}, {}, {}, {}};
  for (auto* values : {&columns.log_scale, &columns.turn, &columns.along, &columns.across, &columns.scale})
    values->resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double log_scale = std::clamp(scale_rotation_changes(row, 0), -kMostLogScale, kMostLogScale);
    const double turn = scale_rotation_changes(row, 1), scale = std::exp(log_scale);
    columns.log_scale[i] = static_cast<float>(log_scale);
    columns.turn[i] = static_cast<float>(turn);
    columns.scale[i] = static_cast<float>(scale);
    columns.along[i] = static_cast<float>(scale * std::cos(turn));
    columns.across[i] = static_cast<float>(scale * std::sin(turn));
  }
  return columns;
}

// kLanes matches, or one neighbour of each.
struct Lanes {
  LanePlaces x1, y1, x2, y2;
  LaneRow log_scale, turn, along, across, scale;

  void Set(int lane, const Columns& from, std::size_t i) {
    x1[lane] = from.first.x[i], y1[lane] = from.first.y[i];
    x2[lane] = from.second.x[i], y2[lane] = from.second.y[i];
    log_scale[lane] = from.log_scale[i], turn[lane] = from.turn[i], scale[lane] = from.scale[i];
    along[lane] = from.along[i], across[lane] = from.across[i];
  }
};

// What the neighbours of one image say of kLanes matches.
struct Verdict {
  LaneRow support, error, scale_difference, turn_difference;
};

DIFFSAC_VECTOR_CLONES
void Judge(const Lanes& match, const Lanes* __restrict neighbors, Verdict* __restrict verdict) {
  LaneRow error[kNeighbors], scales[kNeighbors], turns[kNeighbors];
  for (int l = 0; l < kLanes; ++l) verdict->support[l] = 0.0f;
  for (int k = 0; k < kNeighbors; ++k) {
    const Lanes& other = neighbors[k];
#pragma GCC unroll 1  // so that lanes become vectors
    for (int l = 0; l < kLanes; ++l) {
      const float ax = LaneStep(match.x1[l], other.x1[l]), ay = LaneStep(match.y1[l], other.y1[l]);
      const float bx = LaneStep(match.x2[l], other.x2[l]), by = LaneStep(match.y2[l], other.y2[l]);
      const float length1 = std::sqrt(ax * ax + ay * ay) + kLeastStep;
      const float length2 = std::sqrt(bx * bx + by * by) + kLeastStep;
      const float px = match.along[l] * ax - match.across[l] * ay - bx;
      const float py = match.across[l] * ax + match.along[l] * ay - by;
      const float qx = other.along[l] * ax - other.across[l] * ay - bx;
      const float qy = other.across[l] * ax + other.along[l] * ay - by;
      const float scaled = match.scale[l] * length1, other_scaled = other.scale[l] * length1;
      const float own = std::sqrt(px * px + py * py) / (scaled < length2 ? scaled : length2);
      const float its = std::sqrt(qx * qx + qy * qy) / (other_scaled < length2 ? other_scaled : length2);
      const float larger = own > its ? own : its;
      const float bounded = larger < kMostError ? larger : kMostError;
      const float share = bounded / kSupportError;
      error[k][l] = bounded;
      verdict->support[l] += 1.0f / (1.0f + share * share);
      scales[k][l] = std::fabs(other.log_scale[l] - match.log_scale[l]);
      const float turn = std::fabs(other.turn[l] - match.turn[l]);
      turns[k][l] = turn > kPi ? std::fabs(2.0f * kPi - turn) : turn;
    }
  }
  SortMiddle(error);
  SortMiddle(scales);
  SortMiddle(turns);
  for (int l = 0; l < kLanes; ++l) {
    verdict->error[l] = error[3][l];
    verdict->scale_difference[l] = 0.5f * (scales[3][l] + scales[4][l]);
    verdict->turn_difference[l] = 0.5f * (turns[3][l] + turns[4][l]);
  }
}

Verdict JudgeBy(const std::vector<EightNearest>& nearest, const GoodNeighbors& around, const Columns& columns,
                const std::array<int, kLanes>& matches) {
  Lanes match, neighbors[kNeighbors];
  for (int l = 0; l < kLanes; ++l) {
    match.Set(l, columns, matches[l]);
    for (int k = 0; k < kNeighbors; ++k) neighbors[k].Set(l, columns, around.good[nearest[matches[l]][k]]);
  }
  Verdict verdict;
  Judge(match, neighbors, &verdict);
  return verdict;
}

// How far the values of one image go.
double Extent(const PointMatrix& points, int image) {
  const auto range = [&](int column) { return points.col(column).maxCoeff() - points.col(column).minCoeff(); };
  return range(2 * image) + range(2 * image + 1);
}

}  // namespace

PointMatrix InCoordinates(const PointMatrix& scale_rotation_changes, const PointMatrix& points,
                          const PointMatrix& coordinates) {
  PointMatrix scaled = scale_rotation_changes;
  if (scale_rotation_changes.rows() == 0) return scaled;
  // The logarithm of the pixels in one unit of the coordinates.
  const auto log_unit = [&](int image) {
    const double pixels = Extent(points, image), units = Extent(coordinates, image);
    return pixels > 0.0 && units > 0.0 ? std::log(pixels) - std::log(units) : 0.0;
  };
  scaled.col(0).array() += log_unit(0) - log_unit(1);
  return scaled;
}

Eigen::Matrix<float, Eigen::Dynamic, kSimilarityColumns> SimilarityFeatures(const PointMatrix& coordinates,
                                                                            const PointMatrix& scale_rotation_changes,
                                                                            const GoodNeighbors& around) {
  const auto count = static_cast<int>(coordinates.rows());
  Eigen::Matrix<float, Eigen::Dynamic, kSimilarityColumns> values(count, kSimilarityColumns);
  values.setZero();
  if (count <= kNeighbors || scale_rotation_changes.rows() != count) return values;
  const Columns columns = ColumnsOf(coordinates, scale_rotation_changes);
  TurnScaleHistogram histogram;
  for (const std::int32_t row : around.good) histogram.Add(columns.log_scale[row], columns.turn[row]);
  histogram.Smooth();
  for (int first = 0; first < count; first += kLanes) {
    std::array<int, kLanes> matches;
    for (int l = 0; l < kLanes; ++l) matches[l] = std::min(first + l, count - 1);
    const Verdict a = JudgeBy(around.nearest[0], around, columns, matches);
    const Verdict b = JudgeBy(around.nearest[1], around, columns, matches);
    for (int l = 0; l < kLanes && first + l < count; ++l) {
      const int i = first + l;
      const float d = histogram.MeanOfOthers(columns.log_scale[i], columns.turn[i], around.own[i] >= 0);
      const float scale_difference = 0.5f * (a.scale_difference[l] + b.scale_difference[l]);
      values(i, 0) = std::log1p(a.support[l] + b.support[l]) - 1.0f;
      values(i, 1) = (2.0f + std::log(0.5f * (a.error[l] + b.error[l]) + kLeastError)) / 3.0f;
      values(i, 2) = std::min(scale_difference, kMostScaleDifference);
      values(i, 3) = 0.5f * (a.turn_difference[l] + b.turn_difference[l]);
      values(i, 4) = (2.3f + std::log(d + 0.01f)) / 1.2f;
      values(i, 5) = 1.0f;
    }
  }
  return values;
}

}  // namespace diffsac
