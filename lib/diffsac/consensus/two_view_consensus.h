#pragma once

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"

namespace diffsac {

DIFFSAC_CONSENSUS_TEMPLATES(extern, Homography)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Fundamental)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Fundamental8)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Essential)

}  // namespace diffsac
