#include "diffsac/consensus/sample_consensus.h"

#include "diffsac/consensus/mixture_impl.h"
#include "diffsac/consensus/sample_consensus_impl.h"

namespace diffsac {

DIFFSAC_MIXTURE_TEMPLATES(, Line)
DIFFSAC_MIXTURE_TEMPLATES(, Plane)
DIFFSAC_CONSENSUS_TEMPLATES(, Line)
DIFFSAC_CONSENSUS_TEMPLATES(, Plane)

}  // namespace diffsac
