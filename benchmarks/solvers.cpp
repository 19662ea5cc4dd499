// Speed and accuracy of the two-view solvers, beside OpenCV's where it exposes one. Solvers of a table are run in turn,
// round after round, on the same problems; times are medians over rounds of processor time, ratios medians of the
// rounds' ratios, so that a machine whose speed drifts changes all of them alike. Errors: distance of the nearest
// solution to the true model, both of unit Frobenius norm and in coordinates of order one, median over the problems.
//
//   diffsac_solver_benchmark [--rounds 15] [--problems 1000]
#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/refine.h"
#include "measure.h"

namespace diffsac {
namespace {

using Models = std::vector<Matrix3Parameters>;

struct Problem {
  PointMatrix points;
  Matrix3Parameters truth;
  Eigen::Vector3d left, right;  ///< diagonal matrices that bring a model to coordinates of order one
  cv::Mat first, second;        ///< the same points, N x 2
};

struct Solver {
  std::string name;
  /// Solves one problem; writes up to ten models, returns how many.
  std::function<int(const Problem&, Matrix3Parameters*)> solve;
};

/// Time that this program's one thread has run; other programs on the machine do not count.
double CpuNanoseconds() { return 1e9 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double Distance(const Problem& problem, const Matrix3Parameters& model) {
  const auto conditioned = [&](const Matrix3Parameters& m) {
    return AsParameters(problem.left.asDiagonal() * AsMatrix(m) * problem.right.asDiagonal());
  };
  const Matrix3Parameters a = conditioned(model), b = conditioned(problem.truth);
  return std::min((a - b).norm(), (a + b).norm());
}

double ErrorOf(const Solver& solver, const std::vector<Problem>& problems, double* solutions) {
  std::vector<double> errors;
  *solutions = 0.0;
  for (const Problem& problem : problems) {
    Matrix3Parameters models[10];
    const int count = solver.solve(problem, models);
    double best = 2.0;
    for (int i = 0; i < count; ++i) best = std::min(best, Distance(problem, models[i]));
    errors.push_back(best);
    *solutions += count / static_cast<double>(problems.size());
  }
  return Median(errors);
}

double NanosecondsPerCall(const Solver& solver, const std::vector<Problem>& problems) {
  Matrix3Parameters models[10];
  const double start = CpuNanoseconds();
  for (const Problem& problem : problems) solver.solve(problem, models);
  return (CpuNanoseconds() - start) / static_cast<double>(problems.size());
}

// The last solver of the list is the reference of the ratio.
void Table(const std::string& title, const std::vector<Problem>& problems, const std::vector<Solver>& solvers,
           int rounds) {
  std::printf("\n### %s\n\n| solver | ns per call | time / last | models | median error |\n|---|---|---|---|---|\n",
              title.c_str());
  std::vector<std::vector<double>> times(solvers.size()), ratios(solvers.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < solvers.size(); ++i) times[i].push_back(NanosecondsPerCall(solvers[i], problems));
    for (std::size_t i = 0; i < solvers.size(); ++i) ratios[i].push_back(times[i].back() / times.back().back());
  }
  for (std::size_t i = 0; i < solvers.size(); ++i) {
    double solutions = 0.0;
    const double error = ErrorOf(solvers[i], problems, &solutions);
    std::printf("| %s | %.0f | %.3f | %.2f | %.1e |\n", solvers[i].name.c_str(), Median(times[i]), Median(ratios[i]),
                solutions, error);
  }
  std::fflush(stdout);
}

cv::Mat ImagePoints(const PointMatrix& points, int image) {
  cv::Mat out(static_cast<int>(points.rows()), 2, CV_64F);
  for (int i = 0; i < out.rows; ++i)
    for (int j = 0; j < 2; ++j) out.at<double>(i, j) = points(i, 2 * image + j);
  return out;
}

int FromOpenCv(const cv::Mat& models, Matrix3Parameters* out) {
  const int count = models.rows / 3;
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < 9; ++i) out[k][i] = models.at<double>(3 * k + i / 3, i % 3);
  for (int k = 0; k < count; ++k) out[k].normalize();
  return count;
}

Problem Finish(PointMatrix points, const Matrix3Parameters& truth, const Eigen::Vector3d& left,
               const Eigen::Vector3d& right) {
  Problem problem{std::move(points), truth, left, right, {}, {}};
  problem.first = ImagePoints(problem.points, 0);
  problem.second = ImagePoints(problem.points, 1);
  return problem;
}

/// Two views of points 2 to 10 baselines away; `pixels` with a focal length of 1000.
Problem EpipolarProblem(int count, bool pixels, Rng rng) {
  const auto direction = [&] { return Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized(); };
  RelativePose pose;
  pose.rotation = Eigen::AngleAxisd(rng.Uniform(0.0, 0.6), direction()).toRotationMatrix();
  pose.translation = direction();
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  if (pixels) k << 1000.0, 0.0, 500.0, 0.0, 1000.0, 400.0, 0.0, 0.0, 1.0;
  PointMatrix points(count, 4);
  for (int i = 0; i < count;) {
    const double depth = rng.Uniform(2.0, 10.0);
    const Eigen::Vector3d first(depth * rng.Uniform(-0.6, 0.6), depth * rng.Uniform(-0.6, 0.6), depth);
    const Eigen::Vector3d second = pose.rotation * first + pose.translation;
    if (second[2] < 0.5) continue;
    points.row(i++) << (k * first).hnormalized().transpose(), (k * second).hnormalized().transpose();
  }
  const Eigen::Vector3d unit(k(0, 0), k(1, 1), 1.0);
  return Finish(points, AsParameters(FundamentalFromEssential(EssentialFromPose(pose), k, k)), unit, unit);
}

Problem PlanarProblem(int count, Rng rng) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 4; ++i) h(i / 2, i % 2) += rng.Uniform(-0.3, 0.3);
  for (int i = 0; i < 2; ++i) h(i, 2) = rng.Uniform(-200.0, 200.0);
  for (int i = 0; i < 2; ++i) h(2, i) = rng.Uniform(-4e-4, 4e-4);
  PointMatrix points(count, 4);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d x(rng.Uniform(0.0, 1000.0), rng.Uniform(0.0, 800.0), 1.0);
    points.row(i) << x.head<2>().transpose(), (h * x).hnormalized().transpose();
  }
  const Eigen::Vector3d unit(500.0, 500.0, 1.0);
  return Finish(points, AsParameters(h), unit.cwiseInverse(), unit);
}

