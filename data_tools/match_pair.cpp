#include "data_tools/match_pair.h"

#include <array>
#include <map>

#include "diffsac/problem/keypoint_similarity.h"
#include "diffsac/problem/pair_truth.h"

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

void FillProblem(const SourceImage& image1, const SourceImage& image2, const ImageFeatures& first,
                 const ImageFeatures& second, const std::vector<DescriptorMatch>& matches, Problem* into) {
  const auto position = [](const SourceImage& image, const ImageFeatures& features, int row) -> Eigen::RowVector2d {
    const Eigen::Vector2d pixel = features.positions.row(row);
    return (image.camera ? image.camera->Undistort(pixel) : pixel).transpose();
  };
  Problem& problem = *into;
  const auto count = static_cast<Eigen::Index>(matches.size());
  problem.points.resize(count, 4);
  problem.match_ratio.resize(count);
  const bool framed = first.frames.size() > 0 && second.frames.size() > 0;
  if (framed) problem.similarities.resize(count, 2);
  for (Eigen::Index i = 0; i < count; ++i) {
    const DescriptorMatch& match = matches[i];
    problem.points.row(i) << position(image1, first, match.first), position(image2, second, match.second);
    problem.match_ratio[i] = match.ratio;
    if (framed)
      problem.similarities.row(i) = SimilarityOf(first.frames.row(match.first), second.frames.row(match.second));
  }
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
  FillProblem(image1, image2, first, second, matched.matches, &example.problem);
  if (image1.pose && image2.pose) example.truth.motion = RelativeMotion(*image1.pose, *image2.pose);
  example.truth.homography = pair.homography;
  CompleteTruth(example.problem, &example.truth);
  return matched;
}

}  // namespace diffsac
