#pragma once

#include <filesystem>
#include <string>

namespace diffsac {

/// A name in the folder of `path` for what is to become `path`: unused, hidden, with the same extension, and saying
/// which process of which machine writes it. The process's first call for a folder removes what killed processes left
/// there.
std::string TemporaryBeside(const std::filesystem::path& path);

/// Removes temporary files of this machine whose process is no more, and those of any machine that nobody wrote to for
/// a day.
void RemoveLeftOver(const std::filesystem::path& folder);

}  // namespace diffsac
