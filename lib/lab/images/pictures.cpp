#include "lab/images/pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>
#include <vector>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/eval/format.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/images/detection.h"
#include "lab/images/vanishing_text.h"

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
