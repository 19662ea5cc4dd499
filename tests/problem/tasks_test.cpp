#include "diffsac/problem/tasks.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/errors.h"
#include "diffsac/problem/normalized_problem.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

constexpr Task kTasks[] = {Task::kLine,      Task::kPlane,          Task::kHomography,  Task::kFundamental,
                           Task::kEssential, Task::kAbsolutePose,   Task::kSharedFocal, Task::kOneFocal,
                           Task::kTwoFocals, Task::kVanishingPoint, Task::kRigid,       Task::kSimilarity};

Problem TwoViewProblem(Task task) {
  Problem problem;
  problem.task = task;
  problem.points = PointMatrix::Random(12, 4) * 300.0;
  problem.inlier_threshold = 3.0;
  CameraPair cameras;
  cameras.K1 << 500.0, 0.0, 320.0, 0.0, 520.0, 240.0, 0.0, 0.0, 1.0;
  cameras.K2 << 600.0, 0.0, 300.0, 0.0, 620.0, 200.0, 0.0, 0.0, 1.0;
  problem.cameras = cameras;
  return problem;
}

}  // namespace

TEST_CASE("the names of the enumeration are those of the list") {
  const char* names[] = {"line",         "plane",     "homography", "fundamental",     "essential", "absolute_pose",
                         "shared_focal", "one_focal", "two_focals", "vanishing_point", "rigid",     "similarity"};
  CHECK(TaskNames() == std::vector<std::string>(std::begin(names), std::end(names)));
  for (std::size_t i = 0; i < std::size(kTasks); ++i) {
    CHECK(ToString(kTasks[i]) == names[i]);
    CHECK(TaskFromString(names[i]) == kTasks[i]);
  }
  CHECK(Problem().task == Task::kLine);
  CHECK(Has(ErrorOf([] { TaskFromString("circle"); }),
            "'circle': expected line, plane, homography, fundamental, essential, absolute_pose, shared_focal, "
            "one_focal, two_focals, vanishing_point, rigid or similarity"));
}

TEST_CASE("sizes and kinds follow from the descriptions") {
  const int sizes[] = {2, 3, 4, 7, 5, 3, 6, 6, 7, 2, 3, 3}, dimensions[] = {2, 3, 4, 4, 4, 5, 4, 4, 4, 4, 6, 6};
  for (std::size_t i = 0; i < std::size(kTasks); ++i) {
    CAPTURE(ToString(kTasks[i]));
    CHECK(MinimalSetSize(kTasks[i]) == sizes[i]);
    CHECK(PointDimension(kTasks[i]) == dimensions[i]);
    CHECK(IsTwoView(kTasks[i]) == (dimensions[i] == 4 && kTasks[i] != Task::kVanishingPoint));
  }
}

TEST_CASE("a task's models are chosen by name") {
  for (const Task task : kTasks) {
    const TaskModel own = ModelFromString(task, "");
    CHECK(ToString(own) == ToString(task));
    CHECK(MinimalSetSize(own) == MinimalSetSize(task));
    CHECK(ModelFromString(task, ToString(task)) == own);
  }
  const TaskModel eight = ModelFromString(Task::kFundamental, "fundamental8");
  CHECK(MinimalSetSize(eight) == 8);
  CHECK(DispatchModel(eight, []<class Model>() { return Model::kMinimalSize + 0; }) == 8);
  CHECK(DispatchTask(Task::kFundamental, []<class Model>() { return Model::kMinimalSize + 0; }) == 7);
  CHECK(Has(ErrorOf([] { ModelFromString(Task::kEssential, "fundamental8"); }), "expected essential"));
}

TEST_CASE("the key model is one of the task's models") {
  struct Options {
    std::string model;
    void Bind(OptionsBinder& b) { BindModel(b, Task::kFundamental, &model); }
  };
  const auto read = [](const char* yaml) { return ReadOptions<Options>(ConfigFromYaml(yaml, "a.yaml")).model; };
  CHECK(read("{}") == "");
  CHECK(read("model: fundamental8") == "fundamental8");
  const std::string error = ErrorOf([&] { read("model: essential"); });
  CHECK(Has(error, "a.yaml:1"));
  CHECK(Has(error, "fundamental or fundamental8"));
}

TEST_CASE("the essential matrix is solved in normalised coordinates, the others in the data's") {
  const Problem calibrated = TwoViewProblem(Task::kEssential);
  const NormalizedProblem space(calibrated);
  CHECK(space.is_normalized());
  CHECK(space.unit() == 560.0);
  CHECK(space.threshold() == 3.0 / 560.0);
  CHECK(space.points() == NormalizedCoordinates(calibrated.points, calibrated.cameras->K1, calibrated.cameras->K2));
  for (const Task task : {Task::kHomography, Task::kFundamental}) {
    const Problem problem = TwoViewProblem(task);
    const NormalizedProblem pixels(problem);
    CHECK_FALSE(pixels.is_normalized());
    CHECK(&pixels.points() == &problem.points);
    CHECK(pixels.threshold() == 3.0);
  }
}

TEST_CASE("a problem without what its task needs is no problem to work on") {
  Problem problem = TwoViewProblem(Task::kEssential);
  CHECK(CheckProblem(problem) == Status::kOk);
  problem.cameras.reset();
  CHECK_FALSE(HasItsNeeds(problem));
  CHECK(CheckProblem(problem) == Status::kDegenerate);
  CHECK_FALSE(NormalizedProblem(problem).is_normalized());
  const CameraPair good = *TwoViewProblem(Task::kEssential).cameras;
  for (const double broken : {0.0, std::nan(""), -1.0}) {
    problem.cameras = CameraPair{broken * good.K1, good.K2 * (broken < 0.0 ? -1.0 : 1.0)};
    CHECK(CheckProblem(problem) == Status::kDegenerate);
  }
  problem.cameras.reset();
  problem.task = Task::kFundamental;
  CHECK(CheckProblem(problem) == Status::kOk);
}

}  // namespace diffsac
