#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "lab/eval/format.h"
#include "lab/images/pictures.h"
#include "lab/images/vanishing_text.h"

namespace diffsac {
namespace {

constexpr double kMostPixels = 1600.0;
const cv::Scalar kOther(150, 150, 150), kBlack(0, 0, 0), kWhite(255, 255, 255);

/// Blue, green and red that colour-blind readers can tell apart (Okabe and Ito, "Color universal design", 2008). They
/// repeat after six.
cv::Scalar ColourOf(std::size_t index) {
  static const cv::Scalar kColours[] = {{178, 114, 0},   {0, 94, 213},  {115, 158, 0},
                                        {167, 121, 204}, {0, 159, 230}, {233, 180, 86}};
  return kColours[index % std::size(kColours)];
}

/// The image, reduced, and where its pixels are in it.
class Canvas {
 public:
  explicit Canvas(const cv::Mat& gray) {
    scale_ = std::min(1.0, kMostPixels / std::max(gray.cols, gray.rows));
    cv::Mat reduced = gray;
    if (scale_ < 1.0) cv::resize(gray, reduced, {}, scale_, scale_, cv::INTER_AREA);
    image_ = LightImage(reduced);
  }

  cv::Point2d At(double x, double y) const { return {(x + 0.5) * scale_ - 0.5, (y + 0.5) * scale_ - 0.5}; }
  bool Shows(const cv::Point2d& point) const {
    return point.x >= 0 && point.y >= 0 && point.x < image_.cols && point.y < image_.rows;
  }

  void Line(const cv::Point2d& from, const cv::Point2d& to, const cv::Scalar& colour, int width) {
    // Sixteenths of a pixel: segments are placed more finely than that.
    constexpr int kBits = 4;
    const auto fine = [](const cv::Point2d& p) {
      return cv::Point(cvRound(p.x * (1 << kBits)), cvRound(p.y * (1 << kBits)));
    };
    cv::line(image_, fine(from), fine(to), colour, width, cv::LINE_AA, kBits);
  }

  /// Dashes, black on white, so that they show on anything.
  void Dashes(const cv::Point2d& from, const cv::Point2d& to) {
    constexpr double kDash = 16.0;
    const cv::Point2d along = to - from;
    const int count = std::max(1, cvRound(cv::norm(along) / kDash));
    Line(from, to, kWhite, 3);
    for (int i = 0; i < count; i += 2)
      Line(from + along * (double(i) / count), from + along * (double(i + 1) / count), kBlack, 2);
  }

  void Ring(const cv::Point2d& centre, const cv::Scalar& colour) {
    const cv::Point at(cvRound(centre.x), cvRound(centre.y));
    for (const auto& [size, width] : {std::pair{9, 5}, {9, 3}})
      cv::circle(image_, at, size, width == 5 ? kWhite : colour, width, cv::LINE_AA);
  }

  cv::Mat& image() { return image_; }
  double width() const { return image_.cols / scale_; }

 private:
  double scale_ = 1.0;
  cv::Mat image_;
};

void DrawSegments(const PointMatrix& segments, const std::vector<std::int32_t>& assignment, bool assigned,
                  const std::vector<cv::Scalar>& colours, Canvas* canvas) {
  for (Eigen::Index i = 0; i < segments.rows(); ++i) {
    const int label = assignment.empty() ? 0 : assignment[static_cast<std::size_t>(i)];
    if ((label > 0) != assigned || !segments.row(i).allFinite()) continue;
    canvas->Line(canvas->At(segments(i, 0), segments(i, 1)), canvas->At(segments(i, 2), segments(i, 3)),
                 label > 0 ? colours[static_cast<std::size_t>(label - 1)] : kOther, label > 0 ? 2 : 1);
  }
}

void DrawHorizon(const Horizon& horizon, Canvas* canvas) {
  const double width = canvas->width();
  cv::Point2d left = canvas->At(0.0, horizon.RowAt(0.0)), right = canvas->At(width, horizon.RowAt(width));
  // Where it is above or below the picture it is not drawn.
  const double highest = std::min(left.y, right.y), lowest = std::max(left.y, right.y);
  if (lowest < 0.0 || highest > canvas->image().rows) return;
  canvas->Dashes(left, right);
}

}  // namespace

cv::Mat DrawVanishingPoints(const cv::Mat& gray, const PointMatrix& segments, const VanishingPointsEstimate& estimate) {
  Canvas canvas(gray);
  std::vector<cv::Scalar> drawn;
  std::vector<LegendEntry> entries;
  const std::vector<int> counts = SegmentCounts(estimate);
  for (std::size_t k = 0; k < estimate.points.size(); ++k) {
    drawn.push_back(ColourOf(k));
    entries.push_back({Format("%zu: %d segments", k + 1, counts[k]), drawn.back()});
    if (!estimate.values.empty()) entries.back().text += Format(", sure %.2f", estimate.values[k]);
  }
  for (const bool assigned : {false, true}) DrawSegments(segments, estimate.assignment, assigned, drawn, &canvas);
  if (estimate.horizon) {
    DrawHorizon(*estimate.horizon, &canvas);
    entries.push_back({"horizon", kBlack, true});
  }
  for (std::size_t k = 0; k < estimate.points.size(); ++k) {
    const Eigen::Vector3d& point = estimate.points[k];
    const cv::Point2d at = canvas.At(point[0] / point[2], point[1] / point[2]);
    if (canvas.Shows(at)) canvas.Ring(at, drawn[k]);
  }
  entries.push_back({"other segments", kOther});
  return WithLegend(canvas.image(), entries);
}

}  // namespace diffsac
