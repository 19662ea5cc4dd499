#pragma once

#include <string>
#include <vector>

#include "diffsac/data/problem.h"

namespace diffsac {

/// The names of all tasks, in the order of the enum.
inline std::vector<std::string> AllTaskNames() { return {"line", "plane", "homography", "fundamental", "essential"}; }
/// Whether the errors of the task's tables are pixels, not degrees.
inline bool HasPixelErrors(Task task) { return task == Task::kHomography; }

}  // namespace diffsac
