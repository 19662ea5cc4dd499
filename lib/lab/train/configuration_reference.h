#pragma once

#include <string>

namespace diffsac {

/// What docs/configuration.md has behind configuration_head.md: every key of the programs' configurations with its
/// default, its limits and its meaning, as the descriptions in the code have them (`diffsac_train --describe-options`;
/// the build target diffsac_reference writes the file).
std::string ConfigurationReference();

}  // namespace diffsac
