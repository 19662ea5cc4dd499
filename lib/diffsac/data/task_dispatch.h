#pragma once

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/two_view_consensus.h"
#include "diffsac/data/problem.h"

namespace diffsac {

/// Calls `body.template operator()<Model>()` with the geometry model of a task.
template <class Body>
auto DispatchTask(Task task, Body&& body) {
  switch (task) {
    case Task::kPlane:
      return body.template operator()<Plane>();
    case Task::kHomography:
      return body.template operator()<Homography>();
    case Task::kFundamental:
      return body.template operator()<Fundamental>();
    case Task::kEssential:
      return body.template operator()<Essential>();
    case Task::kLine:
      break;
  }
  return body.template operator()<Line>();
}

/// As DispatchTask; fundamental matrices of 7 or 8 points.
template <class Body>
auto DispatchSetSize(Task task, int fundamental_points, const Body& body) {
  if (task == Task::kFundamental && fundamental_points == 8) return body.template operator()<Fundamental8>();
  return DispatchTask(task, body);
}

}  // namespace diffsac
