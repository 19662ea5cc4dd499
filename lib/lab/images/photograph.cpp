#include "lab/images/photograph.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace diffsac {
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
