#include "diffsac/estimate/guidance.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/errors.h"
#include "estimate/public_functions.h"

namespace diffsac {
namespace {

using testing::Answer;
using testing::AnswerOf;
using testing::kCamera;

/// An empty current folder, for as long as it lives.
class EmptyFolder {
 public:
  EmptyFolder() : before_(std::filesystem::current_path()) { std::filesystem::current_path(folder_.path()); }
  ~EmptyFolder() { std::filesystem::current_path(before_); }

 private:
  TemporaryFolder folder_;
  std::filesystem::path before_;
};

template <class Options>
Options With(Guidance guidance) {
  Options options;
  options.guidance = guidance;
  if constexpr (std::is_same_v<Options, PointOptions>) options.max_residual = 0.1;
  return options;
}

/// What a function answers, and how many minimal samples it drew.
struct Drawn : Answer {
  explicit Drawn(const auto& result) : Answer(AnswerOf(result)), draws(result.stats.iterations) {}
  bool operator==(const Drawn& other) const {
    return models == other.models && labels == other.labels && draws == other.draws;
  }
  std::int64_t draws;
};

struct Guided {
  std::string name;
  /// threads, samples: of the options; 0: their default.
  std::function<Drawn(int threads, int samples)> call;
};

/// The functions that diffusion guides, on generated data of which a quarter is wrong.
std::vector<Guided> Functions() {
  std::vector<Guided> all;
  const PointMatrix general = testing::SceneRows(200, 0, 1).rightCols(4),
                    flat = testing::SceneRows(200, 1, 2).rightCols(4);
  const auto add = [&](const std::string& name, auto options, auto estimate) {
    all.push_back({name, [=](int threads, int samples) {
                     auto given = options;
                     given.num_threads = threads;
                     if (samples > 0) given.max_iterations = samples;
                     return Drawn(estimate(given));
                   }});
  };
  for (const bool rated : {true, false}) {
    const Eigen::VectorXd ratios =
        rated ? Eigen::VectorXd(Eigen::VectorXd::LinSpaced(200, 0.0, 199.0).unaryExpr([](double i) {
          return std::fmod(i, 4.0) == 3.0 ? 0.9 : 0.6;
        }))
              : Eigen::VectorXd();
    const std::string with = rated ? "" : " without ratios";
    const Matches matches = testing::MatchesOf(general, ratios), of_plane = testing::MatchesOf(flat, ratios);
    const auto options = With<ImageOptions>(Guidance::kDiffusion);
    add("fundamental" + with, options, [=](const ImageOptions& o) { return EstimateFundamental(matches, o); });
    add("essential" + with, options, [=](const ImageOptions& o) {
      return EstimateEssential(matches, {kCamera, kCamera}, o);
    });
    add("homography" + with, options, [=](const ImageOptions& o) { return EstimateHomography(of_plane, o); });
  }
  const auto options = With<PointOptions>(Guidance::kDiffusion);
  const PointMatrix line = testing::FlatRows(100, 2, 1, 1), plane = testing::FlatRows(100, 3, 1, 2);
  add("line", options, [=](const PointOptions& o) { return EstimateLine(line, o); });
  add("plane", options, [=](const PointOptions& o) { return EstimatePlane(plane, o); });
  return all;
}

}  // namespace

TEST_CASE("Default calls find their networks in any folder") {
  const EmptyFolder here;
  for (const testing::PublicFunction& function : testing::PublicFunctions()) {
    CAPTURE(function.name);
    CHECK(function(function.points).status == Status::kOk);
  }
}

TEST_CASE("twenty diffusion samples find the model") {
  const EmptyFolder here;
  for (const Guided& function : Functions()) {
    CAPTURE(function.name);
    const Drawn answer = function.call(1, 0);
    REQUIRE(answer.is_certain());
    int right = 0, wrong = 0;
    for (std::size_t i = 0; i < answer.labels.size(); ++i) (i % 4 != 3 ? right : wrong) += answer.labels[i];
    CHECK(right >= static_cast<int>(0.7 * 0.75 * static_cast<double>(answer.labels.size())));
    CHECK(wrong <= static_cast<int>(0.1 * static_cast<double>(answer.labels.size())));
    CHECK(answer.draws == 20);
  }
}

TEST_CASE("Diffusion repeats itself on any number of threads") {
  for (const Guided& function : Functions()) {
    CAPTURE(function.name);
    const Drawn once = function.call(1, 30);
    CHECK(once.draws == 30);
    CHECK(function.call(2, 30) == once);
    // From two threads at once, which share the network.
    std::vector<Drawn> both(2, once);
    std::vector<std::thread> threads;
    for (Drawn& answer : both) {
      answer.models.clear();
      threads.emplace_back([&function, &answer] { answer = function.call(1, 30); });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK(both[0] == once);
    CHECK(both[1] == once);
  }
}

TEST_CASE("a network guides two views by default") {
  const PointMatrix line = testing::FlatRows(100, 2, 1, 1);
  const auto of = [&](Guidance guidance) { return Drawn(EstimateLine(line, With<PointOptions>(guidance))); };
  CHECK(of(Guidance::kNone) == of(Guidance::kNetwork));
  const Matches matches = testing::MatchesOf(testing::SceneRows(200, 0, 1).rightCols(4), {});
  const auto probabilities = [&](Guidance guidance) {
    return EstimateFundamental(matches, With<ImageOptions>(guidance)).inlier_probabilities;
  };
  CHECK(probabilities(Guidance::kNone).empty());
  CHECK(probabilities(Guidance::kNetwork).size() == 200);
  CHECK(probabilities(Guidance::kNetwork) == EstimateFundamental(matches).inlier_probabilities);
}

TEST_CASE("diffusion is refused without a network for it") {
  const PointMatrix rows = testing::SceneRows(60, 0, 1);
  Matches matches = testing::MatchesOf(rows.rightCols(4), {});
  const auto options = With<ImageOptions>(Guidance::kDiffusion);
  const auto points = With<PointOptions>(Guidance::kDiffusion);
  const std::string none = "guidance: expected none or network: diffusion has no network for ";
  CHECK(ErrorOf([&] {
          EstimateAbsolutePose({rows.leftCols(3), rows.rightCols(2)}, kCamera, options);
        }) == none + "absolute_pose");
  CHECK(ErrorOf([&] { EstimateMultipleFundamentals(matches, options); }) == none + "several models");
  CHECK(ErrorOf([&] { EstimateMultipleLines(rows.leftCols(2), points); }) == none + "several models");
  VanishingPointOptions vanishing;
  vanishing.size = {640, 480};
  vanishing.guidance = Guidance::kDiffusion;
  CHECK(ErrorOf([&] { EstimateVanishingPoints(rows.rightCols(4), vanishing); }) == none + "vanishing points");
  matches.scores = Eigen::VectorXd::Constant(60, 0.5);
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches, options); }),
            "guidance: expected none or network for matches with scores"));
}

}  // namespace diffsac
