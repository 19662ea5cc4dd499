#include "lab/eval/digest.h"

#include <nettle/sha2.h>

#include "lab/files/files.h"

namespace diffsac {

struct Digest::State {
  sha256_ctx context;
};

Digest::Digest() : state_(std::make_unique<State>()) { sha256_init(&state_->context); }
Digest::~Digest() = default;

void Digest::Add(const void* bytes, std::size_t size) {
  sha256_update(&state_->context, size, static_cast<const std::uint8_t*>(bytes));
}

std::string Digest::Hex() {
  std::uint8_t bytes[SHA256_DIGEST_SIZE];
  sha256_digest(&state_->context, sizeof(bytes), bytes);
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::string DigestOfText(const std::string& text) {
  Digest digest;
  digest.Add(text.data(), text.size());
  return digest.Hex();
}

std::string DigestOfFile(const std::string& path) { return DigestOfText(ReadFile(path)); }

}  // namespace diffsac
