#include "lab/eval/digest.h"

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

// FIPS 180-2's examples.
TEST_CASE("digests are SHA-256, in one piece or in several") {
  CHECK(DigestOfText("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(DigestOfText("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  Digest digest;
  digest.Add("a", 1);
  digest.Add("bc", 2);
  CHECK(digest.Hex() == DigestOfText("abc"));
  CHECK(digest.Hex() == DigestOfText(""));
}

TEST_CASE("a file's digest is its content's") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("x"), "abc");
  CHECK(DigestOfFile(folder.File("x")) == DigestOfText("abc"));
  CHECK_THROWS_AS(DigestOfFile(folder.File("y")), Error);
}

}  // namespace
}  // namespace diffsac
