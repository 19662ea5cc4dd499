#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace diffsac {

/// SHA-256 of what is added, as `sha256sum` prints it.
class Digest {
 public:
  Digest();
  ~Digest();
  void Add(const void* bytes, std::size_t size);
  /// 64 hexadecimal digits; the digest then begins anew.
  std::string Hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of a text, and of a file's content. Throws Error where it cannot be read.
std::string DigestOfText(const std::string& text);
std::string DigestOfFile(const std::string& path);

}  // namespace diffsac
