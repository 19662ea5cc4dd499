#include "diffsac/problem/tasks.h"

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"
#include "diffsac/ransac/model_hooks.h"

namespace diffsac {
namespace {

template <class... Types>
std::vector<std::string> Names(TypeList<Types...>) {
  return {kModelName<Types>...};
}

// Its place, or -1.
int Find(const std::vector<std::string>& names, const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<int>(i);
  return -1;
}

}  // namespace

std::string ToString(Task task) { return ToString<Task>(task); }

std::vector<std::string> TaskNames() { return NamesOf<Task>(); }

Task TaskFromString(const std::string& name) {
  const std::vector<std::string> names = TaskNames();
  const int place = Find(names, name);
  if (place < 0) throw Error("unknown task '" + name + "': expected " + OneOf(names));
  return static_cast<Task>(place);
}

int MinimalSetSize(Task task) {
  return DispatchTask(task, []<class Model>() { return Model::kMinimalSize + 0; });
}

int PointDimension(Task task) {
  return DispatchTask(task, []<class Model>() { return Model::kDimension + 0; });
}

bool IsTwoView(Task task) {
  return DispatchDescription(task, []<class Description>() { return bool{Description::kTwoView}; });
}

std::vector<std::string> ModelNames(Task task) {
  return DispatchDescription(task, []<class Description>() { return Names(typename Description::Models()); });
}

TaskModel ModelFromString(Task task, const std::string& name) {
  if (name.empty()) return {task, 0};
  const std::vector<std::string> names = ModelNames(task);
  const int place = Find(names, name);
  if (place < 0) throw Error("model '" + name + "' is none of task " + ToString(task) + ": expected " + OneOf(names));
  return {task, place};
}

std::string ToString(const TaskModel& model) {
  return DispatchModel(model, []<class Model>() { return std::string(kModelName<Model>); });
}

Status CheckSpace(const NormalizedProblem& space, const TaskModel& model) {
  if (!space.is_accepted()) return Status::kDegenerate;
  return DispatchModel(model, [&]<MinimalModel Model>() { return CheckPoints<Model>(space.points()); });
}

int MinimalSetSize(const TaskModel& model) {
  return DispatchModel(model, []<class Model>() { return Model::kMinimalSize + 0; });
}

}  // namespace diffsac
