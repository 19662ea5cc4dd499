#include "diffsac/consensus/mixture_impl.h"
#include "diffsac/consensus/sample_consensus_impl.h"
#include "diffsac/geometry/absolute_pose.h"

namespace diffsac {

DIFFSAC_MIXTURE_TEMPLATES(, AbsolutePose)
DIFFSAC_CONSENSUS_TEMPLATES(, AbsolutePose)

}  // namespace diffsac
