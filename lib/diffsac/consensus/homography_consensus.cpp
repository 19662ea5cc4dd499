#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/homography.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(Homography)

}  // namespace diffsac
