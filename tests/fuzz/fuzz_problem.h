#pragma once

#include <string>
#include <vector>

#include "diffsac/consensus/make_source.h"
#include "diffsac/consensus/sample_consensus.h"
#include "fuzz/byte_reader.h"

namespace diffsac::testing {

/// One call of SampleConsensus, read from bytes. Options are such as ConsensusOptions::Bind lets pass.
struct FuzzProblem {
  PointMatrix points;
  double threshold = 1.0;
  ConsensusOptions options;
  SourceOptions source;
  std::vector<double> quality;    ///< one a point
  bool use_weights = false;       ///< sets are drawn in proportion to the quality
  bool use_given_sets = false;    ///< sets are minimal_sets
  std::vector<int> minimal_sets;  ///< indices out of range among them
  ConsensusHints hints;
  std::uint64_t seed = 0;
  int threads = 1;
  int other_block = 0;
};

/// Points of any values; points of a true model, with noise; either of them with rows repeated, set collinear, coplanar
/// or spoilt, and scaled.
FuzzProblem ReadProblem(ByteReader* reader, int dimension, int minimal_size, int parameters);

}  // namespace diffsac::testing
