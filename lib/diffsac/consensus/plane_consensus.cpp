#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/hyperplane.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(Plane)

}  // namespace diffsac
