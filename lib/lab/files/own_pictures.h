#pragma once

#include <string>
#include <string_view>

namespace diffsac {

/// An encoded picture of any format with a mark that says that it was drawn by one of our programs: a text of PNG, else
/// behind the end, where readers of pictures do not look.
std::string MarkedAsOwn(std::string_view picture);

/// Whether a file has the mark, and so is no photograph, wherever it lies. False where there is no such file.
bool IsOwnPicture(const std::string& path);

/// The same with a line in the log, for what lists photographs.
bool PassOverOwnPicture(const std::string& path);

/// Throws Error where there is a file that is no picture of our programs: they do not replace others.
void RefuseOtherPicture(const std::string& path);

}  // namespace diffsac
