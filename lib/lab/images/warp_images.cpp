#include "lab/images/warp_images.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/files/files.h"
#include "lab/images/detection.h"
#include "lab/images/image_source.h"
#include "lab/images/pictures.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr double kFocal = 1.2, kRollDeg = 25.0, kShift = 0.1;
constexpr double kNearest = 0.6, kFarthest = 1.6;

double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

cv::Mat ReadReduced(const std::string& path, int max_size) {
  cv::Mat image = ReadGrayImage(path, Orientation::kUpright);
  const int longer = std::max(image.cols, image.rows);
  if (max_size == 0 || longer <= max_size) return image;
  const double factor = static_cast<double>(max_size) / longer;
  cv::Mat reduced;
  cv::resize(image, reduced, {}, factor, factor, cv::INTER_AREA);
  return reduced;
}

// Grey noise of the size of `like`.
cv::Mat Noise(const cv::Mat& like, double mean, double sigma, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat noise(like.size(), CV_32F);
  rng.fill(noise, cv::RNG::NORMAL, mean, sigma);
  return noise;
}

cv::Mat OutsideOf(const cv::Mat& image, const Rng& rng) {
  return Noise(image, 128.0, 30.0, rng.Fork("outside").Seed());
}

// In other light, with a little blur and noise.
cv::Mat Relit(const cv::Mat& warped, const cv::Mat& mask, Rng rng) {
  cv::Mat result;
  warped.convertTo(result, CV_32F, rng.Uniform(0.7, 1.3), rng.Uniform(-20.0, 20.0));
  cv::GaussianBlur(result, result, {}, rng.Uniform(0.3, 1.2));
  OutsideOf(warped, rng).copyTo(result, mask == 0);
  result += Noise(warped, 0.0, rng.Uniform(1.0, 6.0), rng.Fork("noise").Seed());
  result.convertTo(result, CV_8U);
  return result;
}

cv::Mat Photographed(cv::Mat warped, const cv::Mat& mask, const Rng& rng) {
  cv::Mat outside;
  OutsideOf(warped, rng).convertTo(outside, CV_8U);
  outside.copyTo(warped, mask == 0);
  return Photograph(warped, rng);
}

cv::Mat Seen(const cv::Mat& image, const Eigen::Matrix3d& view, bool photograph, const Rng& rng) {
  cv::Mat matrix, warped, mask;
  cv::eigen2cv(view, matrix);
  cv::warpPerspective(image, warped, matrix, image.size(), cv::INTER_AREA);
  cv::warpPerspective(cv::Mat(image.size(), CV_8U, cv::Scalar(255)), mask, matrix, image.size(), cv::INTER_NEAREST);
  return photograph ? Photographed(warped, mask, rng) : Relit(warped, mask, rng);
}

void WriteMatrix(const fs::path& path, const Eigen::Matrix3d& matrix) {
  std::ostringstream text;
  text.precision(12);
  text << matrix << "\n";
  WriteFileAtomically(path.string(), text.str());
}

}  // namespace

Eigen::Matrix3d RandomView(int width, int height, double least_tilt, double greatest_tilt, Rng rng) {
  const double f = kFocal * std::max(width, height);
  Eigen::Matrix3d K;
  K << f, 0, 0.5 * width, 0, f, 0.5 * height, 0, 0, 1;
  // The plane is Z = 0, at unit distance from the first camera.
  const double side = rng.Uniform(0.0, 2.0 * std::numbers::pi);
  const double tilt = Radians(rng.Uniform(least_tilt, greatest_tilt));
  const double distance = kNearest * std::pow(kFarthest / kNearest, rng.Uniform());
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(Radians(kRollDeg) * rng.Normal(), Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(side), std::sin(side), 0.0)))
                                .toRotationMatrix();
  const Eigen::Vector3d centre(rng.Uniform(-kShift, kShift) * width / f, rng.Uniform(-kShift, kShift) * height / f,
                               0.0);
  Eigen::Matrix3d plane;
  plane << R.leftCols<2>(), Eigen::Vector3d(0, 0, distance) - R * centre;
  return K * plane * K.inverse();
}

bool WarpImages(const WarpRequest& request, const std::atomic<bool>& stop) {
  const std::vector<std::string> paths = ListImages(request.input);
  const auto size = static_cast<std::int64_t>(paths.size());
  const std::int64_t count = request.images > 0 ? std::min<std::int64_t>(request.images, size) : size;
  Progress progress("warp", count);
  int unreadable = 0;
  for (std::int64_t i = 0; i < count && !stop; ++i) {
    const std::string& path = paths[i * size / count];
    cv::Mat image;
    progress.Advance();
    try {
      image = ReadReduced(path, request.max_image_size);
    } catch (const Error& error) {
      LogWarning(std::string("left out: ") + error.what());
      ++unreadable;
      continue;
    }
    const fs::path folder = fs::path(request.output) / ImageName(path);
    MakeWritableFolder(folder.string());
    WritePicture(image, (folder / "1.png").string());
    for (int view = 2; view <= request.views + 1; ++view) {
      const Rng rng = Rng(request.seed).Fork(ImageName(path), static_cast<std::uint64_t>(view));
      const Eigen::Matrix3d homography =
          RandomView(image.cols, image.rows, request.least_tilt, request.greatest_tilt, rng.Fork("view"));
      WritePicture(Seen(image, homography, request.photograph, rng.Fork("light")),
                   (folder / (std::to_string(view) + ".png")).string());
      WriteMatrix(folder / ("H_1_" + std::to_string(view)), homography);
    }
  }
  if (unreadable == count) throw Error(request.input + ": none of its images can be read");
  return !stop;
}

