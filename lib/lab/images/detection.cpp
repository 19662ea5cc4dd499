#include "lab/images/detection.h"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <mutex>
#include <numbers>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/paths.h"
#include "lab/config/process.h"
#include "lab/files/files.h"
#include "lab/images/network_keypoints.h"

namespace diffsac {
namespace {

// OpenCV's default between two copies of the image.
constexpr double kOrbScaleStep = 1.2f;
// ORB has no word for all.
constexpr int kAllOfOrb = 200000;

// Returns original pixels per reduced pixel.
double Reduce(int max_size, cv::Mat* image) {
  const int longer = std::max(image->cols, image->rows);
  if (max_size == 0 || longer <= max_size) return 1.0;
  const double scale = static_cast<double>(longer) / max_size;
  cv::Mat reduced;
  cv::resize(*image, reduced,
             cv::Size(std::max(1, static_cast<int>(std::lround(image->cols / scale))),
                      std::max(1, static_cast<int>(std::lround(image->rows / scale)))),
             0, 0, cv::INTER_AREA);
  *image = reduced;
  return scale;
}

/// Whether a JPEG ends before its picture does: OpenCV fills the rest with grey and says nothing. The picture is the
/// last scan (0xFFDA), up to the end marker (0xFFD9); a thumbnail before it has markers of its own.
bool IsCutJpeg(const std::string& bytes) {
  if (!bytes.starts_with("\xFF\xD8")) return false;
  const std::size_t scan = bytes.rfind("\xFF\xDA");
  return scan == std::string::npos || bytes.find("\xFF\xD9", scan) == std::string::npos;
}

}  // namespace

void RequireImage(const std::string& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) throw Error(path + ": no such file");
  if (!cv::haveImageReader(path)) throw Error(path + ": not an image, or truncated");
}

namespace {

/// A whole image of 16 bits whose values use fewer (10 or 12, as cameras have them) would be all but black in 8.
cv::Mat BytesOfWords(const cv::Mat& image, const std::string& path, int flags) {
  double most = 0.0, range = 256.0;
  cv::minMaxLoc(image, nullptr, &most);
  while (range <= most) range *= 2.0;
  if (range > 32768.0) return cv::imread(path, flags & ~cv::IMREAD_ANYDEPTH);
  cv::Mat bytes;
  image.convertTo(bytes, CV_8U, 256.0 / range);
  return bytes;
}

/// Of values of any range: those in [0, 1] or [0, 255] as light, others from the least to the greatest.
cv::Mat BytesOfNumbers(const cv::Mat& image, const std::string& path) {
  cv::Mat numbers, finite, bytes;
  image.convertTo(numbers, CV_32F);
  finite = (numbers >= std::numeric_limits<float>::lowest()) & (numbers <= std::numeric_limits<float>::max());
  double low = 0.0, high = 0.0;
  cv::minMaxLoc(numbers, &low, &high, nullptr, nullptr, finite);
  if (cv::countNonZero(finite) == 0) throw Error(path + ": no value of it is finite");
  if (low >= 0.0 && high <= 255.0) {
    low = 0.0;
    high = high <= 1.0 ? 1.0 : 255.0;
  }
  numbers.setTo(low, ~finite);
  const double scale = high > low ? 255.0 / (high - low) : 0.0;
  numbers.convertTo(bytes, CV_8U, scale, -low * scale);
  return bytes;
}

}  // namespace

cv::Mat ReadGrayImage(const std::string& path, Orientation orientation) {
  RequireImage(path);
  // First, for libjpeg would say a line of its own about it.
  if (IsCutJpeg(ReadFile(path))) throw Error(path + ": not an image, or truncated");
  cv::Mat image;
  try {
    const int flags = cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH |
                      (orientation == Orientation::kAsStored ? cv::IMREAD_IGNORE_ORIENTATION : 0);
    image = cv::imread(path, flags);
    if (image.depth() == CV_16U)
      image = BytesOfWords(image, path, flags);
    else if (!image.empty() && image.depth() != CV_8U)
      image = BytesOfNumbers(image, path);
  } catch (const cv::Exception& e) {
    throw Error(path + ": cannot be read as an image: " + e.err);
  }
  if (image.empty()) throw Error(path + ": not an image, or truncated");
  return image;
}

cv::Ptr<cv::Feature2D> MakeDetector(const FeatureOptions& options) {
  if (options.kind != FeatureKind::kOrb) return cv::SIFT::create(options.max_keypoints, 3, kContrastThreshold);
  return cv::ORB::create(options.max_keypoints > 0 ? options.max_keypoints : kAllOfOrb);
}

