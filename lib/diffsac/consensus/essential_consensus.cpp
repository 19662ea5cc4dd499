#include "diffsac/consensus/instantiate.h"
#include "diffsac/geometry/essential.h"

namespace diffsac {

DIFFSAC_INSTANTIATE_CONSENSUS(Essential)

}  // namespace diffsac
