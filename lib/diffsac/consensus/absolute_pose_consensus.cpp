#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/absolute_pose.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(AbsolutePose)

}  // namespace diffsac