Eigen::RowVector2d Detection::Position(std::size_t i) const {
  const cv::KeyPoint& keypoint = keypoints[i];
  // ORB multiplies the coordinates of its smaller copies by their scale, which forgets that the centres of their pixels
  // lie elsewhere.
  const double moved = kind == FeatureKind::kOrb ? 0.5 * (std::pow(kOrbScaleStep, keypoint.octave) - 1.0) : 0.0;
  return {(keypoint.pt.x + moved + 0.5) * scale - 0.5, (keypoint.pt.y + moved + 0.5) * scale - 0.5};
}

Eigen::RowVector2d Detection::Frame(std::size_t i) const {
  const cv::KeyPoint& keypoint = keypoints[i];
  return {std::log(keypoint.size * scale), keypoint.angle * std::numbers::pi / 180.0};
}

namespace {

/// Larger images take SIFT's fine octaves (of the doubled image, the image and its half) from tiles of this side and a
/// margin that a keypoint of these octaves does not see beyond: they are the same as those of the whole image. Coarser
/// octaves are those of the image reduced to a quarter.
constexpr double kLargestWhole = 2.6e6;
constexpr int kTile = 1408, kMargin = 96, kCoarse = 4, kFinestCoarse = 2;

int OctaveOf(const cv::KeyPoint& keypoint) { return static_cast<std::int8_t>(keypoint.octave & 0xFF); }

void FindSift(const cv::Mat& image, cv::Feature2D& sift, Detection* found);

/// The keypoints of the fine octaves within `tile`.
void FindFine(const cv::Mat& image, const cv::Rect& tile, cv::Feature2D& sift, Detection* found) {
  const cv::Rect part = cv::Rect(tile.x - kMargin, tile.y - kMargin, kTile + 2 * kMargin, kTile + 2 * kMargin) &
                        cv::Rect({}, image.size());
  cv::Mat mask = cv::Mat::zeros(part.size(), CV_8U), raw;
  mask(tile - part.tl()).setTo(255);
  std::vector<cv::KeyPoint> keypoints;
  sift.detectAndCompute(image(part), mask, keypoints, raw);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    if (OctaveOf(keypoints[i]) >= kFinestCoarse) continue;
    found->keypoints.push_back(keypoints[i]);
    found->keypoints.back().pt += cv::Point2f(part.tl());
    found->raw.push_back(raw.row(static_cast<int>(i)));
  }
}

/// The keypoints of the other octaves.
void FindCoarse(const cv::Mat& image, cv::Feature2D& sift, Detection* found) {
  cv::Mat reduced;
  cv::resize(image(cv::Rect(0, 0, image.cols / kCoarse * kCoarse, image.rows / kCoarse * kCoarse)), reduced, {},
             1.0 / kCoarse, 1.0 / kCoarse, cv::INTER_AREA);
  Detection coarse;
  FindSift(reduced, sift, &coarse);
  // OpenCV's places are a quarter of a pixel too far right and down, whatever the pixel's size.
  constexpr float kMoved = 0.25f * (1 - kCoarse) + 0.5f * (kCoarse - 1);
  for (std::size_t i = 0; i < coarse.keypoints.size(); ++i) {
    cv::KeyPoint keypoint = coarse.keypoints[i];
    if (OctaveOf(keypoint) < 0) continue;
    keypoint.pt = kCoarse * keypoint.pt + cv::Point2f(kMoved, kMoved);
    keypoint.size *= kCoarse;
    keypoint.octave += kFinestCoarse;  // which does not leave its byte
    found->keypoints.push_back(keypoint);
    found->raw.push_back(coarse.raw.row(static_cast<int>(i)));
  }
}

void FindSift(const cv::Mat& image, cv::Feature2D& sift, Detection* found) {
  if (static_cast<double>(image.total()) <= kLargestWhole)
    return sift.detectAndCompute(image, cv::noArray(), found->keypoints, found->raw);
  const cv::Rect whole({}, image.size());
  for (int y = 0; y < image.rows; y += kTile)
    for (int x = 0; x < image.cols; x += kTile) FindFine(image, cv::Rect(x, y, kTile, kTile) & whole, sift, found);
  FindCoarse(image, sift, found);
}

/// What OpenCV's detectors take of memory at most: SIFT, whose first octave is of the doubled image, was measured.
double MemoryMib(FeatureKind kind, const cv::Mat& image) {
  const auto pixels = static_cast<double>(image.total());
  return 1e-6 * (kind == FeatureKind::kOrb ? 30.0 * pixels : 230.0 * std::min(pixels, kLargestWhole));
}

