#include "lab/report/pair_pictures.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <unordered_map>

#include "lab/config/dataset_factory.h"
#include "lab/report/pair_images.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostSteps = 32767;      // Of a coordinate in 16 bits.
constexpr int kUnknownPlace = -32768;  // Of a coordinate that is not finite, or far from the image.

/// Coordinates as 16-bit integers behind the size of their step, a quarter pixel for images up to 8 191 pixels wide.
std::string PointBytes(const PointMatrix& points, int largest_side) {
  const float step = std::max(0.25F, static_cast<float>(largest_side) / kMostSteps);
  std::string bytes(sizeof(step) + 2 * static_cast<std::size_t>(points.size()), '\0');
  std::memcpy(bytes.data(), &step, sizeof(step));
  char* at = bytes.data() + sizeof(step);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (Eigen::Index d = 0; d < points.cols(); ++d, at += 2) {
      const double steps = points(i, d) / step;
      const bool known = std::abs(steps) < kMostSteps;  // False for NaN.
      const auto value = static_cast<std::int16_t>(known ? std::lround(steps) : kUnknownPlace);
      std::memcpy(at, &value, 2);
    }
  return bytes;
}

/// A bit a point, the first in the lowest.
class Mask {
 public:
  explicit Mask(std::size_t points) : bytes_((points + 7) / 8, '\0'), points_(points) {}
  void Set(std::size_t i) {
    if (i < points_) bytes_[i / 8] = static_cast<char>(static_cast<unsigned char>(bytes_[i / 8]) | (1U << (i % 8)));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t points_;
};

std::string MaskOf(const std::vector<std::uint8_t>& inliers) {
  Mask mask(inliers.size());
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i] != 0) mask.Set(i);
  return mask.bytes();
}

/// The method's inliers of one problem where they were kept.
std::optional<std::string> FoundMask(const ExperimentResults& results, const Cell& cell, const Example& example) {
  const auto points = static_cast<std::size_t>(example.problem.points.rows());
  const auto at = std::lower_bound(cell.estimates.begin(), cell.estimates.end(), example.index,
                                   [](const EstimateRecord& record, std::uint64_t i) { return record.index < i; });
  if (at != cell.estimates.end() && at->index == example.index) {
    Mask mask(points);
    for (const std::int32_t i : at->inliers) mask.Set(static_cast<std::size_t>(i));
    return mask.bytes();
  }
  for (const KeptFit& fit : results.fits) {
    const bool same =
        fit.condition == cell.condition && fit.method == cell.method && fit.example.index == example.index;
    if (same && fit.estimate.inliers.empty()) return Mask(points).bytes();
    if (same && fit.estimate.inliers.size() == points) return MaskOf(fit.estimate.inliers);
  }
  return std::nullopt;
}

/// Photographs of a page, each once, read when all pairs are known.
class Photographs {
 public:
  explicit Photographs(const ExperimentOptions& experiment) : folders_(experiment.figures.images) {}

  int Number(const std::string& scene, const std::string& folder, const std::string& image, const ImageSize& size) {
    if (image.empty()) return -1;
    const auto [at, is_new] = numbers_.try_emplace({scene, image}, static_cast<int>(wanted_.size()));
    if (is_new) wanted_.push_back({scene, folder, image, size});
    return at->second;
  }

  /// Adds those that are there. Returns how many had no room.
  std::size_t AddTo(HtmlPage* page, std::size_t most_bytes) const {
    std::size_t bytes = 0, left_out = 0;
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (bytes >= most_bytes) {
        left_out += wanted_.size() - i;
        break;
      }
      const std::string jpeg = Jpeg(wanted_[i], Longest(most_bytes));
      if (jpeg.empty()) continue;
      page->AddBytes("image-" + std::to_string(i), jpeg);
      bytes += jpeg.size() * 4 / 3;
    }
    return bytes == 0 ? 0 : left_out;
  }

 private:
  struct Wanted {
    std::string scene, folder, image;
    ImageSize size;
  };

  /// The longest side that lets them all in, at about a byte for 6 pixels.
  int Longest(std::size_t most_bytes) const {
    const double each = static_cast<double>(most_bytes) / static_cast<double>(wanted_.size());
    return std::clamp(static_cast<int>(std::sqrt(each * 6.0)), 240, 640);
  }

  std::string Jpeg(const Wanted& wanted, int longest) const {
    cv::Mat image = LoadImageOf(folders_, wanted.scene, wanted.folder, wanted.image, wanted.size, longest);
    if (image.empty()) return "";
    const double scale = static_cast<double>(longest) / std::max(image.cols, image.rows);
    if (scale < 1.0) cv::resize(image, image, {}, scale, scale, cv::INTER_AREA);
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, 72});
    return {bytes.begin(), bytes.end()};
  }

  const std::vector<ImageFolder>& folders_;
  std::map<std::pair<std::string, std::string>, int> numbers_;
  std::vector<Wanted> wanted_;
};

/// The pictures of one page while they are gathered.
class Pictures {
 public:
  Pictures(const ExperimentResults& results, HtmlPage* page)
      : results_(results), page_(*page), photographs_(results.experiment) {}

  std::size_t bytes() const { return bytes_; }
  const Photographs& photographs() const { return photographs_; }
  std::string ToJson() const { return pictures_.dump(); }

