#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "diffsac/core/status.h"
#include "lab/images/detection.h"

namespace diffsac {
namespace {

constexpr double kNearPx = 1.0;
// Where an image has no keypoint of its own that could tell.
constexpr float kUsualDiameter = 8.0f;

// Keypoints by the pixel they lie in.
class KeypointGrid {
 public:
  explicit KeypointGrid(const Detection& found) : found_(found) {
    for (std::size_t i = 0; i < found.keypoints.size(); ++i) cells_[CellOf(found.Position(i))].push_back(i);
  }

  // The nearest within kNearPx, the strongest of equally near ones; -1 without.
  int Nearest(const Eigen::RowVector2d& place) const {
    const Cell cell = CellOf(place);
    std::tuple<double, float, std::size_t> best{kNearPx, 0.0f, 0};
    int index = -1;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = cells_.find({cell.first + dx, cell.second + dy});
        if (found == cells_.end()) continue;
        for (std::size_t i : found->second) {
          const double distance = (found_.Position(i) - place).norm();
          const std::tuple candidate{distance, -found_.keypoints[i].response, i};
          if (distance > kNearPx || (index >= 0 && !(candidate < best))) continue;
          best = candidate;
          index = static_cast<int>(i);
        }
      }
    }
    return index;
  }

 private:
  using Cell = std::pair<int, int>;
  static Cell CellOf(const Eigen::RowVector2d& place) {
    return {static_cast<int>(std::floor(place.x() / kNearPx)), static_cast<int>(std::floor(place.y() / kNearPx))};
  }

  const Detection& found_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

float MedianDiameter(const std::vector<cv::KeyPoint>& keypoints) {
  if (keypoints.empty()) return kUsualDiameter;
  std::vector<float> sizes(keypoints.size());
  std::transform(keypoints.begin(), keypoints.end(), sizes.begin(), [](const cv::KeyPoint& k) { return k.size; });
  std::nth_element(sizes.begin(), sizes.begin() + sizes.size() / 2, sizes.end());
  return sizes[sizes.size() / 2];
}

// Describes places without a keypoint. The row of each is its class_id, since the order need not stay.
void DescribeRest(const std::string& path, const Detection& found, const FeatureOptions& options,
                  std::vector<cv::KeyPoint>* rest, ByteMatrix* bytes) {
  if (rest->empty()) return;
  cv::Mat raw;
  try {
    MakeDetector(options)->compute(found.image, *rest, raw);
  } catch (const cv::Exception& e) {
    throw Error(path + ": its matches could not be described: " + e.err);
  }
  for (std::size_t i = 0; i < rest->size(); ++i) CopyBytes(raw, static_cast<int>(i), (*rest)[i].class_id, bytes);
}

}  // namespace

PlacedDescriptors DescribePlaces(const std::string& path, const PointMatrix& places, const FeatureOptions& options) {
  options.Check();
  if (!IsSift(options.kind)) throw Error("places are described by sift or rootsift, not by " + ToString(options.kind));
  if (!places.allFinite()) throw Error(path + ": a matched coordinate in it is not finite");
  FeatureOptions all = options;
  all.max_keypoints = 0;
  const Detection found = Detect(path, all);
  const KeypointGrid grid(found);
  const float diameter = MedianDiameter(found.keypoints);
  PlacedDescriptors placed{found.size, ByteMatrix::Zero(places.rows(), 128), 0};
  std::vector<cv::KeyPoint> rest;
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const Eigen::RowVector2d place = places.row(i);
    const int nearest = grid.Nearest(place);
    if (nearest >= 0) {
      CopyBytes(found.raw, nearest, i, &placed.bytes);
      placed.num_found += 1;
      continue;
    }
    const Eigen::RowVector2d reduced = (place.array() + 0.5) / found.scale - 0.5;
    rest.emplace_back(static_cast<float>(reduced.x()), static_cast<float>(reduced.y()), diameter, 0.0f, 0.0f, 0,
                      static_cast<int>(i));
  }
  DescribeRest(path, found, all, &rest, &placed.bytes);
  return placed;
}

}  // namespace diffsac
