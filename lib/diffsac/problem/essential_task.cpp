#include "diffsac/problem/essential_task.h"

#include <Eigen/LU>

namespace diffsac {

bool EssentialTask::Accepts(const Problem& problem) {
  if (!problem.cameras) return false;
  const auto& [K1, K2] = *problem.cameras;
  return K1.allFinite() && K2.allFinite() && problem.cameras->MeanFocal() > 0.0 && K1.determinant() != 0.0 &&
         K2.determinant() != 0.0;
}

}  // namespace diffsac