namespace {

constexpr double kGamma = 2.2;
constexpr double kDarkest = -1.2, kBrightest = 0.6;  // stops
constexpr double kDarkestCorner = 0.4;
constexpr double kSharpest = 0.4, kLeastSharp = 1.5;  // σ, pixels
constexpr double kLongestMotion = 8.0;                // pixels
constexpr double kFewestElectrons = 300.0, kMostElectrons = 10000.0;
constexpr double kMostReadNoise = 0.01;  // of the full range
constexpr double kLeastContrast = 0.8, kMostContrast = 1.25;
constexpr double kLeastQuality = 25.0, kMostQuality = 90.0;

void Expose(cv::Mat* light, Rng rng) {
  const double gain = std::exp2(rng.Uniform(kDarkest, kBrightest)), falloff = rng.Uniform(0.0, kDarkestCorner);
  const double cx = 0.5 * (light->cols - 1), cy = 0.5 * (light->rows - 1), corner = cx * cx + cy * cy + 1.0;
  for (int y = 0; y < light->rows; ++y)
    for (int x = 0; x < light->cols; ++x)
      light->at<float>(y, x) *=
          static_cast<float>(gain * (1.0 - falloff * ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / corner));
}

// The mean of samples along a straight path whose middle is the pixel, so that nothing moves.
cv::Mat MotionKernel(double length, double angle) {
  constexpr int kSamples = 64;
  const int radius = static_cast<int>(std::ceil(0.5 * length)) + 1;
  cv::Mat kernel = cv::Mat::zeros(2 * radius + 1, 2 * radius + 1, CV_32F);
  for (int i = 0; i < kSamples; ++i) {
    const double along = length * ((i + 0.5) / kSamples - 0.5);
    const double x = radius + along * std::cos(angle), y = radius + along * std::sin(angle);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const double right_share = x - left, low_share = y - top;
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx)
        kernel.at<float>(top + dy, left + dx) += static_cast<float>((dx == 1 ? right_share : 1.0 - right_share) *
                                                                    (dy == 1 ? low_share : 1.0 - low_share) / kSamples);
  }
  return kernel;
}

void Blur(cv::Mat* light, Rng rng) {
  cv::GaussianBlur(*light, *light, {}, rng.Uniform(kSharpest, kLeastSharp));
  const double length = rng.Uniform(0.0, kLongestMotion), angle = rng.Uniform(0.0, std::numbers::pi);
  if (rng.Uniform() < 0.5) cv::filter2D(*light, *light, -1, MotionKernel(length, angle));
}

void AddSensorNoise(cv::Mat* light, Rng rng) {
  const double electrons = kFewestElectrons * std::pow(kMostElectrons / kFewestElectrons, rng.Uniform());
  const double read = rng.Uniform(0.0, kMostReadNoise);
  cv::RNG normal(rng.Fork("pixels").Seed());
  for (int y = 0; y < light->rows; ++y)
    for (int x = 0; x < light->cols; ++x) {
      float& value = light->at<float>(y, x);
      value += static_cast<float>(normal.gaussian(std::sqrt(std::max(0.0f, value) / electrons + read * read)));
    }
}

// From light to grey values that a file holds.
cv::Mat Develop(const cv::Mat& light, Rng rng) {
  cv::Mat tone, grey;
  cv::pow(cv::max(cv::min(light, 1.0), 0.0), rng.Uniform(kLeastContrast, kMostContrast) / kGamma, tone);
  tone.convertTo(grey, CV_8U, 255.0);
  std::vector<unsigned char> file;
  cv::imencode(".jpg", grey, file,
               {cv::IMWRITE_JPEG_QUALITY, static_cast<int>(rng.Uniform(kLeastQuality, kMostQuality))});
  return cv::imdecode(file, cv::IMREAD_GRAYSCALE);
}

}  // namespace

cv::Mat Photograph(const cv::Mat& view, const Rng& rng) {
  cv::Mat light;
  view.convertTo(light, CV_32F, 1.0 / 255.0);
  cv::pow(light, kGamma, light);
  Expose(&light, rng.Fork("exposure"));
  Blur(&light, rng.Fork("blur"));
  AddSensorNoise(&light, rng.Fork("sensor"));
  return Develop(light, rng.Fork("file"));
}

}  // namespace diffsac
