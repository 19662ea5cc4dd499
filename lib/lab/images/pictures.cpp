#include "lab/images/pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/images/detection.h"

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

cv::Mat WithLegend(const cv::Mat& image, const std::vector<LegendEntry>& entries) {
  constexpr double kFontScale = 0.55;
  constexpr int kRow = 26, kMargin = 10;
  const cv::Scalar black(0, 0, 0), white(255, 255, 255);
  int rows = 1, x = kMargin, baseline = 0;
  std::vector<cv::Point> places;
  for (const LegendEntry& entry : entries) {
    const int width = cv::getTextSize(entry.text, cv::FONT_HERSHEY_SIMPLEX, kFontScale, 1, &baseline).width + 50;
    if (x > kMargin && x + width > image.cols) {
      ++rows;
      x = kMargin;
    }
    places.emplace_back(x, image.rows + (rows - 1) * kRow + kRow / 2 + 4);
    x += width;
  }
  cv::Mat whole(image.rows + rows * kRow + 8, image.cols, CV_8UC3, white);
  image.copyTo(whole(cv::Rect(0, 0, image.cols, image.rows)));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const cv::Point& at = places[i];
    cv::line(whole, at, at + cv::Point(entries[i].dashed ? 8 : 22, 0), entries[i].colour, 3, cv::LINE_AA);
    if (entries[i].dashed) cv::line(whole, at + cv::Point(14, 0), at + cv::Point(22, 0), black, 3, cv::LINE_AA);
    cv::putText(whole, entries[i].text, at + cv::Point(28, 5), cv::FONT_HERSHEY_SIMPLEX, kFontScale, black, 1,
                cv::LINE_AA);
  }
  return whole;
}

void DrawInliers(const std::string& image1, const std::string& image2, const PointMatrix& points,
                 const std::vector<std::uint8_t>& inliers, const std::string& caption, const std::string& path) {
  constexpr int kGap = 8;
  constexpr std::size_t kMaxLines = 60;
  constexpr double kMaxWidth = 2400.0, kMaxHeight = 1400.0;
  // Told apart by colour-blind readers too (Okabe and Ito). Blue, green, red.
  const cv::Scalar inlier(115, 200, 0), outlier(0, 110, 240), white(255, 255, 255);
  cv::Mat first = LightImage(ReadGrayImage(image1)), second = LightImage(ReadGrayImage(image2));
  const double scale =
      std::min({1.0, (kMaxWidth - kGap) / (first.cols + second.cols), kMaxHeight / std::max(first.rows, second.rows)});
  for (cv::Mat* image : {&first, &second})
    if (scale < 1.0) cv::resize(cv::Mat(*image), *image, {}, scale, scale, cv::INTER_AREA);
  const int offset = first.cols + kGap;
  cv::Mat picture(std::max(first.rows, second.rows), offset + second.cols, CV_8UC3, white);
  first.copyTo(picture(cv::Rect(0, 0, first.cols, first.rows)));
  second.copyTo(picture(cv::Rect(offset, 0, second.cols, second.rows)));
  picture(cv::Rect(first.cols, 0, kGap, picture.rows)).setTo(cv::Scalar(90, 90, 90));
  const auto place = [&](Eigen::Index i, int image) {
    // Far outside, a coordinate need not fit into what OpenCV draws with.
    const auto at = [&](double value) { return cvRound(std::clamp((value + 0.5) * scale - 0.5, -1e4, 1e4)); };
    return cv::Point(at(points(i, 2 * image)) + image * offset, at(points(i, 2 * image + 1)));
  };
  const auto draw_points = [&](Eigen::Index i, const cv::Scalar& colour) {
    for (const int image : {0, 1}) cv::circle(picture, place(i, image), 2, colour, cv::FILLED, cv::LINE_AA);
  };
  std::vector<Eigen::Index> found;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (static_cast<std::size_t>(i) < inliers.size() && inliers[static_cast<std::size_t>(i)] != 0)
      found.push_back(i);
    else if (points.row(i).allFinite())
      draw_points(i, outlier);
  }
  const std::size_t lines = std::min(found.size(), kMaxLines);
  for (std::size_t k = 0; k < lines; ++k) {
    const Eigen::Index i = found[k * found.size() / lines];
    cv::line(picture, place(i, 0), place(i, 1), inlier, 1, cv::LINE_AA);
  }
  for (const Eigen::Index i : found) draw_points(i, inlier);
  const std::string of_them = lines < found.size() ? " (lines: " + std::to_string(lines) + " of them)" : "";
  WritePicture(WithLegend(picture, {{std::to_string(found.size()) + " inliers" + of_them, inlier},
                                    {std::to_string(points.rows() - std::ssize(found)) + " other matches", outlier},
                                    {caption, white}}),
               path);
}

namespace {

constexpr int kQuality = 80;  // Of the JPEG.

// `scale`: pixels of the small image per pixel of the file.
cv::Mat WithoutDistortion(const cv::Mat& small, const LensCamera& camera, double scale) {
  cv::Mat from(small.size(), CV_32FC2);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      const Eigen::Vector2d pixel((x + 0.5) / scale - 0.5, (y + 0.5) / scale - 0.5), seen = camera.Distort(pixel);
      from.at<cv::Vec2f>(y, x) = {static_cast<float>((seen.x() + 0.5) * scale - 0.5),
                                  static_cast<float>((seen.y() + 0.5) * scale - 0.5)};
    }
  cv::Mat straight;
  cv::remap(small, straight, from, cv::noArray(), cv::INTER_LINEAR);
  return straight;
}

}  // namespace

std::string ThumbnailOf(const SourceImage& image) {
  // Matches are in the pixels of the file, whatever its orientation flag says.
  const int anything = cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION;
  cv::Mat picture = cv::imread(image.path, anything);
  if (picture.empty()) return "";
  // Of more than 8 bits it is scaled as it is for keypoints.
  if (picture.depth() != CV_8U) picture = ReadGrayImage(image.path);
  if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  const double scale = std::min(1.0, static_cast<double>(kThumbnailSize) / std::max(picture.cols, picture.rows));
  if (scale < 1.0) cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  if (image.camera && !image.camera->IsStraight()) picture = WithoutDistortion(picture, *image.camera, scale);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return {bytes.begin(), bytes.end()};
}

void WriteThumbnailsOf(const ImageSource& source, const std::vector<Example>& pairs, int threads,
                       const std::string& folder) {
  std::set<std::string> named;
  for (const Example& pair : pairs) named.insert({pair.image1, pair.image2});
  std::vector<const SourceImage*> images;
  for (const SourceImage& image : source.images)
    if (named.contains(image.name)) images.push_back(&image);
  std::vector<std::string> bytes(images.size());
  ParallelFor(static_cast<std::int64_t>(images.size()), threads,
              [&](std::int64_t i) { bytes[i] = ThumbnailOf(*images[i]); });
  WriteHdf5((std::filesystem::path(folder) / kThumbnailsFile).string(), [&](Hdf5Output& file) {
    for (std::size_t i = 0; i < images.size(); ++i)
      if (!bytes[i].empty()) file.Put(images[i]->name, bytes[i].data(), {bytes[i].size()});
  });
}

}  // namespace diffsac
