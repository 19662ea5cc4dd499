#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/shared_focal.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(OneFocal)

}  // namespace diffsac
