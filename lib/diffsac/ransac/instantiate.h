#pragma once

#include "diffsac/ransac/instances/instances_impl.h"
#include "diffsac/ransac/sample_consensus_impl.h"

/// Everything of this folder that is compiled for a model, in namespace diffsac.
#define DIFFSAC_INSTANTIATE_CONSENSUS(Model)                                                                           \
  template ConsensusResult SearchCheckedPoints<Model>(                                                                 \
      const PointMatrix&, double, MinimalSampler&, const ConsensusOptions&, const Rng&, const EstimationPriors&, int); \
  template InstancesResult FindInstances<Model>(const PointMatrix&, double, const SamplerOfRows&,                      \
                                                const ConsensusOptions&, const InstanceSearchOptions&, const Rng&,     \
                                                const EstimationPriors&);
