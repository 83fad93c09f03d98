/// State files: what is written is what is read, and no damage passes.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <random>

#include "nanoweft/base/digest.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/state/state_signature.hpp"
#include "state_helpers.hpp"

namespace nanoweft::test {
namespace {

TEST(StateFile, GivesBackEveryFieldWithItsBits) {
  const Place place;
  writeTestState(place / "s.h5");
  const StateHeader header = readStateHeader(PETSC_COMM_SELF, place / "s.h5");
  EXPECT_EQ(header.rows, 7);
  EXPECT_TRUE(header.anyBroken);
  EXPECT_EQ(header.run.reals, testRecord().reals);
  EXPECT_EQ(header.run.integers, testRecord().integers);
  EXPECT_EQ(header.run.texts, testRecord().texts);
  State written(PETSC_COMM_SELF, testBox(), {.gap = true, .viscous = true}),
      read(PETSC_COMM_SELF, header.box, {.gap = true, .viscous = true});
  fillState(written);
  readStateRows(place / "s.h5", header, read);
  ASSERT_EQ(read.owned(), 7);
  EXPECT_EQ(read.step, 42);
  EXPECT_EQ(read.time, 0.1 + 0.2);
  auto same = [](const auto* a, const auto* b, int count) { return std::equal(a, a + count, b); };
  EXPECT_TRUE(same(read.fibre, written.fibre, 7));
  EXPECT_TRUE(same(read.chain, written.chain, 14));
  EXPECT_TRUE(same(read.bond, written.bond, 7));
  EXPECT_TRUE(same(read.group, written.group, 7));
  EXPECT_TRUE(same(read.image, written.image, 21));
  EXPECT_TRUE(same(read.velocity, written.velocity, 21));
  EXPECT_TRUE(same(read.angular, written.angular, 21));
  EXPECT_TRUE(same(read.gap, written.gap, 28));
  EXPECT_TRUE(same(read.viscous, written.viscous, 42));
  for (int i = 0; i < 7; ++i) {
    EXPECT_TRUE(same(read.pose + 8 * i, written.pose + 8 * i, 3));
    EXPECT_TRUE(same(read.pose + 8 * i + 4, written.pose + 8 * i + 4, 4));
  }
}

TEST(StateFile, KeepsOptionsOfAnyLength) {
  const Place place;
  for (const std::size_t length : {31999u, 40000u, 200000u}) {
    const std::string options = "-bc " + std::string(length, 'n') + "\n";
    writeTestState(place / "s.h5", options);
    EXPECT_EQ(provenanceOf(readStateHeader(PETSC_COMM_SELF, place / "s.h5").run), testRun(options));
    std::filesystem::remove(place / "s.h5");
  }
}

TEST(StateFile, BeginsWithTheDigestOfAllBehind) {
  const Place place;
  writeTestState(place / "s.h5");
  const std::string bytes = bytesOf(place / "s.h5"), behind = bytes.substr(signatureBytes);
  Sha256 sum;
  sum.add(behind.data(), behind.size());
  EXPECT_NE(bytes.substr(0, signatureBytes).find(": " + sum.digest() + "\n"), std::string::npos);
  EXPECT_EQ(readStateHeader(PETSC_COMM_SELF, place / "s.h5").digest, sha256OfFile(place / "s.h5"));
}

TEST(Sha256, IsThatOfTheStandard) {
  const Place place;
  setBytes(place / "abc", "abc");
  EXPECT_EQ(sha256OfFile(place / "abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  Sha256 pieces;
  pieces.add("a", 1), pieces.add("bc", 2);
  EXPECT_EQ(pieces.digest(), sha256OfFile(place / "abc"));
  EXPECT_THROW(sha256OfFile(place / "none"), InputError);
}

TEST(StateFile, NoFlippedByteIsAccepted) {
  const Place place;
  writeTestState(place / "s.h5");
  const std::string bytes = bytesOf(place / "s.h5");
  std::mt19937 random(13);
  for (int k = 0; k < 600; ++k) {
    std::string damaged = bytes;
    // Half of them in the first 4 kB, where names and headers stand.
    const std::size_t at = random() % (k % 2 ? damaged.size() : 4096);
    damaged[at] ^= static_cast<char>(1 + random() % 255);
    setBytes(place / "x.h5", damaged);
    EXPECT_NE(stateFileProblem(place / "x.h5"), "") << "byte " << at;
#ifndef __SANITIZE_ADDRESS__
    // Whoever says that he changed it gets no crash either. (The sanitizer would end the test where
    // HDF5 reads beyond its own buffers.)
    stateFileProblem(place / "x.h5", Trust::edited);
#endif
  }
  for (std::size_t length = 0; length < bytes.size(); length += 997) {
    setBytes(place / "x.h5", bytes.substr(0, length));
    EXPECT_NE(stateFileProblem(place / "x.h5"), "") << "cut after " << length;
  }
  setBytes(place / "x.h5", bytes + '\0');
  EXPECT_NE(stateFileProblem(place / "x.h5"), "");
}

TEST(StateFile, WithoutItsFirstLineIsRefusedUnlessEdited) {
  const Place place;
  writeTestState(place / "s.h5");
  std::string bytes = bytesOf(place / "s.h5");
  std::fill_n(bytes.begin(), signatureBytes, '\0');
  setBytes(place / "s.h5", bytes);
  EXPECT_NE(stateFileProblem(place / "s.h5").find("SHA-256 is gone"), std::string::npos);
  EXPECT_EQ(stateFileProblem(place / "s.h5", Trust::edited), "");
}

/// Limits the size of files while it lives.
class SizeLimit {
 public:
  explicit SizeLimit(std::size_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    struct rlimit now = before_;
    now.rlim_cur = bytes;
    old_ = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &now);
  }
  ~SizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, old_);
  }
  SizeLimit(const SizeLimit&) = delete;
  SizeLimit& operator=(const SizeLimit&) = delete;

 private:
  struct rlimit before_ {};
  void (*old_)(int);
};

TEST(StateFile, DiskThatIsFullAtAnyByteLeavesTheOldFileAlone) {
  const Place place;
  writeTestState(place / "s.h5");
  const std::string bytes = bytesOf(place / "s.h5");
  for (std::size_t most = 0; most < bytes.size(); most += bytes.size() / 60) {
    std::string said;
    {
      const SizeLimit limit(most);
      try {
        writeTestState(place / "s.h5");
      } catch (const RunError& problem) {
        said = problem.what();
      }
    }
    EXPECT_EQ(said, "cannot write " + place / "s.h5" + ": File too large") << most;
    EXPECT_TRUE(bytesOf(place / "s.h5") == bytes);
    EXPECT_EQ(place.names(), "s.h5 ");
  }
  writeTestState(place / "s.h5");
  EXPECT_TRUE(bytesOf(place / "s.h5") == bytes);
}

TEST(StateFile, LeavesNoFileOpen) {
  const Place place;
  auto open = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"),
                         std::filesystem::directory_iterator());
  };
  writeTestState(place / "s.h5");
  setBytes(place / "bad.h5", "no state");
  const auto before = open();
  for (int k = 0; k < 3; ++k) {
    writeTestState(place / "s.h5");
    readStateHeader(PETSC_COMM_SELF, place / "s.h5");
    stateFileProblem(place / "bad.h5");
    const SizeLimit limit(3000);
    EXPECT_THROW(writeTestState(place / "s.h5"), RunError);
  }
  EXPECT_EQ(open(), before);
}

}  // namespace
}  // namespace nanoweft::test
