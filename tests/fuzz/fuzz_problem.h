#pragma once

#include <string>
#include <vector>

#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "fuzz/byte_reader.h"
#include "lab/baselines/dgsac.h"

namespace diffsac::testing {

/// Where the minimal sets of a problem come from.
enum class SetsFrom { kSource, kWeights, kConfidences, kGiven };

/// One call of SampleConsensus, FindInstances or EstimateDgsac, read from bytes. Options are such as their Bind lets
/// pass.
struct FuzzProblem {
  PointMatrix points;
  double threshold = 1.0;
  ConsensusOptions options;
  InstanceSearchOptions instances;
  DgsacOptions dgsac;
  SetsFrom sets_from = SetsFrom::kSource;
  MinimalSamplerOptions source;
  std::vector<double> snn_ratio;   ///< one a point, and what kWeights draws in proportion to
  std::vector<float> confidences;  ///< some rows of one a point
  bool likeliest_sets = false;     ///< of the confidences
  bool unique_sets = false;        ///< of the confidences
  double temperature = 1.0;        ///< of the confidences
  std::vector<int> minimal_sets;   ///< indices out of range among them
  EstimationPriors priors;
  std::uint64_t seed = 0;
  int threads = 1;
  int other_block = 0;
};

/// Points of any values; points of a true model, with noise; either of them with rows repeated, set collinear, coplanar
/// or spoilt, and scaled.
FuzzProblem ReadProblem(ByteReader* reader, int dimension, int minimal_size, int parameters);

}  // namespace diffsac::testing
