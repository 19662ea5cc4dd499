// What every function of diffsac/diffsac.h promises of any data.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <numeric>

#include "core/errors.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "estimate/public_functions.h"

namespace diffsac {
namespace {

using testing::Answer;
using testing::kCamera;
using testing::PublicFunction;
using testing::PublicFunctions;
using testing::RatiosFor;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Row i of the result is row rows[i].
std::vector<int> Taken(const std::vector<int>& labels, const std::vector<int>& rows) {
  std::vector<int> taken;
  for (const int row : rows) taken.push_back(labels.at(static_cast<std::size_t>(row)));
  return taken;
}

PointMatrix Taken(const PointMatrix& points, const std::vector<int>& rows) { return points(rows, Eigen::all); }

Eigen::VectorXd Taken(const Eigen::VectorXd& ratios, const std::vector<int>& rows) {
  return ratios.size() == 0 ? ratios : Eigen::VectorXd(ratios(rows));
}

void CheckSameModels(const Answer& answer, const Answer& expected) {
  CHECK(answer.status == expected.status);
  CHECK(answer.diagnostics.log10_nfa == expected.diagnostics.log10_nfa);
  REQUIRE(answer.models.size() == expected.models.size());
  for (std::size_t k = 0; k < answer.models.size(); ++k) CHECK(answer.models[k] == expected.models[k]);
}

/// Of a range that is about the function's own.
PointMatrix RandomRows(const PublicFunction& function, int count, std::uint64_t seed) {
  Eigen::RowVectorXd low = function.points.colwise().minCoeff(), high = function.points.colwise().maxCoeff();
  if (low.size() == 4) {  // Of two images, or of one, whose size is given.
    low = low.cwiseMax(0.0);
    high = high.cwiseMin(Eigen::RowVector4d(640.0, 480.0, 640.0, 480.0));
  }
  Rng rng(seed);
  PointMatrix rows(count, function.points.cols());
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index c = 0; c < rows.cols(); ++c) rows(i, c) = rng.Uniform(low[c], high[c]);
  return rows;
}

}  // namespace

TEST_CASE("every function: of equal rows one counts, in all digits, and all are in the mask") {
  for (const PublicFunction& function : PublicFunctions()) {
    INFO(function.name);
    const Eigen::VectorXd ratios = RatiosFor(function);
    const Answer once = function(function.points, ratios);
    REQUIRE(once.is_certain());
    const int count = static_cast<int>(function.points.rows());
    std::vector<int> twice, thrice, unlike;
    for (int i = 0; i < 2 * count; ++i) twice.push_back(i % count);
    for (int i = 0; i < 3 * count; ++i) thrice.push_back(i / 3);
    for (int i = 0; i < 3 * count; ++i)
      if (i % 3 <= i / 3 % 3) unlike.push_back(i / 3);
    for (const std::vector<int>& rows : {twice, thrice, unlike}) {
      CAPTURE(rows.size());
      const Answer repeated = function(Taken(function.points, rows), Taken(ratios, rows));
      CheckSameModels(repeated, once);
      CHECK(repeated.labels == Taken(once.labels, rows));
      CHECK(repeated.diagnostics.num_duplicates == static_cast<int>(rows.size()) - count);
      CHECK(repeated.diagnostics.num_nonfinite == 0);
    }
  }
}

TEST_CASE("trouble: random matches, each three times, were certain in 30 of 30") {
  for (const PublicFunction& function : PublicFunctions()) {
    // What people would call a vanishing point a network says, not chance; without one there always are some.
    if (Has(function.name, "Vanishing")) continue;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const PointMatrix once = RandomRows(function, 100, seed);
      CAPTURE(function.name, seed);
      CHECK_FALSE(function(once).is_certain());
      CHECK_FALSE(function(PointMatrix(once.replicate(3, 1))).is_certain());
    }
  }
}

TEST_CASE("matches that share a keypoint were evidence, fifty of them certain among random ones") {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Rng rng(seed);
    testing::OwnedMatches matches;
    matches.points1.resize(100, 2);
    matches.points2.resize(100, 2);
    for (Eigen::Index i = 0; i < 100; ++i) {
      matches.points1.row(i) << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 640.0);
      matches.points2.row(i) << rng.Uniform(0.0, 640.0), rng.Uniform(0.0, 640.0);
      if (i < 50) matches.points2.row(i) << 300.0, 200.0;
    }
    for (const auto& estimate :
         {EstimateFundamental(matches), EstimateHomography(matches), EstimateEssential(matches, {kCamera, kCamera})})
      CHECK((!estimate.ok() || testing::MayBeChance(estimate)));
  }
}

