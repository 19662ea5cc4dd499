#include "diffsac/data/problem.h"

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/geometry/hyperplane.h"

namespace diffsac {

std::string ToString(Task task) { return task == Task::kLine ? "line" : "plane"; }

Task TaskFromString(const std::string& name) {
  if (name == "line") return Task::kLine;
  if (name == "plane") return Task::kPlane;
  throw Error("unknown task '" + name + "': expected line or plane");
}

int MinimalSetSize(Task task) { return task == Task::kLine ? Line::kMinimalSize : Plane::kMinimalSize; }

int PointDimension(Task task) { return task == Task::kLine ? Line::kDimension : Plane::kDimension; }

Status CheckProblem(const Problem& problem) {
  return problem.task == Task::kLine ? CheckPoints<Line>(problem.points) : CheckPoints<Plane>(problem.points);
}

}  // namespace diffsac