template <class Make>
std::vector<Problem> Problems(int count, const Make& make) {
  const Rng rng(1);
  std::vector<Problem> problems;
  for (int i = 0; i < count; ++i) problems.push_back(make(rng.Fork("solver benchmark", i)));
  return problems;
}

constexpr int kSet[] = {0, 1, 2, 3, 4, 5, 6, 7};

template <class Model>
Solver Minimal(const std::string& name) {
  return {name, [](const Problem& p, Matrix3Parameters* out) { return Model::SolveMinimal(p.points, kSet, out); }};
}

template <class Model>
Solver LeastSquares(const std::string& name) {
  return {name, [](const Problem& p, Matrix3Parameters* out) {
            return Model::Fit(p.points, Eigen::VectorXd::Ones(p.points.rows()), out) ? 1 : 0;
          }};
}

Solver OpenCvFundamental(const std::string& name, int method) {
  return {name, [method](const Problem& p, Matrix3Parameters* out) {
            return FromOpenCv(cv::findFundamentalMat(p.first, p.second, method), out);
          }};
}

Solver OpenCvHomography(const std::string& name) {
  return {name, [](const Problem& p, Matrix3Parameters* out) {
            return FromOpenCv(cv::findHomography(p.first, p.second, 0), out);
          }};
}

void MinimalTables(int problems, int rounds) {
  const auto normalized = Problems(problems, [](Rng rng) { return EpipolarProblem(5, false, rng); });
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  Table("Essential, 5 points", normalized,
        {Minimal<Essential>("5 points (orientation test)"),
         {"5 points, all real solutions",
          [](const Problem& p, Matrix3Parameters* out) { return SolveFivePoints(p.points, kSet, out); }},
         // With five points this is its minimal solver and nothing else.
         {"cv::findEssentialMat",
          [&](const Problem& p, Matrix3Parameters* out) {
            return FromOpenCv(cv::findEssentialMat(p.first, p.second, identity), out);
          }}},
        rounds);
  Table("Fundamental, 7 points", Problems(problems, [](Rng rng) { return EpipolarProblem(7, true, rng); }),
        {Minimal<Fundamental>("7 points (orientation test)"),
         {"7 points, all real solutions",
          [](const Problem& p, Matrix3Parameters* out) { return SolveSevenPoints(p.points, kSet, out); }},
         OpenCvFundamental("cv::findFundamentalMat, FM_7POINT", cv::FM_7POINT)},
        rounds);
  Table("Fundamental, 8 points", Problems(problems, [](Rng rng) { return EpipolarProblem(8, true, rng); }),
        {Minimal<Fundamental8>("8 points"), OpenCvFundamental("cv::findFundamentalMat, FM_8POINT", cv::FM_8POINT)},
        rounds);
  Table("Homography, 4 points", Problems(problems, [](Rng rng) { return PlanarProblem(4, rng); }),
        {Minimal<Homography>("4 points (orientation test)"), OpenCvHomography("cv::findHomography")}, rounds);
}