  int Add(const Example& example, std::size_t condition, const std::string& folder) {
    const Problem& problem = example.problem;
    const ImageSize size1 = CanvasSize(problem.size1, problem.points, 0);
    const ImageSize size2 = CanvasSize(problem.size2, problem.points, 2);
    std::string masks = MaskOf(example.truth.inliers);
    Json methods = Json::array();
    for (const Cell& cell : results_.cells) {
      if (cell.condition != condition) continue;
      const auto mask = FoundMask(results_, cell, example);
      if (!mask) continue;
      methods.push_back(cell.method);
      masks += *mask;
    }
    const auto [image1, image2] = ImageNames(example);
    const int number = static_cast<int>(pictures_.size());
    AddBytes("masks-" + std::to_string(number), masks);
    const int largest = std::max({size1.width, size1.height, size2.width, size2.height});
    pictures_.push_back({Points(PointBytes(problem.points, largest)), size1.width, size1.height, size2.width,
                         size2.height, photographs_.Number(example.scene, folder, image1, problem.size1),
                         photographs_.Number(example.scene, folder, image2, problem.size2),
                         example.truth.inliers.empty() ? 0 : 1, methods});
    return number;
  }

 private:
  void AddBytes(const std::string& id, const std::string& bytes) {
    page_.AddBytes(id, bytes);
    bytes_ += bytes.size() * 4 / 3;
  }

  /// Conditions that change no point share them.
  int Points(const std::string& bytes) {
    const auto [at, is_new] = points_.try_emplace(std::hash<std::string>()(bytes), static_cast<int>(points_.size()));
    if (is_new) AddBytes("points-" + std::to_string(at->second), bytes);
    return at->second;
  }

  const ExperimentResults& results_;
  HtmlPage& page_;
  Photographs photographs_;
  Json pictures_ = Json::array();
  std::unordered_map<std::size_t, int> points_;
  std::size_t bytes_ = 0;
};

/// How many pictures have room, by the average number of matches.
std::size_t MostPictures(const ExperimentResults& results, const ProblemList& list, const PictureLimits& limits) {
  double bytes = 0.0;
  const double bits = 64.0 + 1.0 + static_cast<double>(results.experiment.methods.size());
  for (const ListedProblem& problem : list.problems) bytes += 4.0 / 3.0 * bits / 8.0 * problem.points + 200.0;
  const double each = bytes / static_cast<double>(std::max<std::size_t>(1, list.problems.size()));
  return std::min(limits.pairs,
                  static_cast<std::size_t>(static_cast<double>(limits.match_bytes) / std::max(each, 1.0)));
}

/// The problems whose inliers some method kept.
std::vector<std::size_t> Drawable(const ExperimentResults& results, const ProblemList& list) {
  std::vector<char> drawable(list.problems.size(), 0);
  for (const Cell& cell : results.cells)
    for (const EstimateRecord& estimate : cell.estimates) drawable[list.At(cell.condition, estimate.index)] = 1;
  for (const KeptFit& fit : results.fits) {
    const std::size_t at = list.At(fit.condition, fit.example.index);
    if (at < drawable.size() && list.problems[at].index == fit.example.index) drawable[at] = 1;
  }
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < drawable.size(); ++i)
    if (drawable[i] != 0) positions.push_back(i);
  return positions;
}

std::vector<std::size_t> ChosenProblems(const ExperimentResults& results, const ProblemList& list,
                                        const PictureLimits& limits) {
  const std::vector<std::size_t> drawable = Drawable(results, list);
  std::vector<double> errors;
  for (const std::size_t i : drawable) errors.push_back(list.problems[i].error);
  std::vector<std::size_t> chosen = LargestSmallestAndSpread(errors, MostPictures(results, list, limits));
  for (std::size_t& i : chosen) i = drawable[i];
  return chosen;
}

bool KeepsEstimates(const ExperimentResults& results) {
  return std::any_of(results.cells.begin(), results.cells.end(),
                     [](const Cell& cell) { return !cell.estimates.empty(); });
}

void AddNotes(const ExperimentResults& results, const ProblemList& list, std::size_t shown, std::size_t images_left_out,
              std::vector<std::string>* notes) {
  if (!KeepsEstimates(results))
    notes->push_back("This run kept no estimates (`estimates: false`), so that only " + std::to_string(shown) + " of " +
                     std::to_string(list.problems.size()) + " pairs have a picture.");
  else if (shown < list.problems.size())
    notes->push_back(std::to_string(shown) + " of " + std::to_string(list.problems.size()) +
                     " pairs have a picture: half of them those with the largest errors of " +
                     results.experiment.methods[list.method].label +
                     ", a quarter those with the smallest, the others evenly spread between them.");
  if (images_left_out > 0)
    notes->push_back(std::to_string(images_left_out) + " photographs had no room: their matches stand on grey.");
}

}  // namespace

PictureNumbers AddPairPictures(const ExperimentResults& results, const ProblemList& list, const PictureLimits& limits,
                               HtmlPage* page, std::vector<std::string>* notes) {
  PictureNumbers numbers(list.problems.size(), -1);
  Pictures pictures(results, page);
  std::unique_ptr<Dataset> dataset;
  std::size_t condition = results.experiment.conditions.size(), shown = 0;
  for (const std::size_t i : ChosenProblems(results, list, limits)) {
    const ListedProblem& problem = list.problems[i];
    if (condition != problem.condition) {
      condition = problem.condition;
      dataset = MakeDataset(results.experiment.conditions[condition].data, results.experiment.seed);
    }
    if (pictures.bytes() > limits.match_bytes * 5 / 4) break;
    const Example example = dataset->Get(problem.index);
    // The data may have changed since shards ran.
    if (ProblemName(example) != problem.id || example.problem.points.rows() != problem.points) continue;
    numbers[i] = pictures.Add(example, condition, dataset->FolderOf(example.scene));
    ++shown;
  }
  page->AddJson("pictures", pictures.ToJson());
  const std::size_t images_left_out = pictures.photographs().AddTo(page, limits.image_bytes);
  AddNotes(results, list, shown, images_left_out, notes);
  return numbers;
}

}  // namespace diffsac
