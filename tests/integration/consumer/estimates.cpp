// What every function of diffsac/diffsac.h estimates for the rows "X Y Z x1 y1 x2 y2 ratio" of stdin, for consumer.sh
// and test_diffsac.py: a name and numbers a line.
#include <diffsac/diffsac.h>

#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

namespace {

using namespace diffsac;

template <class Values>
void Print(const std::string& name, const Values& values) {
  std::printf("%s", name.c_str());
  for (const auto value : values) std::printf(" %.17g", static_cast<double>(value));
  std::printf("\n");
}

template <class Model>
void PrintModel(const std::string& name, const Model& model) {
  constexpr auto kOrder = Model::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor;
  const Eigen::Matrix<double, Model::RowsAtCompileTime, Model::ColsAtCompileTime, kOrder> rows = model;
  Print(name, std::vector<double>(rows.data(), rows.data() + rows.size()));
}

template <class Estimate>
void PrintEstimate(const std::string& name, const Estimate& estimate) {
  PrintModel(name + ".model", estimate.model);
  Print(name + ".inliers", estimate.inliers);
  Print(name + ".inlier_probabilities", estimate.inlier_probabilities);
  Print(name + ".numbers",
        std::vector<double>{estimate.inlier_threshold, estimate.sigma, estimate.diagnostics.log10_nfa});
}

template <class Estimate>
void PrintPose(const std::string& name, const Estimate& estimate) {
  PrintEstimate(name, estimate);
  const auto& covariance = estimate.pose_covariance.value();
  Print(name + ".pose_covariance", std::vector<double>(covariance.data(), covariance.data() + covariance.size()));
}

template <class Model>
void PrintSeveral(const std::string& name, const MultiModelEstimate<Model>& estimate) {
  for (const Model& model : estimate.models) PrintModel(name + ".models", model);
  Print(name + ".assignment", estimate.assignment);
}

}  // namespace

int main() {
  std::vector<double> numbers;
  for (double x; std::cin >> x;) numbers.push_back(x);
  const Eigen::Map<const Eigen::Matrix<double, -1, 8, Eigen::RowMajor>> rows(numbers.data(), numbers.size() / 8, 8);
  const Eigen::Matrix3d K{{600, 0, 320}, {0, 600, 240}, {0, 0, 1}};
  const Matches matches{rows.middleCols<2>(3), rows.middleCols<2>(5), rows.col(7)};
  Matches sized = matches;
  sized.size1 = sized.size2 = {640, 480};
  const Matches2D3D scene{rows.leftCols<3>(), rows.middleCols<2>(5), rows.col(7)};
  PrintPose("essential", EstimateEssential(matches, {K, K}));
  PrintEstimate("fundamental", EstimateFundamental(matches));
  PrintEstimate("homography", EstimateHomography(matches));
  PrintPose("absolute_pose", EstimateAbsolutePose(scene, K));
  const auto shared = EstimateSharedFocal(sized);
  PrintEstimate("shared_focal", shared);
  Print("shared_focal.focal", shared.focal.value().focal_px);
  const auto one = EstimateOneFocal(sized, K);
  PrintEstimate("one_focal", one);
  Print("one_focal.focal", one.focal.value().focal_px);
  const auto two = EstimateTwoFocals(sized);
  PrintEstimate("two_focals", two);
  Print("two_focals.focal", two.focal.value().focal_px);
  PrintEstimate("line", EstimateLine(rows.middleCols<2>(5), {.max_residual = 9.0}));
  PrintEstimate("plane", EstimatePlane(rows.leftCols<3>(), {.max_residual = 0.3}));
  PrintSeveral("essentials", EstimateMultipleEssentials(matches, {K, K}));
  PrintSeveral("fundamentals", EstimateMultipleFundamentals(matches));
  PrintSeveral("homographies", EstimateMultipleHomographies(matches));
  PrintSeveral("absolute_poses", EstimateMultipleAbsolutePoses(scene, K));
  PrintSeveral("lines", EstimateMultipleLines(rows.middleCols<2>(5), {.max_residual = 9.0}));
  PrintSeveral("planes", EstimateMultiplePlanes(rows.leftCols<3>(), {.max_residual = 0.3}));
  VanishingPointOptions options;
  options.K = K;
  const auto vanishing = EstimateVanishingPoints(rows.middleCols<4>(3), options);
  for (const Eigen::Vector3d& point : vanishing.points) PrintModel("vanishing.models", point);
  Print("vanishing.assignment", vanishing.assignment);
}
