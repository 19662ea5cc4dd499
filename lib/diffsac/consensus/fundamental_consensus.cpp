#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/fundamental.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(Fundamental)

}  // namespace diffsac