void FitTables(int problems, int rounds) {
  constexpr int kPoints = 100;
  Table("Fundamental, 100 points", Problems(problems, [](Rng rng) { return EpipolarProblem(kPoints, true, rng); }),
        {LeastSquares<Fundamental>("fit"), OpenCvFundamental("cv::findFundamentalMat, FM_8POINT", cv::FM_8POINT)},
        rounds);
  Table("Homography, 100 points", Problems(problems, [](Rng rng) { return PlanarProblem(kPoints, rng); }),
        {LeastSquares<Homography>("fit"),
         {"fit and refinement (Sampson)",
          [](const Problem& p, Matrix3Parameters* out) {
            const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kPoints);
            RefineOptions options;
            options.loss.kind = LossKind::kTrivial;
            if (!Homography::Fit(p.points, ones, out)) return 0;
            RefineHomography(p.points, ones, options, out);
            return 1;
          }},
         OpenCvHomography("cv::findHomography (fit and refinement)")},
        rounds);
}

/// Refinement of noisy problems from the linear fit, by itself: OpenCV offers none for F and E.
void RefinementTable(int problems, int rounds) {
  constexpr int kPoints = 200;
  const auto noisy = Problems(problems, [](Rng rng) {
    Problem problem = EpipolarProblem(kPoints, false, rng);
    for (Eigen::Index i = 0; i < problem.points.size(); ++i) problem.points.data()[i] += 1e-3 * rng.Normal();
    return problem;
  });
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kPoints);
  RefineOptions options;
  options.loss = {LossKind::kTruncated, 3e-3};
  const auto refined = [&](auto fit, auto refine) {
    return [&, fit, refine](const Problem& p, Matrix3Parameters* out) {
      if (!fit(p.points, ones, out)) return 0;
      refine(p.points, ones, options, out);
      return 1;
    };
  };
  Table("Refinement on 200 noisy points (1 px at a focal length of 1000; errors are the noise's)", noisy,
        {{"E: fit and refinement", refined(Essential::Fit, RefineEssential)},
         {"F: fit and refinement", refined(Fundamental::Fit, RefineFundamental)},
         LeastSquares<Essential>("E: fit"),
         LeastSquares<Fundamental>("F: fit")},
        rounds);
}

/// Nanoseconds for the residual of one point, over columns of 1000 points (which stay in the cache).
void ResidualTable(int rounds) {
  constexpr int kPoints = 1000, kRepeats = 500;
  const Problem problem = EpipolarProblem(kPoints, true, Rng(2));
  const Eigen::MatrixXd columns = problem.points;
  const double* pointers[4];
  for (int i = 0; i < 4; ++i) pointers[i] = columns.col(i).data();
  std::vector<double> out(kPoints);
  using Function = std::function<void(const Matrix3Parameters&, const double* const*, int, int, double*)>;
  const std::pair<const char*, Function> functions[] = {{"Sampson (F, E)", Fundamental::Residuals},
                                                        {"symmetric transfer (H)", Homography::Residuals}};
  std::printf("\n### Residuals\n\n| residual | ns per point |\n|---|---|\n");
  for (const auto& [name, function] : functions) {
    std::vector<double> times;
    for (int round = 0; round < rounds; ++round) {
      const double start = CpuNanoseconds();
      for (int i = 0; i < kRepeats; ++i) function(problem.truth, pointers, 0, kPoints, out.data());
      times.push_back((CpuNanoseconds() - start) / (kRepeats * kPoints));
    }
    std::printf("| %s | %.2f |\n", name, Median(times));
  }
}

}  // namespace
}  // namespace diffsac

int main(int argc, char** argv) {
  CLI::App app{"Speed and accuracy of the two-view solvers"};
  int rounds = 15, problems = 1000;
  app.add_option("--rounds", rounds, "Rounds; figures are medians")->check(CLI::PositiveNumber);
  app.add_option("--problems", problems, "Problems of a table")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  diffsac::MinimalTables(problems, rounds);
  diffsac::FitTables(std::max(1, problems / 5), rounds);
  diffsac::RefinementTable(std::max(1, problems / 5), rounds);
  diffsac::ResidualTable(rounds);
  return 0;
}
