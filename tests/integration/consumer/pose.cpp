// The program of the README: the relative pose of two calibrated images from the lines on stdin that diffsac_pair
// --matches writes.
#include <diffsac/diffsac.h>

#include <iostream>
#include <vector>

int main(int, char** argv) {
  const double focal = std::stod(argv[1]), cx = std::stod(argv[2]), cy = std::stod(argv[3]);
  std::vector<double> v;
  for (double x; std::cin >> x;) v.push_back(x);
  const Eigen::Map<const Eigen::Matrix<double, -1, 7, Eigen::RowMajor>> rows(v.data(), v.size() / 7, 7);
  const Eigen::Matrix3d K{{focal, 0, cx}, {0, focal, cy}, {0, 0, 1}};
  const diffsac::Matches matches{.points1 = rows.leftCols<2>(),
                                 .points2 = rows.middleCols<2>(2),
                                 .snn_ratio = rows.col(4),
                                 .scale_rotation_changes = rows.rightCols<2>()};
  const auto estimate = diffsac::EstimateEssential(matches, {K, K});
  if (!estimate.pose || estimate.verdict == diffsac::Verdict::kUnsupported) return 1;
  std::cout.precision(12);
  std::cout << estimate.num_inliers << " inliers\n" << estimate.pose->rotation << "\n" << estimate.model << "\n";
}