/// Memory for keypoints, of all threads: who would take more than is free waits for the others.
class KeypointMemory {
 public:
  explicit KeypointMemory(double mib, const std::string& path) : mib_(mib) {
    std::unique_lock lock(mutex_);
    if (users_ == 0) free_ = kUsable * AvailableMemoryMib();
    if (mib_ > free_ && users_ > 0 && !std::exchange(told_, true))
      LogInfo("keypoints of " + std::to_string(users_) + " images at a time: " + path + " needs " + Text(mib_) +
              " more memory, and " + Text(free_) + " are left");
    changed_.wait(lock, [&] { return mib_ <= free_ || users_ == 0; });
    if (users_ == 0) free_ = kUsable * AvailableMemoryMib();
    if (mib_ > free_)
      throw Error(path + ": its keypoints need " + Text(mib_) + " of memory, and " + Text(free_) +
                  " can be had: reduce it (max_image_size)");
    free_ -= mib_;
    ++users_;
  }
  ~KeypointMemory() {
    const std::lock_guard lock(mutex_);
    free_ += mib_;
    --users_;
    changed_.notify_all();
  }
  KeypointMemory(const KeypointMemory&) = delete;
  KeypointMemory& operator=(const KeypointMemory&) = delete;

 private:
  static std::string Text(double mib) { return std::to_string(std::lround(mib)) + " MB"; }

  static constexpr double kUsable = 0.9;  ///< Of what is free; the rest is for what stands beside the keypoints.
  static inline std::mutex mutex_;
  static inline std::condition_variable changed_;
  static inline double free_ = 0.0;
  static inline int users_ = 0;
  static inline bool told_ = false;
  double mib_;
};

void TellReduced(const std::string& path, const Detection& found, int max_size) {
  static std::once_flag once;
  std::call_once(once, [&] {
    LogInfo(path + " is " + SizeText(found.size) + ": keypoints of images are found at " + std::to_string(max_size) +
            " pixels at most (max_image_size)");
  });
}

/// The module takes no image of less than a cell of its coarsest features.
constexpr int kXFeatCell = 32;

void DetectByNetwork(const std::string& path, const FeatureOptions& options, Detection* detection) {
  Detection& found = *detection;
  if (std::min(found.image.cols, found.image.rows) < kXFeatCell) return;
  NetworkKeypoints keypoints;
  const int most = options.max_keypoints > 0 ? options.max_keypoints : std::numeric_limits<int>::max();
  const std::string wrong = NetworkKeypointsFunction()(FindModel("xfeat/model.pt"), found.image.data, found.image.cols,
                                                       found.image.rows, most, &keypoints);
  if (!wrong.empty()) throw Error(path + ": no keypoints could be found: " + wrong);
  const auto count = keypoints.scores.size();
  for (std::size_t i = 0; i < count; ++i)
    found.keypoints.emplace_back(keypoints.places[2 * i], keypoints.places[2 * i + 1], 1.0f, 0.0f, keypoints.scores[i]);
  if (count > 0) found.raw = cv::Mat(keypoints.descriptors, true).reshape(1, static_cast<int>(count));
}

}  // namespace

Detection Detect(const std::string& path, const FeatureOptions& options) {
  Detection found;
  found.image = ReadGrayImage(path);
  found.kind = options.kind;
  found.size = {found.image.cols, found.image.rows};
  found.scale = Reduce(options.max_image_size, &found.image);
  if (found.scale > 1.0) TellReduced(path, found, options.max_image_size);
  const KeypointMemory memory(MemoryMib(options.kind, found.image), path);
  if (options.kind == FeatureKind::kXFeat) {
    DetectByNetwork(path, options, &found);
    return found;
  }
  try {
    const cv::Ptr<cv::Feature2D> detector = MakeDetector(options);
    if (IsSift(options.kind))
      FindSift(found.image, *detector, &found);
    else
      detector->detectAndCompute(found.image, cv::noArray(), found.keypoints, found.raw);
  } catch (const cv::Exception& e) {
    throw Error(path + ": no keypoints could be found: " + e.err);
  }
  return found;
}

void CopyBytes(const cv::Mat& raw, int from, Eigen::Index to, ByteMatrix* bytes) {
  if (static_cast<std::size_t>(bytes->cols()) == raw.cols * raw.elemSize()) {
    std::memcpy(bytes->row(to).data(), raw.ptr(from), static_cast<std::size_t>(bytes->cols()));
    return;
  }
  for (Eigen::Index j = 0; j < bytes->cols(); ++j)
    (*bytes)(to, j) = static_cast<std::uint8_t>(raw.at<float>(from, static_cast<int>(j)));
}

namespace {

FindNetworkKeypoints Load() {
  std::vector<std::string> places;
  for (const std::string& share : ShareFolders())
    AddPlace((std::filesystem::path(share) / "../../lib/diffsac/diffsac_keypoints.so").string(), &places);
  const std::string file = FirstPlace("xfeat needs LibTorch, and of an installation with the lab the module", places);
  void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* function = module == nullptr ? nullptr : dlsym(module, "DiffsacFindNetworkKeypoints");
  if (function == nullptr) throw Error(file + ": cannot be loaded: " + dlerror());
  return reinterpret_cast<FindNetworkKeypoints>(function);
}

}  // namespace

FindNetworkKeypoints NetworkKeypointsFunction() {
  static const FindNetworkKeypoints function = Load();
  return function;
}

}  // namespace diffsac
