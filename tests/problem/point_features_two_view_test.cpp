#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/errors.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/point_features.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic_two_view.h"

namespace diffsac {
namespace {

Example MakeExample(Task task, std::uint64_t index = 0, int descriptor_size = 0) {
  SyntheticTwoViewOptions options;
  options.task = task;
  options.matches.num_points = 120;
  options.planar = 0.0;
  Example example = MakeSyntheticTwoView(options, 41)->Get(index);
  if (descriptor_size > 0) {
    Rng rng = Rng(4).Fork("descriptors", index);
    example.problem.descriptors.resize(120, 2 * descriptor_size);
    for (float& value : example.problem.descriptors.reshaped()) value = static_cast<float>(rng.Uniform(0.0, 255.0));
  }
  return example;
}

PointFeatures Features(Task task, std::vector<PointFeature> kinds, int descriptor_size = 128) {
  PointFeaturesOptions options;
  options.kinds = std::move(kinds);
  options.descriptor_size = descriptor_size;
  return PointFeatures(options, task);
}

FeatureSet Coordinates(const Problem& problem) {
  return Features(problem.task, {PointFeature::kCoordinates}).Compute(problem, Rng(1));
}

float Difference(const FeatureSet& a, const FeatureSet& b) { return (a.values - b.values).cwiseAbs().maxCoeff(); }

constexpr Task kTasks[] = {Task::kHomography, Task::kFundamental, Task::kEssential};

// Everything in the pixels of images that are `factor` times as large.
Problem Enlarged(const Problem& problem, double factor) {
  Problem large = problem;
  large.points *= factor;
  large.size1 = {static_cast<int>(problem.size1.width * factor), static_cast<int>(problem.size1.height * factor)};
  large.size2 = {static_cast<int>(problem.size2.width * factor), static_cast<int>(problem.size2.height * factor)};
  if (large.cameras) {
    large.cameras->K1.topRows(2) *= factor;
    large.cameras->K2.topRows(2) *= factor;
  }
  return large;
}

}  // namespace

TEST_CASE("coordinates by the images' sizes where the calibration is not to be used") {
  for (Task task : {Task::kFundamental, Task::kEssential}) {
    const Problem problem = MakeExample(task).problem;
    REQUIRE(problem.cameras);
    PointFeaturesOptions options;
    options.kinds = {PointFeature::kCoordinates};
    options.use_calibration = false;
    const FeatureSet by_size = PointFeatures(options, task).Compute(problem, Rng(1));
    Problem uncalibrated = problem;
    uncalibrated.cameras.reset();
    uncalibrated.task = Task::kFundamental;  // an essential matrix needs the calibration
    CHECK(Difference(by_size, Coordinates(uncalibrated)) == 0.0f);
    CHECK(Difference(by_size, Coordinates(problem)) > 1e-3f);
  }
  PointFeaturesOptions options;
  options.kinds = {PointFeature::kCoordinates};
  options.use_calibration = false;
  CHECK_THROWS_WITH(PointFeatures(options, Task::kLine), Catch::Contains("use_calibration is for two views"));
}

TEST_CASE("two-view features: columns of each kind, side by side in their order") {
  for (Task task : kTasks) {
    const Problem problem = MakeExample(task, 0, 128).problem;
    CHECK(Features(task, {PointFeature::kCoordinates}).width() == 4);
    CHECK(Features(task, {PointFeature::kRatio}).width() == 5);
    CHECK(Features(task, {PointFeature::kDescriptors}).width() == 260);
    CHECK(Features(task, {PointFeature::kDescriptors, PointFeature::kRatio}).width() == 261);
    const FeatureSet all = Features(task, {PointFeature::kResidual, PointFeature::kDescriptors, PointFeature::kRatio})
                               .Compute(problem, Rng(1));
    REQUIRE(all.values.cols() == 261 + 48);
    CHECK(all.values.allFinite());
    CHECK(all.values.leftCols(4) == Coordinates(problem).values);
    CHECK(all.values.leftCols(5) == Features(task, {PointFeature::kRatio}).Compute(problem, Rng(1)).values);
    CHECK(all.values.middleCols(5, 256) ==
          Features(task, {PointFeature::kDescriptors}).Compute(problem, Rng(1)).values.rightCols(256));
    CHECK(all.values.rightCols(48) == Features(task, {PointFeature::kResidual}).Compute(problem, Rng(1)).values);
  }
}

TEST_CASE("two-view similarities: columns between the others and preference, 0 where there are none") {
  for (Task task : kTasks) {
    Problem problem = MakeExample(task).problem;
    const std::vector<PointFeature> without = {PointFeature::kRatio, PointFeature::kNeighborhood,
                                               PointFeature::kResidual};
    std::vector<PointFeature> with = without;
    with.push_back(PointFeature::kSimilarity);
    const FeatureSet before = Features(task, without).Compute(problem, Rng(1));
    const FeatureSet none = Features(task, with).Compute(problem, Rng(1));
    REQUIRE(none.values.cols() == before.values.cols() + 6);
    CHECK(Features(task, with).first_residual() == 8 + 6);
    CHECK((none.values.middleCols(8, 6).array() == 0.0f).all());
    problem.scale_rotation_changes.resize(problem.points.rows(), 2);
    Rng rng(2);
    for (double& value : problem.scale_rotation_changes.reshaped()) value = rng.Normal();
    const FeatureSet known = Features(task, with).Compute(problem, Rng(1));
    CHECK((known.values.col(13).array() == 1.0f).all());
    CHECK(known.values.allFinite());
    CHECK(known.values.leftCols(8) == before.values.leftCols(8));
    CHECK(known.values.rightCols(48) == before.values.rightCols(48));
    // Pixels of another size say the same.
    const auto similarity = Features(task, {PointFeature::kSimilarity});
    CHECK(similarity.width() == 6);
    CHECK(Difference(similarity.Compute(problem, Rng(1)), similarity.Compute(Enlarged(problem, 2.0), Rng(1))) < 1e-3f);
  }
}

TEST_CASE("two-view coordinates do not see image size and focal length") {
  for (Task task : kTasks) {
    Problem problem = MakeExample(task).problem;
    CHECK(Difference(Coordinates(problem), Coordinates(Enlarged(problem, 2.0))) < 1e-5f);
    // Another focal length: the same rays through another K.
    Problem zoomed = problem;
    zoomed.cameras->K1(0, 0) *= 1.7, zoomed.cameras->K1(1, 1) *= 1.7;
    for (int i = 0; i < 120; ++i)
      for (int k = 0; k < 2; ++k)
        zoomed.points(i, k) = zoomed.cameras->K1(k, 2) + 1.7 * (problem.points(i, k) - problem.cameras->K1(k, 2));
    CHECK(Difference(Coordinates(problem), Coordinates(zoomed)) < 1e-5f);
    // Without calibration the size decides, without both the points.
    problem.cameras.reset();
    const FeatureSet by_size = Coordinates(problem);
    CHECK(Difference(by_size, Coordinates(Enlarged(problem, 2.0))) < 1e-5f);
    const double unit = 1.2 * std::max(problem.size2.width, problem.size2.height);
    CHECK(by_size.values(3, 3) == Approx((problem.points(3, 3) - 0.5 * problem.size2.height) / unit));
    problem.size2 = {};
    const FeatureSet by_points = Coordinates(problem);
    CHECK(Difference(by_points, Coordinates(Enlarged(problem, 3.0))) < 1e-5f);
    problem.points.leftCols(2).array() += 55.0;
    CHECK(Difference(by_points, Coordinates(problem)) < 1e-5f);
    for (Eigen::Index k = 0; k < 4; ++k) {
      const auto column = by_points.values.col(k);
      CHECK(std::abs((column.array() > 0.0f).count() - 60) <= 1);
    }
  }
  Problem calibrated = MakeExample(Task::kEssential).problem;
  const Eigen::Vector3d ray =
      calibrated.cameras->K2.inverse() * Eigen::Vector3d(calibrated.points(7, 2), calibrated.points(7, 3), 1.0);
  CHECK(Coordinates(calibrated).values(7, 2) == Approx(ray[0] / ray[2]).margin(1e-6));
}

TEST_CASE("two-view ratios are standardised, and 0 where there are none") {
  Problem problem = MakeExample(Task::kFundamental).problem;
  const PointFeatures features = Features(Task::kFundamental, {PointFeature::kRatio});
  problem.snn_ratio[5] = 0.95;
  CHECK(features.Compute(problem, Rng(1)).values(5, 4) == Approx(1.0));
  problem.snn_ratio.resize(0);
  CHECK(features.Compute(problem, Rng(1)).values.col(4).isZero());
}

TEST_CASE("two-view descriptors are scaled for each image, whatever their unit") {
  Problem problem = MakeExample(Task::kFundamental, 1, 32).problem;
  const PointFeatures features = Features(Task::kFundamental, {PointFeature::kDescriptors}, 32);
  problem.descriptors.row(9).head(32).setZero();
  const FeatureSet set = features.Compute(problem, Rng(1));
  REQUIRE(set.values.cols() == 68);
  for (int i = 0; i < 120; ++i)
    for (int image = 0; image < 2; ++image) {
      const auto part = set.values.row(i).segment(4 + 32 * image, 32);
      CHECK(part.squaredNorm() / 32.0f == Approx(i == 9 && image == 0 ? 0.0 : 1.0));
      if (part.norm() == 0.0f) continue;
      CHECK(part.normalized().dot(problem.descriptors.row(i).segment(32 * image, 32).normalized()) == Approx(1.0));
    }
  Problem scaled = problem;
  scaled.descriptors *= 0.01f;
  CHECK(Difference(set, features.Compute(scaled, Rng(1))) < 1e-5f);
  problem.descriptors.resize(0, 0);
  CHECK(Has(ErrorOf([&] { features.Compute(problem, Rng(1)); }), "descriptors.h5"));
  PointFeaturesOptions lenient;
  lenient.kinds = {PointFeature::kDescriptors};
  lenient.descriptor_size = 32;
  lenient.descriptors_required = false;
  const FeatureSet without = PointFeatures(lenient, Task::kFundamental).Compute(problem, Rng(1));
  CHECK(without.values.leftCols(4) == set.values.leftCols(4));
  CHECK(without.values.rightCols(64).isZero(0.0f));
  const Problem other = MakeExample(Task::kFundamental, 1, 16).problem;
  CHECK(Has(ErrorOf([&] { features.Compute(other, Rng(1)); }), "64"));
}

TEST_CASE("two-view residual columns are what the header says") {
  for (Task task : kTasks) {
    const Problem problem = MakeExample(task, 2).problem;
    const FeatureSet features = Features(task, {PointFeature::kResidual}).Compute(problem, Rng(1));
    PointMatrix points = problem.points;
    double threshold = problem.inlier_threshold;
    if (task == Task::kEssential) {
      points = NormalizedCoordinates(points, problem.cameras->K1, problem.cameras->K2);
      threshold /= problem.cameras->MeanFocal();
    }
    REQUIRE(features.models.size() == 16);
    CHECK(features.hypotheses >= 16);
    CHECK(std::is_sorted(features.scores.rbegin(), features.scores.rend()));
    for (int j = 0; j < 16; ++j) {
      double score = 0.0;
      const Matrix3Parameters model = features.models[j];
      for (int i = 0; i < 120; ++i) {
        const double* point = points.data() + 4 * i;
        const double distance =
            task == Task::kHomography ? Homography::Residual(model, point) : Fundamental::Residual(model, point);
        const double r = std::isfinite(distance) ? std::min(distance / threshold, 1e6) : 1e6;
        CHECK(features.values(i, 3 * j) == Approx(std::exp(-2.0 * r * r)).margin(1e-5));
        CHECK(features.values(i, 3 * j + 1) == Approx(std::log1p(r) / 4.0).margin(1e-5));
        CHECK(features.values(i, 3 * j + 2) == Approx(features.scores[j] / 120.0).margin(1e-6));
        score += std::max(0.0, 1.0 - r * r / (1.5 * 1.5));
      }
      CHECK(features.scores[j] == Approx(score).epsilon(1e-9));
    }
  }
}

TEST_CASE("two-view features do not see the truth") {
  for (Task task : kTasks) {
    Example example = MakeExample(task, 3, 128);
    const PointFeatures features =
        Features(task, {PointFeature::kRatio, PointFeature::kDescriptors, PointFeature::kResidual});
    const FeatureSet before = features.Compute(example.problem, Rng(1));
    example.truth.model.setConstant(7.0);
    example.truth.pose.reset();
    for (auto& mark : example.truth.inliers) mark = !mark;
    const FeatureSet after = features.Compute(example.problem, Rng(1));
    CHECK(before.values == after.values);
    CHECK(before.scores == after.scores);
    // The points do decide them.
    example.problem.points.array() += 1.0;
    CHECK(features.Compute(example.problem, Rng(1)).values != before.values);
  }
}

TEST_CASE("degenerate two-view points give finite features") {
  for (Task task : kTasks) {
    Problem problem = MakeExample(task).problem;
    problem.points.rowwise() = Eigen::RowVector4d(10, 20, 30, 40);
    for (bool calibrated : {true, false}) {
      if (!calibrated && task == Task::kEssential) continue;
      if (!calibrated) problem.cameras.reset();
      const FeatureSet features =
          Features(task, {PointFeature::kRatio, PointFeature::kResidual}).Compute(problem, Rng(1));
      CHECK(features.values.allFinite());
      CHECK(features.hypotheses == 0);
    }
    problem.points.resize(0, 4);
    CHECK(Features(task, {PointFeature::kCoordinates}).Compute(problem, Rng(1)).values.rows() == 0);
  }
}

TEST_CASE("lines and planes have no ratios and descriptors") {
  CHECK(Has(ErrorOf([] { Features(Task::kLine, {PointFeature::kRatio}); }), "line"));
  CHECK(Has(ErrorOf([] { Features(Task::kPlane, {PointFeature::kDescriptors}); }), "plane"));
  CHECK(Has(ErrorOf([] { Features(Task::kLine, {PointFeature::kSimilarity}); }), "line"));
}

}  // namespace diffsac