TEST_CASE("a calibration of other points, or an inverse, is an error that names it") {
  testing::OwnedMatches matches;
  matches.points1 = matches.points2 = Eigen::MatrixXd::Random(50, 2).array() * 300.0 + 320.0;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  CHECK(ErrorOf([&] { EstimateEssential(matches, {unit, kCamera}); }).starts_with("K1: expected"));
  CHECK(ErrorOf([&] { EstimateEssential(matches, {kCamera, kCamera.inverse()}); }).starts_with("K2: expected"));
}

TEST_CASE("K1 says all of the first image of one unknown focal length") {
  testing::OwnedMatches matches;
  matches.points1 = matches.points2 = Eigen::MatrixXd::Random(50, 2).array() * 300.0 + 320.0;
  matches.size2 = {640, 640};
  CHECK_NOTHROW(EstimateOneFocal(matches, kCamera));
  CHECK(ErrorOf([&] { EstimateSharedFocal(matches); }).starts_with("size1: expected"));
}

TEST_CASE("trouble: copies of the origin won planes and lines") {
  for (const PublicFunction& function : PublicFunctions()) {
    if (!Has(function.name, "Line") && !Has(function.name, "Plane")) continue;
    PointMatrix points(function.points.rows() + 300, function.points.cols());
    points << function.points, PointMatrix::Zero(300, function.points.cols());
    for (Eigen::Index i = function.points.rows(); i < points.rows(); i += 2) points.row(i) *= -1.0;  // −0
    const Answer without = function(function.points), with = function(points);
    CAPTURE(function.name);
    CHECK(with.diagnostics.num_duplicates == 299);
    REQUIRE(with.models.size() == without.models.size());
    for (std::size_t i = 0; i < without.labels.size(); ++i) CHECK(with.labels[i] == without.labels[i]);
  }
}

TEST_CASE("every function: rows that are not finite are left out and counted, and change nothing else") {
  for (const PublicFunction& function : PublicFunctions()) {
    INFO(function.name);
    const Eigen::VectorXd ratios = RatiosFor(function);
    const Answer clean = function(function.points, ratios);
    const Eigen::Index columns = function.points.cols();
    std::vector<int> rows, labels;
    for (int i = 0; i < static_cast<int>(function.points.rows()); ++i)
      for (int copy = 0; copy < (i % 7 == 0 ? 2 : 1); ++copy) rows.push_back(i);
    PointMatrix points = Taken(function.points, rows);
    Eigen::VectorXd with_nan = Taken(ratios, rows);
    int left_out = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool broken = i + 1 < rows.size() && rows[i] == rows[i + 1];
      labels.push_back(broken ? 0 : clean.labels[static_cast<std::size_t>(rows[i])]);
      if (!broken) continue;
      const double values[] = {kNan, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
      points(static_cast<Eigen::Index>(i), left_out % columns) = values[left_out % 3];
      if (with_nan.size() > 0) with_nan[static_cast<Eigen::Index>(i)] = kNan;
      ++left_out;
    }
    const Answer answer = function(points, with_nan);
    CheckSameModels(answer, clean);
    CHECK(answer.labels == labels);
    CHECK(answer.diagnostics.num_nonfinite == left_out);
    CHECK(answer.diagnostics.num_duplicates == 0);
  }
}

TEST_CASE("every function: the order of the rows is of no account where the data are clear") {
  for (const PublicFunction& function : PublicFunctions()) {
    INFO(function.name);
    const Eigen::VectorXd ratios = RatiosFor(function);
    const Answer straight = function(function.points, ratios);
    const std::vector<int> order = Rng(3).Permutation(static_cast<int>(function.points.rows()));
    const Answer turned = function(Taken(function.points, order), Taken(ratios, order));
    CHECK(turned.status == straight.status);
    REQUIRE(turned.models.size() == straight.models.size());
    // Several models may come in another order.
    const std::vector<int> expected = Taken(straight.labels, order);
    std::map<int, std::map<int, int>> common;
    for (std::size_t i = 0; i < order.size(); ++i) ++common[expected[i]][turned.labels[i]];
    int same = 0;
    for (const auto& entry : common) {
      const auto& counts = entry.second;
      same +=
          std::max_element(counts.begin(), counts.end(), [](auto a, auto b) { return a.second < b.second; })->second;
    }
    CAPTURE(same, order.size());
    CHECK(same >= 0.97 * static_cast<double>(order.size()));
  }
}

