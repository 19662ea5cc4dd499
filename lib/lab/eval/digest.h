#pragma once

#include <nettle/sha2.h>

#include <cstddef>
#include <string>

#include "lab/files/files.h"

namespace diffsac {

/// SHA-256 of what is added, as `sha256sum` prints it.
class Digest {
 public:
  Digest() { sha256_init(&context_); }
  void Add(const void* bytes, std::size_t size) {
    sha256_update(&context_, size, static_cast<const std::uint8_t*>(bytes));
  }
  /// 64 hexadecimal digits; the digest then begins anew.
  std::string Hex() {
    std::uint8_t bytes[SHA256_DIGEST_SIZE];
    sha256_digest(&context_, sizeof(bytes), bytes);
    std::string text;
    for (const std::uint8_t byte : bytes)
      for (const int digit : {byte >> 4, byte & 15}) text += "0123456789abcdef"[digit];
    return text;
  }

 private:
  sha256_ctx context_;
};

/// Of a text, and of a file's content. Throws Error where it cannot be read.
inline std::string DigestOfText(const std::string& text) {
  Digest digest;
  digest.Add(text.data(), text.size());
  return digest.Hex();
}
inline std::string DigestOfFile(const std::string& path) { return DigestOfText(ReadFile(path)); }

}  // namespace diffsac
