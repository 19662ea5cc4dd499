#include "diffsac/consensus/mixture_impl.h"
#include "diffsac/consensus/sample_consensus_impl.h"
#include "diffsac/consensus/two_view_consensus.h"

namespace diffsac {

DIFFSAC_MIXTURE_TEMPLATES(, Fundamental)
DIFFSAC_CONSENSUS_TEMPLATES(, Fundamental)

}  // namespace diffsac