TEST_CASE("trouble: without a model the mask had no values: it has N, all 0") {
  for (const PublicFunction& function : PublicFunctions()) {
    const auto fails = [&](const PointMatrix& points, Status status) {
      const Answer answer = function(points, Eigen::VectorXd::Constant(function.has_ratios ? points.rows() : 0, 0.5));
      CHECK(answer.status == status);
      CHECK(answer.models.empty());
      CHECK(answer.labels == std::vector<int>(static_cast<std::size_t>(points.rows()), 0));
      return answer;
    };
    INFO(function.name);
    for (const int count : {0, 1, function.minimal - 1}) fails(function.points.topRows(count), Status::kTooFewPoints);
    fails(function.points.row(0).replicate(20, 1), Status::kDegenerate);
    fails(PointMatrix::Zero(20, function.points.cols()), Status::kDegenerate);
    PointMatrix broken = function.points.topRows(20);
    broken.bottomRows(21 - function.minimal).col(1).setConstant(kNan);
    CHECK(fails(broken, Status::kTooFewPoints).diagnostics.num_nonfinite == 21 - function.minimal);
  }
}

TEST_CASE("trouble: matrices that are no calibration were used, one error names the matrix, whatever takes it") {
  const double inf = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d upwards = kCamera, skewed = kCamera, backwards = kCamera, infinite = kCamera, projective = kCamera;
  upwards(1, 1) = -600.0;
  skewed(1, 0) = 3.0;
  backwards(0, 0) = -600.0;
  infinite(0, 2) = inf;
  projective(2, 0) = 1e-3;
  const std::pair<Eigen::Matrix3d, const char*> cases[] = {{kCamera.transpose(), "it is transposed"},
                                                           {2.0 * kCamera.transpose(), "it is transposed"},
                                                           {Eigen::Matrix3d::Zero(), "its last row is not 0 0 1"},
                                                           {-kCamera, "its last row is not 0 0 1"},
                                                           {projective, "its last row is not 0 0 1"},
                                                           {Eigen::Matrix3d::Constant(kNan), "not finite"},
                                                           {infinite, "not finite"},
                                                           {upwards, "where y points up, give height - y for y"},
                                                           {backwards, "its focal lengths are not above 0"},
                                                           {skewed, "its second row does not begin with 0"}};
  for (const PublicFunction& function : PublicFunctions()) {
    if (function.cameras.empty()) continue;
    for (const auto& [K, reason] : cases) {
      const std::string error = ErrorOf([&] { function.call(function.points, {}, K); });
      CAPTURE(function.name, error, reason);
      CHECK(error.rfind(function.cameras[0] + ": expected a calibration matrix", 0) == 0);
      CHECK(Has(error, reason));
    }
  }
  const PublicFunction matches = PublicFunctions().front();
  for (const bool several : {false, true}) {
    const auto call = [&] {
      const CameraPair cameras{kCamera, Eigen::Matrix3d::Zero()};
      if (several) EstimateMultipleEssentials(testing::MatchesOf(matches.points, {}), cameras);
      EstimateEssential(testing::MatchesOf(matches.points, {}), cameras);
    };
    CHECK(Has(ErrorOf(call), "K2: expected a calibration matrix"));
  }
}

TEST_CASE("trouble: twice K halved the threshold, a matrix K times a number is the same camera") {
  for (const PublicFunction& function : PublicFunctions()) {
    if (function.cameras.empty()) continue;
    const Answer expected = function(function.points);
    Eigen::Matrix3d rounded = 2.0 * kCamera;
    rounded(1, 0) = rounded(2, 1) = 1e-13;
    for (const Eigen::Matrix3d& K : {Eigen::Matrix3d(2.0 * kCamera), Eigen::Matrix3d(0.25 * kCamera), rounded}) {
      const Answer answer = function.call(function.points, {}, K);
      CAPTURE(function.name);
      CheckSameModels(answer, expected);
      CHECK(answer.labels == expected.labels);
    }
  }
}

