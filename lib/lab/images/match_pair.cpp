#include "lab/images/match_pair.h"

#include <array>
#include <map>

#include "lab/images/keypoint_frames.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

// Equal correspondences say one thing: the one with the best ratio stays. Keeps the order.
std::vector<DescriptorMatch> WithoutRepeats(const std::vector<DescriptorMatch>& matches, const ImageFeatures& first,
                                            const ImageFeatures& second) {
  using Position = std::array<double, 4>;
  std::map<Position, std::size_t> best;
  const auto position = [&](const DescriptorMatch& m) {
    return Position{first.positions(m.first, 0), first.positions(m.first, 1), second.positions(m.second, 0),
                    second.positions(m.second, 1)};
  };
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto [entry, is_new] = best.try_emplace(position(matches[i]), i);
    if (!is_new && matches[i].ratio < matches[entry->second].ratio) entry->second = i;
  }
  std::vector<DescriptorMatch> kept;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (best.at(position(matches[i])) == i) kept.push_back(matches[i]);
  return kept;
}

// Where a camera without distortion sees each keypoint; NaN where none could.
PointMatrix StraightPositions(const SourceImage& image, const ImageFeatures& features) {
  PointMatrix positions = features.positions;
  if (!image.camera || image.camera->IsStraight()) return positions;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    positions.row(i) = image.camera->Undistort(positions.row(i).transpose()).transpose();
  return positions;
}

void FillProblem(const SourceImage& image1, const SourceImage& image2, const ImageFeatures& first,
                 const ImageFeatures& second, std::vector<DescriptorMatch>* kept, Problem* into) {
  const PointMatrix positions1 = StraightPositions(image1, first), positions2 = StraightPositions(image2, second);
  std::vector<DescriptorMatch>& matches = *kept;
  std::erase_if(matches, [&](const DescriptorMatch& match) {
    return !positions1.row(match.first).allFinite() || !positions2.row(match.second).allFinite();
  });
  Problem& problem = *into;
  const auto count = static_cast<Eigen::Index>(matches.size());
  problem.points.resize(count, 4);
  problem.match_ratio.resize(count);
  MatchIndices rows(count, 2);
  for (Eigen::Index i = 0; i < count; ++i) {
    const DescriptorMatch& match = matches[i];
    problem.points.row(i) << positions1.row(match.first), positions2.row(match.second);
    problem.match_ratio[i] = match.ratio;
    rows.row(i) << match.first, match.second;
  }
  problem.similarities = SimilaritiesOf(first.frames, second.frames, rows);
  problem.size1 = first.size;
  problem.size2 = second.size;
  if (image1.camera && image2.camera) problem.cameras = CameraPair{image1.camera->K, image2.camera->K};
}

}  // namespace

MatchedPair MatchPair(const ImageSource& source, const SourcePair& pair, const ImageFeatures& first,
                      const ImageFeatures& second, DescriptorDistance distance) {
  const SourceImage &image1 = source.images[pair.image1], &image2 = source.images[pair.image2];
  MatchedPair matched;
  matched.matches = WithoutRepeats(MatchMutually(first.descriptors, second.descriptors, distance), first, second);
  Example& example = matched.example;
  example.image1 = image1.name;
  example.image2 = image2.name;
  example.id = example.image1 + "-" + example.image2;
  FillProblem(image1, image2, first, second, &matched.matches, &example.problem);
  if (image1.pose && image2.pose) example.truth.motion = RelativeMotion(*image1.pose, *image2.pose);
  example.truth.homography = pair.homography;
  CompleteTruth(example.problem, &example.truth);
  return matched;
}

}  // namespace diffsac
