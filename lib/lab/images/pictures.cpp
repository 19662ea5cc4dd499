#include "lab/images/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/images/detection.h"
#include "lab/images/image_source.h"

namespace diffsac {

cv::Mat LightImage(const cv::Mat& gray) {
  cv::Mat light, color;
  gray.convertTo(light, CV_8U, 0.7, 60.0);
  cv::cvtColor(light, color, cv::COLOR_GRAY2BGR);
  return color;
}

void CheckPictureName(const std::string& path) {
  if (std::filesystem::path(path).extension().empty() || !cv::haveImageWriter(path))
    throw Error(path + ": expected a name that ends in .png, .jpg or another format of pictures");
}

void WritePicture(const cv::Mat& image, const std::string& path) {
  CheckPictureName(path);
  std::vector<unsigned char> encoded;
  cv::imencode(std::filesystem::path(path).extension().string(), image, encoded);
  const auto folder = std::filesystem::path(path).parent_path();
  if (folder.filename() == kPictureFolder) std::filesystem::create_directories(folder);
  WriteFileAtomically(path, {reinterpret_cast<const char*>(encoded.data()), encoded.size()});
}

namespace {

namespace fs = std::filesystem;

constexpr int kGap = 8, kLegendHeight = 36;
constexpr std::size_t kMaxLines = 60;
constexpr double kMaxWidth = 2400.0, kMaxHeight = 1400.0;
// Told apart by colour-blind readers too (Okabe and Ito). Blue, green, red.
const cv::Scalar kInlier(115, 200, 0), kOutlier(0, 110, 240), kWhite(255, 255, 255);

enum class Kind { kInlier, kOutlier };

const cv::Scalar& ColorOf(Kind kind) { return kind == Kind::kInlier ? kInlier : kOutlier; }

// The two images on one canvas, and where points of either are on it.
class Canvas {
 public:
  Canvas(const cv::Mat& first, const cv::Mat& second) {
    const int width = first.cols + second.cols, height = std::max(first.rows, second.rows);
    scale_ = std::min({1.0, (kMaxWidth - kGap) / width, (kMaxHeight - kLegendHeight) / height});
    const cv::Mat small1 = Reduced(first), small2 = Reduced(second);
    offset_ = small1.cols + kGap;
    image_ = cv::Mat(std::max(small1.rows, small2.rows) + kLegendHeight, offset_ + small2.cols, CV_8UC3, kWhite);
    small1.copyTo(image_(cv::Rect(0, 0, small1.cols, small1.rows)));
    small2.copyTo(image_(cv::Rect(offset_, 0, small2.cols, small2.rows)));
    image_(cv::Rect(small1.cols, 0, kGap, image_.rows - kLegendHeight)).setTo(cv::Scalar(90, 90, 90));
  }

  void Point(const PointMatrix& points, Eigen::Index i, const cv::Scalar& color) {
    for (int image : {0, 1}) cv::circle(image_, Place(points, i, image), 2, color, cv::FILLED, cv::LINE_AA);
  }
  void Line(const PointMatrix& points, Eigen::Index i, const cv::Scalar& color) {
    cv::line(image_, Place(points, i, 0), Place(points, i, 1), color, 1, cv::LINE_AA);
  }
  // One after the other from the left.
  void Legend(const std::string& text, const cv::Scalar& color) {
    constexpr double kFontScale = 0.5;
    const int y = image_.rows - kLegendHeight / 2;
    cv::circle(image_, {legend_x_ + 6, y}, 5, color, cv::FILLED, cv::LINE_AA);
    cv::putText(image_, text, {legend_x_ + 18, y + 5}, cv::FONT_HERSHEY_SIMPLEX, kFontScale, {0, 0, 0}, 1, cv::LINE_AA);
    int baseline = 0;
    legend_x_ += 42 + cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kFontScale, 1, &baseline).width;
  }
  const cv::Mat& image() const { return image_; }

 private:
  cv::Mat Reduced(const cv::Mat& image) const {
    if (scale_ == 1.0) return image;
    cv::Mat reduced;
    const auto side = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels * scale_))); };
    cv::resize(image, reduced, {side(image.cols), side(image.rows)}, 0, 0, cv::INTER_AREA);
    return reduced;
  }
  cv::Point Place(const PointMatrix& points, Eigen::Index i, int image) const {
    // Far outside, a coordinate need not fit into what OpenCV draws with.
    const auto at = [&](double value) {
      return static_cast<int>(std::lround(std::clamp((value + 0.5) * scale_ - 0.5, -1e4, 1e4)));
    };
    return {at(points(i, 2 * image)) + (image == 0 ? 0 : offset_), at(points(i, 2 * image + 1))};
  }

  double scale_ = 1.0;
  int offset_ = 0, legend_x_ = 8;
  cv::Mat image_;
};

void Draw(const PointMatrix& points, const std::vector<Kind>& kinds, Kind kind, std::size_t most_lines,
          Canvas* canvas) {
  std::vector<Eigen::Index> chosen;
  for (std::size_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == kind && points.row(static_cast<Eigen::Index>(i)).allFinite())
      chosen.push_back(static_cast<Eigen::Index>(i));
  const std::size_t lines = std::min(chosen.size(), most_lines);
  for (std::size_t i = 0; i < lines; ++i) canvas->Line(points, chosen[i * chosen.size() / lines], ColorOf(kind));
  for (Eigen::Index i : chosen) canvas->Point(points, i, ColorOf(kind));
}

}  // namespace

void DrawInliers(const std::string& image1, const std::string& image2, const PointMatrix& points,
                 const std::vector<std::uint8_t>& inliers, const std::string& caption, const std::string& path) {
  std::vector<Kind> kinds(static_cast<std::size_t>(points.rows()), Kind::kOutlier);
  for (std::size_t i = 0; i < std::min(kinds.size(), inliers.size()); ++i)
    if (inliers[i] != 0) kinds[i] = Kind::kInlier;
  const auto count = static_cast<std::size_t>(std::count(kinds.begin(), kinds.end(), Kind::kInlier));
  Canvas canvas(LightImage(ReadGrayImage(image1)), LightImage(ReadGrayImage(image2)));
  Draw(points, kinds, Kind::kOutlier, 0, &canvas);
  Draw(points, kinds, Kind::kInlier, kMaxLines, &canvas);
  const std::string lines = count > kMaxLines ? " (lines: " + std::to_string(kMaxLines) + " of them)" : "";
  canvas.Legend(std::to_string(count) + " inliers" + lines, kInlier);
  canvas.Legend(std::to_string(kinds.size() - count) + " other matches", kOutlier);
  canvas.Legend(caption, kWhite);
  WritePicture(canvas.image(), path);
}

}  // namespace diffsac
