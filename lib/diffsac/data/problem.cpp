#include "diffsac/data/problem.h"

#include <array>
#include <utility>

#include "diffsac/data/task_dispatch.h"

namespace diffsac {
namespace {

constexpr std::array<std::pair<Task, const char*>, 5> kNames = {{{Task::kLine, "line"},
                                                                 {Task::kPlane, "plane"},
                                                                 {Task::kHomography, "homography"},
                                                                 {Task::kFundamental, "fundamental"},
                                                                 {Task::kEssential, "essential"}}};

}  // namespace

std::string ToString(Task task) {
  for (const auto& [known, name] : kNames)
    if (known == task) return name;
  return "unknown";
}

Task TaskFromString(const std::string& name) {
  for (const auto& [task, known] : kNames)
    if (known == name) return task;
  throw Error("unknown task '" + name + "': expected line, plane, homography, fundamental or essential");
}

int MinimalSetSize(Task task) {
  return DispatchTask(task, []<MinimalModel Model>() { return Model::kMinimalSize + 0; });
}

int PointDimension(Task task) {
  return DispatchTask(task, []<MinimalModel Model>() { return Model::kDimension + 0; });
}

int ModelSize(Task task) {
  return DispatchTask(task, []<MinimalModel Model>() { return static_cast<int>(Model::Parameters::SizeAtCompileTime); });
}

bool IsTwoView(Task task) { return task != Task::kLine && task != Task::kPlane; }

Status CheckProblem(const Problem& problem) {
  if (problem.task == Task::kEssential && !problem.cameras) return Status::kDegenerate;
  return DispatchTask(problem.task, [&]<MinimalModel Model>() { return CheckPoints<Model>(problem.points); });
}

}  // namespace diffsac
