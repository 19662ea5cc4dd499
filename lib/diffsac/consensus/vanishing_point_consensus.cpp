#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/vanishing_point.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(VanishingPoint)

}  // namespace diffsac
