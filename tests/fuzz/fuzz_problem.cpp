#include "fuzz/fuzz_problem.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/ransac/option_names.h"
#include "lab/options/options.h"

namespace diffsac::testing {
namespace {

int ReadCount(ByteReader* reader, int minimal_size) {
  switch (reader->Below(8)) {
    case 0:
      return reader->Below(minimal_size + 1);
    case 1:
      return minimal_size + reader->Below(3);
    case 2:
      return 64 + reader->Below(200);
    default:
      return minimal_size + reader->Below(40);
  }
}

PointMatrix AnyPoints(ByteReader* reader, int count, int dimension) {
  PointMatrix points(count, dimension);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < dimension; ++j) points(i, j) = reader->Number();
  return points;
}

/// Lines and planes: points near the first axes. Correspondences: two views of space points, some of them on a plane.
/// Absolute poses: such space points and one view of them.
PointMatrix ModelPoints(ByteReader* reader, int count, int dimension) {
  Rng rng(reader->Word());
  const double noise = reader->Below(4) * 0.1, outliers = reader->Below(8) / 8.0, on_plane = reader->Below(4) / 3.0;
  const bool rotation_only = reader->Below(8) == 0;
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.3 * rng.Uniform(), Eigen::Vector3d(rng.Normal(), rng.Normal(), 1.0).normalized())
          .toRotationMatrix();
  const Eigen::Vector3d translation =
      rotation_only ? Eigen::Vector3d::Zero().eval() : Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
  PointMatrix points(count, dimension);
  for (int i = 0; i < count; ++i) {
    const bool outlier = rng.Uniform() < outliers;
    if (dimension < 4) {
      for (int j = 0; j < dimension; ++j) points(i, j) = rng.Uniform(-10.0, 10.0);
      if (!outlier) points(i, dimension - 1) = noise * rng.Normal();
      continue;
    }
    Eigen::Vector3d first(rng.Uniform(-4.0, 4.0), rng.Uniform(-4.0, 4.0), 6.0);
    if (rng.Uniform() >= on_plane) first[2] += rng.Uniform(-2.0, 4.0);
    const Eigen::Vector3d second = rotation * first + translation;
    if (dimension == 5) {
      points.row(i) << first.transpose(), second.head<2>().transpose() / second[2];
      for (int j = 3; j < 5; ++j) points(i, j) += outlier ? rng.Uniform(-1.0, 1.0) : 0.01 * noise * rng.Normal();
      continue;
    }
    points.row(i) << 100.0 * first.head<2>().transpose() / first[2], 100.0 * second.head<2>().transpose() / second[2];
    for (int j = 0; j < 4; ++j) points(i, j) += noise * rng.Normal();
    if (outlier)
      for (int j = 0; j < 4; ++j) points(i, j) = rng.Uniform(-100.0, 100.0);
  }
  return points;
}

void Spoil(ByteReader* reader, PointMatrix* points) {
  if (points->size() == 0) return;
  const auto row = [&] { return static_cast<Eigen::Index>(reader->Word() % points->rows()); };
  const auto column = [&] { return static_cast<Eigen::Index>(reader->Below(static_cast<int>(points->cols()))); };
  for (int times = reader->Below(8); times > 0; --times) {
    switch (reader->Below(6)) {
      case 0:  // One value.
        (*points)(row(), column()) = reader->Number();
        break;
      case 1: {  // Many copies of one point.
        const Eigen::RowVectorXd copied = points->row(row());
        for (Eigen::Index i = row(); i < points->rows(); ++i) points->row(i) = copied;
        break;
      }
      case 2:  // A constant coordinate.
        points->col(column()).setConstant(reader->Number());
        break;
      case 3: {  // Collinear in two coordinates.
        const Eigen::Index from = column(), to = column();
        points->col(to) = points->col(from);
        break;
      }
      case 4:  // Integers, so that ties and exact fits are common.
        *points = points->array().round();
        break;
      case 5:
        *points *= reader->Positive();
        break;
    }
  }
}

template <NamedEnum Enum>
Enum Choose(ByteReader* reader) {
  return kEnumNames<Enum>[reader->Below(static_cast<int>(kEnumNames<Enum>.size()))].value;
}

ConsensusOptions ReadOptions(ByteReader* reader) {
  ConsensusOptions options;
  options.score = Choose<ScoreKind>(reader);
  options.final_score = Choose<ScoreKind>(reader);
  options.local_optimization = Choose<LocalOptimization>(reader);
  options.refit = Choose<Refit>(reader);
  options.final_refinement = Choose<FinalRefinement>(reader);
  options.stopping = Choose<Stopping>(reader);
  options.max_iterations = 1 + reader->Below(40);
  options.min_iterations = reader->Below(50);
  options.confidence = reader->Byte() / 256.0;
  options.block_size = reader->Below(5);
  options.local_samples = reader->Below(4);
  options.irls_rounds = 1 + reader->Below(6);
  options.graph_neighbors = 1 + reader->Below(10);
  options.refit_rounds = 1 + reader->Below(4);
  options.refit_candidates = 1 + reader->Below(4);
  options.residual_dof = reader->Below(7);
  options.threshold = Choose<ThresholdKind>(reader);
  if (reader->Below(4) == 0) options.inlier_prior_power = reader->Positive();
  if (reader->Below(4) == 0) options.camera_prior = reader->Positive();
  if (reader->Below(3) == 0) {
    options.least_scale = reader->Positive();
    options.greatest_scale = options.least_scale * (1.0 + reader->Positive());
  }
  if (reader->Below(4) == 0) {
    options.score_threshold_factor = reader->Positive();
    options.sigma_factor = reader->Positive();
    options.refit_threshold_factor = reader->Positive();
    options.sigma_prior = reader->Positive();
    options.spatial_weight = std::min(1e3, reader->Positive());
    options.inlier_prior = std::clamp(reader->Byte() / 256.0, 0.001, 0.999);
  }
  return options;
}

