#pragma once

#include "diffsac/consensus/sample_consensus_impl.h"
#include "diffsac/consensus/structures/structures_impl.h"

/// Everything of this folder that is compiled for a model, in namespace diffsac.
#define DIFFSAC_INSTANTIATE_CONSENSUS(Model)                                                                           \
  template ConsensusResult SearchCheckedPoints<Model>(                                                                 \
      const PointMatrix&, double, MinimalSampler&, const ConsensusOptions&, const Rng&, const EstimationPriors&, int); \
  template StructuresResult FindStructures<Model>(const PointMatrix&, double, const SamplerOfRows&,                    \
                                                  const ConsensusOptions&, const StructureSearchOptions&, const Rng&,  \
                                                  const EstimationPriors&);