TEST_CASE("trouble: scores and ratios that are none were taken for ratios") {
  for (const PublicFunction& function : PublicFunctions()) {
    if (!function.has_ratios) continue;
    INFO(function.name);
    const Eigen::VectorXd ratios = RatiosFor(function);
    for (const double wrong : {-0.5, -1e-3, 1.01, 300.0, kNan, std::numeric_limits<double>::infinity()}) {
      Eigen::VectorXd some = ratios;
      some[17] = wrong;
      const std::string error = ErrorOf([&] { function(function.points, some); });
      CAPTURE(wrong, error);
      CHECK(error.rfind("snn_ratio: expected the nearest distance over the second-nearest, from 0 to 1", 0) == 0);
      CHECK(Has(error, "in row 17"));
    }
    Eigen::VectorXd single = ratios;
    single[17] = 1.0 + 1e-7;  // Of single precision.
    CHECK(ErrorOf([&] { function(function.points, single); }).empty());
  }
}

TEST_CASE("points outside the given size are an error") {
  const Eigen::Matrix<double, 50, 2> tall =
      (Eigen::MatrixXd::Random(50, 2).array() * 0.5 + 0.5).rowwise() * Eigen::Array2d(480.0, 640.0).transpose();
  testing::OwnedMatches matches{tall, tall};
  matches.size1 = {480, 640};
  for (const ImageSize& good : {ImageSize{480, 640}, ImageSize{640, 640}, ImageSize{}}) {
    matches.size2 = good;
    CHECK(ErrorOf([&] { EstimateFundamental(matches); }).empty());
  }
  // Of another image, (height, width), and points whose origin is the middle.
  matches.size2 = {240, 320};
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches); }), "size2: expected (width, height)"));
  matches.size2 = {640, 480};
  CHECK(Has(ErrorOf([&] { EstimateSharedFocal(matches); }), "(480, 640) holds them"));
  matches.size2 = {480, 640};
  matches.points1.array() -= 240.0;
  CHECK(Has(ErrorOf([&] { EstimateHomography(matches); }), "size1: expected (width, height)"));
  // A few stray ones are none.
  matches.points1 = tall;
  matches.points1.topRows(7).array() = 5000.0;
  matches.points1.row(7).setConstant(kNan);
  CHECK(ErrorOf([&] { EstimateFundamental(matches); }).empty());
  matches.points1.row(8).setConstant(5000.0);
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches); }), "8 of 49 points are outside, first row 0 at (5000, 5000)"));
}

TEST_CASE("sizes, principal points and keypoint changes that make no sense are an error") {
  const PublicFunction function = PublicFunctions().front();
  testing::OwnedMatches matches = testing::MatchesOf(function.points, {});
  matches.size2 = {640, -480};
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches); }), "size2: expected width and height in pixels"));
  matches.size2 = {640, 480};
  FocalOptions options;
  options.principal_point2 = Eigen::Vector2d(320.0, kNan);
  CHECK(Has(ErrorOf([&] { EstimateSharedFocal(matches, options); }), "principal_point2: expected finite pixels"));
  matches.scale_rotation_changes = Eigen::MatrixXd::Zero(function.points.rows(), 2);
  matches.scale_rotation_changes(3, 1) = kNan;
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches); }), "scale_rotation_changes: expected finite values"));
  matches.points2(3, 0) = kNan;
  CHECK(EstimateFundamental(matches).diagnostics.num_nonfinite == 1);
  matches = testing::MatchesOf(function.points, {});
  const auto upright = EstimateFundamental(matches);
  matches.scale_rotation_changes.setZero(function.points.rows(), 2);
  const auto given = EstimateFundamental(matches);
  CHECK((upright.ok() && given.ok()));
  matches.scale_rotation_changes.col(1).setConstant(2.0 * M_PI);
  CHECK(EstimateFundamental(matches).model == given.model);  // A full turn is none.
  matches.scale_rotation_changes.resize(7, 2);
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches); }), "scale_rotation_changes: expected one for each of"));
  matches.scale_rotation_changes.resize(0, 2);
  matches.snn_ratio.setOnes(7);
  CHECK(Has(ErrorOf([&] { EstimateFundamental(matches); }), "snn_ratio: expected one for each of"));
}

}  // namespace diffsac