InstanceSearchOptions ReadInstances(ByteReader* reader) {
  InstanceSearchOptions options;
  options.search = Choose<InstanceSearch>(reader);
  options.most = 1 + reader->Below(6);
  options.log10_nfa = reader->Number();
  options.least_chance = reader->Byte() / 255.0;
  options.rounds = reader->Below(4);
  return options;
}

DgsacOptions ReadDgsac(ByteReader* reader) {
  DgsacOptions options;
  options.max_iterations = 1 + reader->Below(60);
  options.stopping = Choose<DgsacStopping>(reader);
  options.refit_rounds = reader->Below(7);
  return options;
}

void ReadPriors(ByteReader* reader, int count, int parameters, EstimationPriors* priors) {
  for (int hint = reader->Below(8) - 5; hint > 0; --hint) {
    ModelParameters model(reader->Below(16) == 0 ? reader->Below(12) : parameters);
    for (double& value : model) value = reader->Number();
    priors->models.push_back(model);
  }
  const auto read = [&](Eigen::VectorXd* values) {
    values->resize(reader->Below(8) == 0 ? reader->Below(10) : count);
    for (double& value : *values) value = reader->Number();
  };
  if (reader->Below(8) == 0) read(&priors->fit_weights);
  if (reader->Below(4) == 0) read(&priors->inlier_priors);
  if (reader->Below(4) == 0) priors->unit = reader->Positive();
  if (reader->Below(4) != 0) return;
  CameraPrior cameras{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), reader->Positive()};
  for (int i = 0; i < 3; ++i) cameras.K1(i, i) = reader->Number();
  if (reader->Flag())
    for (double& value : cameras.K2.reshaped()) value = reader->Number();
  priors->cameras = cameras;
}

void ReadSource(ByteReader* reader, FuzzProblem* problem) {
  constexpr SetsFrom kOrigins[] = {SetsFrom::kSource,  SetsFrom::kSource,      SetsFrom::kSource,
                                   SetsFrom::kWeights, SetsFrom::kConfidences, SetsFrom::kGiven};
  problem->sets_from = kOrigins[reader->Below(6)];
  problem->source.sampler = Choose<MinimalSamplerKind>(reader);
  problem->source.napsac_neighbors = 1 + reader->Below(30);
  problem->likeliest_sets = reader->Flag();
  problem->unique_sets = reader->Flag();
  problem->temperature = reader->Positive();
}

}  // namespace

FuzzProblem ReadProblem(ByteReader* reader, int dimension, int minimal_size, int parameters) {
  FuzzProblem problem;
  problem.options = ReadOptions(reader);
  problem.instances = ReadInstances(reader);
  problem.dgsac = ReadDgsac(reader);
  ReadSource(reader, &problem);
  problem.seed = reader->Byte();
  problem.threads = 1 + reader->Below(3);
  problem.other_block = reader->Below(70);
  problem.threshold = reader->Below(8) == 0 ? reader->Number() : reader->Positive();

  const int count = ReadCount(reader, minimal_size);
  const int columns = reader->Below(32) == 0 ? reader->Below(6) : dimension;
  const bool any = reader->Below(3) == 0 || columns != dimension;
  // Sizes first, the numbers last: bytes that run out leave points, not options, at zero.
  const bool given = problem.sets_from == SetsFrom::kGiven;
  const int num_sets = given ? reader->Below(20) * minimal_size + reader->Below(2) : 0;
  for (int i = 0; i < num_sets; ++i) {
    const int index = reader->Byte();
    problem.minimal_sets.push_back(index < 250 ? index % std::max(1, count) : index - 253);
  }
  ReadPriors(reader, count, parameters, &problem.priors);
  if (problem.sets_from == SetsFrom::kConfidences) {
    problem.confidences.resize(static_cast<std::size_t>(count) * reader->Below(5));
    for (float& confidence : problem.confidences) confidence = static_cast<float>(reader->Number());
  }
  problem.snn_ratio.resize(count);
  const bool any_quality = reader->Below(4) == 0;
  for (int i = 0; i < count; ++i) problem.snn_ratio[i] = any_quality ? reader->Number() : i % 7;
  problem.points = any ? AnyPoints(reader, count, columns) : ModelPoints(reader, count, dimension);
  if (reader->Flag()) Spoil(reader, &problem.points);
  return problem;
}

}  // namespace diffsac::testing
