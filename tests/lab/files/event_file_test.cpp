// The golden values of checksums are those of RFC 3720, B.4; the bytes of a record were written by TensorBoard's own
// writer (tensorboard 2.21, tensorboard/summary/writer/record_writer.py).
#include "lab/files/event_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;

std::string FromHex(const std::string& digits) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  return bytes;
}

/// The bytes of a file of these iterations, as it would be without an interruption, less the times.
std::string Steps(const std::string& bytes) {
  std::string text;
  std::size_t at = WholeRecords(bytes, 0);
  for (int step = 1; step < 100; ++step) {
    const std::size_t next = WholeRecords(bytes, step);
    if (next > at) text += std::to_string(step) + " ";
    at = next;
  }
  return text;
}

}  // namespace

TEST_CASE("checksums are those of the standard") {
  CHECK(Crc32c("123456789") == 0xE3069283U);
  CHECK(Crc32c(std::string(32, '\0')) == 0x8A9136AAU);
  CHECK(Crc32c(std::string(32, '\xFF')) == 0x62A8AB43U);
  CHECK(Crc32c("") == 0U);
}

TEST_CASE("records are those of TensorBoard's writer") {
  CHECK(VersionRecord(1.5) ==
        FromHex("1800000000000000a37f4b2209000000000000f83f1a0d627261696e2e4576656e743a322a28646c"));
  CHECK(EventRecord({2.5, 300, {{"loss", 0.25}, {"mAA@0.5deg", 0.75}}}) ==
        FromHex("2e00000000000000c5cb57fa09000000000000044010ac022a200a0b0a046c6f7373150000803e0a110a0a6d4141"
                "40302e35646567150000403fc7b9e204"));
}

TEST_CASE("a file keeps the whole records up to an iteration, and grows") {
  const TemporaryFolder folder;
  const std::string path = folder.File("events.out.tfevents.x");
  {
    EventFile file(path, 0);
    CHECK_FALSE(std::filesystem::exists(path));
    file.Begin();
    for (const int step : {10, 20, 300}) file.Add(step, {{"loss", 1.0 / step}, {"mAA", std::nan("")}});
  }
  const std::string whole = ReadFile(path);
  CHECK(WholeRecords(whole, 300) == whole.size());
  CHECK_THAT(whole, Contains("loss") && !Contains("mAA"));
  CHECK(Steps(whole) == "10 20 ");

  SECTION("an interrupted run's last events go") {
    EventFile resumed(path, 20);
    CHECK(ReadFile(path) == whole);
    resumed.Begin();
    CHECK(ReadFile(path) == whole.substr(0, WholeRecords(whole, 20)));
    resumed.Add(30, {{"loss", 0.5}});
    CHECK(Steps(ReadFile(path)) == "10 20 30 ");
  }
  SECTION("half a record goes, wherever it is cut") {
    for (std::size_t size = whole.size() - 1; size > WholeRecords(whole, 20); size -= 7) {
      WriteFileAtomically(path, whole.substr(0, size));
      EventFile resumed(path, 300);
      resumed.Begin();
      CHECK(ReadFile(path) == whole.substr(0, WholeRecords(whole, 20)));
    }
  }
  SECTION("a damaged record and what follows it go") {
    std::string damaged = whole;
    damaged[WholeRecords(whole, 10) + 20] ^= 1;
    WriteFileAtomically(path, damaged);
    EventFile(path, 300).Begin();
    CHECK(Steps(ReadFile(path)) == "10 ");
  }
  SECTION("a new run begins anew") {
    EventFile(path, 0).Begin();
    CHECK(Steps(ReadFile(path)).empty());
  }
}

TEST_CASE("a file that cannot be written is named") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(EventFile(folder.File("absent/events.tfevents"), 0).Begin(), Contains("absent/events.tfevents"));
  CHECK_THROWS_WITH(EventFile("/dev/full", 0).Begin(), Contains("/dev/full"));
}

}  // namespace diffsac
