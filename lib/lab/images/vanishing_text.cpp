#include "lab/images/vanishing_text.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "diffsac/problem/coordinates.h"
#include "lab/eval/format.h"
#include "lab/images/detection.h"
#include "lab/images/exif_focal.h"
#include "lab/images/image_source.h"
#include "lab/images/json_values.h"

namespace diffsac {
namespace {

/// What is so many longer sides from the image's middle is at infinity for all that a person cares.
constexpr double kInfinity = 30.0;

std::string PointText(const VanishingImage& found, std::size_t k, int segments) {
  const VanishingPointsEstimate& estimate = found.estimate;
  std::string text = Format("  %zu  %s", k + 1, PlaceText(estimate.points[k], found.image.size).c_str());
  text += std::string(text.size() < 38 ? 38 - text.size() : 1, ' ');
  if (!estimate.directions.empty()) {
    const Eigen::Vector3d& d = estimate.directions[k];
    text += Format("direction (%7.4f, %7.4f, %7.4f)  ", d[0], d[1], d[2]);
  }
  text += Format("%4d segments", segments);
  if (!estimate.values.empty()) text += Format("  sure %.2f", estimate.values[k]);
  return text + "\n";
}

/// "1, 2 and 3".
std::string Listed(const std::vector<int>& places) {
  std::string text;
  for (std::size_t i = 0; i < places.size(); ++i)
    text += (i == 0 ? "" : i + 1 == places.size() ? " and " : ", ") + std::to_string(places[i] + 1);
  return text;
}

std::string FocalText(const VanishingImage& found) {
  const VanishingPointsEstimate& estimate = found.estimate;
  if (estimate.focal)
    return Format("focal length: %.0f px (standard deviation %.0f %%), since %s are orthogonal\n",
                  estimate.focal->focal_px, 100.0 * estimate.focal->log_sigma,
                  Listed(estimate.focal->orthogonal).c_str());
  if (!estimate.K) return "focal length: not determined: no two vanishing points show it\n";
  return Format("focal length: %.0f px, %s\n", (*estimate.K)(0, 0), found.exif ? "by EXIF data" : "as given");
}

std::string HorizonText(const VanishingImage& found) {
  if (!found.estimate.horizon) return "horizon: not determined\n";
  const Horizon& horizon = *found.estimate.horizon;
  const double tilt = horizon.TiltDeg(), pitch = horizon.PitchDeg();
  std::string text = Format("horizon: row %.1f in the middle, ", horizon.RowAt(0.5 * (found.image.size.width - 1)));
  if (std::abs(tilt) < 0.005)
    text += "level";
  else
    text += Format("%s to the right by %.2f degrees", tilt < 0.0 ? "rises" : "falls", std::abs(tilt));
  if (found.estimate.K)
    text += Format("; the camera looks %s by %.1f degrees", pitch < 0.0 ? "down" : "up", std::abs(pitch));
  return text + "\n";
}

Json VectorJson(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

/// Numbered from 1, as the assignment is.
Json PlacesJson(std::vector<int> places) {
  for (int& place : places) ++place;
  return places;
}

Json FocalJson(const VanishingFocal& focal) {
  return {{"px", focal.focal_px}, {"log_sigma", focal.log_sigma}, {"orthogonal", PlacesJson(focal.orthogonal)}};
}

Json HorizonJson(const Horizon& horizon, bool calibrated) {
  return {{"line", VectorJson(horizon.line)},
          {"tilt_deg", horizon.TiltDeg()},
          {"pitch_deg", calibrated ? Json(horizon.PitchDeg()) : Json(nullptr)},
          {"up", calibrated ? VectorJson(horizon.up) : Json(nullptr)},
          {"vertical", horizon.vertical >= 0 ? Json(horizon.vertical + 1) : Json(nullptr)},
          {"horizontal", PlacesJson(horizon.horizontal)}};
}

Json PointsJson(const VanishingPointsEstimate& estimate) {
  const std::vector<int> counts = SegmentCounts(estimate);
  Json points = Json::array();
  for (std::size_t k = 0; k < estimate.points.size(); ++k)
    points.push_back({{"point", VectorJson(estimate.points[k])},
                      {"direction", estimate.directions.empty() ? Json(nullptr) : VectorJson(estimate.directions[k])},
                      {"value", estimate.values.empty() ? Json(nullptr) : Json(estimate.values[k])},
                      {"segments", counts[k]}});
  return points;
}

std::string CameraSource(const VanishingImage& found) {
  if (found.estimate.focal) return "vanishing_points";
  if (!found.estimate.K) return "none";
  return found.exif ? "exif" : "given";
}

Json ImageJson(const VanishingImage& found) {
  const VanishingPointsEstimate& estimate = found.estimate;
  return {{"image", found.image.name},
          {"size", {found.image.size.width, found.image.size.height}},
          {"segments", found.image.segments.rows()},
          {"status", std::string(ToString(estimate.status))},
          {"vanishing_points", PointsJson(estimate)},
          {"assignment", estimate.assignment},
          {"K", OptionalJson(estimate.K, MatrixJson)},
          {"K_from", CameraSource(found)},
          {"focal", OptionalJson(estimate.focal, FocalJson)},
          {"horizon",
           OptionalJson(estimate.horizon, [&](const Horizon& h) { return HorizonJson(h, estimate.K.has_value()); })},
          {"ms", {{"segments", found.ms_segments}, {"estimate", estimate.stats.ms_total}}}};
}

}  // namespace

std::string PlaceText(const Eigen::Vector3d& point, const ImageSize& size) {
  const Eigen::Vector2d middle(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const Eigen::Vector2d away = point.head<2>() - point[2] * middle;
  if (away.norm() < kInfinity * std::max(size.width, size.height) * std::abs(point[2]))
    return Format("(%.1f, %.1f)", point[0] / point[2], point[1] / point[2]);
  Eigen::Vector2d along = away.normalized();
  // Of a line's two directions the one to the right, or down; no "-0.00".
  constexpr double kShown = 0.005;
  if (std::abs(along[0]) < kShown) along[0] = 0.0;
  if (std::abs(along[1]) < kShown) along[1] = 0.0;
  const bool back = along[0] < 0.0 || (along[0] == 0.0 && along[1] < 0.0);
  along = (back ? -1.0 : 1.0) * along + Eigen::Vector2d::Zero();
  return Format("at infinity along (%.2f, %.2f)", along[0], along[1]);
}

std::vector<int> SegmentCounts(const VanishingPointsEstimate& estimate) {
  std::vector<int> counts(estimate.points.size(), 0);
  for (const std::int32_t label : estimate.assignment)
    if (label > 0) ++counts[static_cast<std::size_t>(label - 1)];
  return counts;
}

std::string VanishingText(const VanishingImage& found) {
  const VanishingPointsEstimate& estimate = found.estimate;
  const ImageSize& size = found.image.size;
  std::string text = found.image.name + Format(": %d x %d pixels, %d segments\n", size.width, size.height,
                                               static_cast<int>(found.image.segments.rows()));
  const std::string times =
      Format("milliseconds: segments %.3g, estimate %.3g\n", found.ms_segments, estimate.stats.ms_total);
  if (!estimate.ok()) return text + "no vanishing points: " + std::string(ToString(estimate.status)) + "\n" + times;
  const std::vector<int> counts = SegmentCounts(estimate);
  const char* order = estimate.values.empty() ? "that of most length" : "the surest";
  text += estimate.points.size() == 1 ? "one vanishing point\n"
                                      : Format("%zu vanishing points, %s first\n", estimate.points.size(), order);
  for (std::size_t k = 0; k < estimate.points.size(); ++k) text += PointText(found, k, counts[k]);
  return text + FocalText(found) + HorizonText(found) + times;
}

std::string SegmentsText(const VanishingImage& found) {
  std::string text;
  const PointMatrix& segments = found.image.segments;
  const auto& assignment = found.estimate.assignment;
  for (Eigen::Index i = 0; i < segments.rows(); ++i) {
    const int label = assignment.empty() ? 0 : assignment[static_cast<std::size_t>(i)];
    text += Format("%.9g %.9g %.9g %.9g %d\n", segments(i, 0), segments(i, 1), segments(i, 2), segments(i, 3), label);
  }
  return text;
}

std::string VanishingJson(const std::vector<VanishingImage>& images) {
  Json all = Json::array();
  for (const VanishingImage& found : images) all.push_back(ImageJson(found));
  return JsonText({{"images", all}});
}

ImageSegments DetectSegments(const cv::Mat& gray, int max_image_size) {
  ImageSegments image;
  image.size = {gray.cols, gray.rows};
  const double scale =
      max_image_size > 0 ? std::max(1.0, double(std::max(gray.cols, gray.rows)) / max_image_size) : 1.0;
  cv::Mat reduced = gray;
  if (scale > 1.0) cv::resize(gray, reduced, {}, 1.0 / scale, 1.0 / scale, cv::INTER_AREA);
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector()->detect(reduced, found);
  std::stable_sort(found.begin(), found.end(), [](const cv::Vec4f& a, const cv::Vec4f& b) {
    return std::hypot(a[2] - a[0], a[3] - a[1]) > std::hypot(b[2] - b[0], b[3] - b[1]);
  });
  image.segments.resize(static_cast<Eigen::Index>(found.size()), 4);
  // Pixel centres have whole coordinates, in the file as in the reduced image.
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int k = 0; k < 4; ++k) image.segments(static_cast<Eigen::Index>(i), k) = scale * (found[i][k] + 0.5) - 0.5;
  return image;
}

Photograph ReadPhotograph(const std::string& path, const GivenCalibration& calibration) {
  const bool focal_alone = calibration.file.empty() && calibration.focal > 0.0 && calibration.center.empty();
  const std::optional<LensCamera> camera = focal_alone ? std::nullopt : CameraOf(calibration);
  Photograph photograph;
  photograph.gray = ReadGrayImage(path, camera ? Orientation::kAsStored : Orientation::kUpright);
  const ImageSize size{photograph.gray.cols, photograph.gray.rows};
  if (camera) {
    photograph.K = camera->K;
  } else if (focal_alone) {
    photograph.K = CentredCamera(calibration.focal, size);
  } else if (const auto focal = ExifFocalPx(path, size)) {
    photograph.K = CentredCamera(*focal, size);
    photograph.exif = true;
  }
  return photograph;
}

}  // namespace diffsac
