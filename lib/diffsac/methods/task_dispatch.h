#pragma once

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/data/problem.h"

namespace diffsac {

/// Calls `body.template operator()<Model>()` with the geometry model of a task.
template <class Body>
auto DispatchTask(Task task, Body&& body) {
  if (task == Task::kPlane) return body.template operator()<Plane>();
  return body.template operator()<Line>();
}

}  // namespace diffsac
