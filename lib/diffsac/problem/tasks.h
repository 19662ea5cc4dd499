#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/problem/absolute_pose_task.h"
#include "diffsac/problem/essential_task.h"
#include "diffsac/problem/fundamental_task.h"
#include "diffsac/problem/homography_task.h"
#include "diffsac/problem/hyperplane_task.h"
#include "diffsac/problem/rigid_task.h"
#include "diffsac/problem/shared_focal_task.h"
#include "diffsac/problem/vanishing_point_task.h"

namespace diffsac {

/// The one list of what can be estimated. A new task is a description of its own (problem/task_description.h), its
/// header above, its name here and its place in the list: docs/extending.md.
enum class Task : int {
  kLine,
  kPlane,
  kHomography,
  kFundamental,
  kEssential,
  kAbsolutePose,
  kSharedFocal,
  kOneFocal,
  kTwoFocals,
  kVanishingPoint,
  kRigid,
  kSimilarity
};
using TaskList = TypeList<LineTask, PlaneTask, HomographyTask, FundamentalTask, EssentialTask, AbsolutePoseTask,
                          SharedFocalTask, OneFocalTask, TwoFocalsTask, VanishingPointTask, RigidTask, SimilarityTask>;

/// Those of which two views with a pose, matched or generated, are problems.
inline constexpr std::initializer_list<Task> kTwoViewTasks = {Task::kHomography,  Task::kFundamental, Task::kEssential,
                                                              Task::kSharedFocal, Task::kOneFocal,    Task::kTwoFocals};

/// Each task has the name of its own geometry model.
template <class... Descriptions>
constexpr auto TaskNamesOf(TypeList<Descriptions...>) {
  int place = 0;
  return std::array{EnumName<Task>{static_cast<Task>(place++), kModelName<typename Descriptions::Model>}...};
}
template <>
inline constexpr auto kEnumNames<Task> = TaskNamesOf(TaskList());

/// Calls `body.template operator()<Description>()` with the description of a task.
template <class Body>
auto DispatchDescription(Task task, Body&& body) {
  return DispatchPlace(static_cast<int>(task), TaskList(), std::forward<Body>(body));
}

/// Calls `body.template operator()<Model>()` with the task's own geometry model.
template <class Body>
auto DispatchTask(Task task, Body&& body) {
  return DispatchDescription(
      task, [&]<TaskDescription Description>() { return body.template operator()<typename Description::Model>(); });
}

/// Whether the points are matches of two clouds.
inline bool IsOfTwoClouds(Task task) {
  return DispatchDescription(task, []<class Description>() {
    return requires { Description::kTwoClouds; };
  });
}

/// Whether a task estimates focal lengths.
inline bool FindsFocals(Task task) {
  return DispatchDescription(task, []<class Description>() {
    return requires { Description::kUnknownFocal; };
  });
}

/// One of the geometry models by which a task's minimal sets can be solved, by its place among the description's
/// Models.
struct TaskModel {
  Task task{};
  int place = 0;
  bool operator==(const TaskModel&) const = default;
};

/// The model of a task by name ("fundamental8" of "fundamental"); the task's own for "". Throws Error that names those
/// of the task.
TaskModel ModelFromString(Task task, const std::string& name);
std::string ToString(const TaskModel& model);
/// The names of a task's models, its own first.
std::vector<std::string> ModelNames(Task task);
int MinimalSetSize(const TaskModel& model);

/// kOk, or why no estimator can solve this model from the points: those of CheckPoints, kDegenerate without what the
/// task needs.
Status CheckSpace(const NormalizedProblem& space, const TaskModel& model);

/// DispatchTask with a model that may not be the task's own.
template <class Body>
auto DispatchModel(const TaskModel& model, Body&& body) {
  return DispatchDescription(model.task, [&]<TaskDescription Description>() {
    return DispatchPlace(model.place, typename Description::Models(), body);
  });
}

}  // namespace diffsac
