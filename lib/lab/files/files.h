#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace diffsac {

/// Writes a whole file or leaves the old one: temporary file beside it, fsync, rename. Throws Error naming the path
/// and the cause (full disk, read-only folder). A symbolic link stays one; a device or pipe is written in place. What a
/// process that was killed left beside it goes with the next one's first file there.
void WriteFileAtomically(const std::string& path, std::string_view content);

/// The same for a library that writes to a path itself: `write` gets the temporary path (same extension).
/// A standard exception from `write` becomes an Error that names the path.
void WriteFileAtomically(const std::string& path, const std::function<void(const std::string& temporary)>& write);

/// Throws Error naming the path and the cause.
std::string ReadFile(const std::string& path);

/// The same of a text in UTF-8: without the byte order mark that some programs put before it, and with "\n" where lines
/// end in a carriage return alone. Throws Error, too, for UTF-16 and UTF-32, naming the encoding and what helps, and
/// for a text with zero bytes, naming the line.
std::string ReadTextFile(const std::string& path);

/// Throws Error, naming both, where one of `outputs` is one of `inputs`, or a file that lies directly in an input that
/// is a folder, however it is spelt or linked; and where two of the outputs are one file. Empty names are none, devices
/// may be both.
void RefuseInputsAsOutputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

/// Removes a file if it is there. Throws Error naming the path and the cause.
void RemoveFile(const std::string& path);

/// Creates a folder and its parents, and checks that files can be written there. Throws Error otherwise.
void MakeWritableFolder(const std::string& path);

/// A name in the folder of `path` for what is to become `path`: unused, hidden, with the same extension, and saying
/// which process of which machine writes it. The process's first call for a folder removes what killed processes left
/// there.
std::string TemporaryBeside(const std::filesystem::path& path);

/// Removes temporary files of this machine whose process is no more, and those of any machine that nobody wrote to for
/// a day.
void RemoveLeftOver(const std::filesystem::path& folder);

}  // namespace diffsac
