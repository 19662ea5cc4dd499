// A learned guide without LibTorch: the line model of argv[1] on twenty points of which eight are outliers, y = x / 2 + 1.
#include <cmath>
#include <cstdio>

#include "diffsac/lab/yaml.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/lab/make_estimator.h"

int main(int, char** argv) {
  const auto row = diffsac::ConfigFromYaml(std::string("{type: diffsac, checkpoint: '") + argv[1] + "'}");
  const diffsac::Task task = diffsac::TaskFromString("line");
  const auto guide = diffsac::MakeEstimator(row, task, {});
  diffsac::Problem problem;
  problem.task = task;
  problem.points.resize(20, 2);
  for (int i = 0; i < 12; ++i) problem.points.row(i) << 0.5 * i, 0.25 * i + 1.0;
  problem.points.bottomRows(8) << 1, 9, 7, 0, 8, 9, 2, 6, 0, 8, 6, 7, 9, 1, 3, 9;
  const diffsac::Estimate estimate = guide->Run(problem, 1);
  if (estimate.status != diffsac::Status::kOk) return 1;
  int inliers = 0;
  for (const auto inlier : estimate.inliers) inliers += inlier;
  std::printf("guided slope %.3f inliers %d\n", -estimate.model[0] / estimate.model[1], inliers);
}
