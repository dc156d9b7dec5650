#include "base/files/check_sums.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(CheckSum, ChangesWithEveryByteAndWithTheLength) {
  const std::string text = "nineteen characters";
  std::vector<std::uint64_t> sums = {check_sum(text), check_sum(text + '\0'), check_sum("")};
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] ^= 1;
    sums.push_back(check_sum(changed));
  }
  std::sort(sums.begin(), sums.end());
  EXPECT_EQ(std::adjacent_find(sums.begin(), sums.end()), sums.end());
}

TEST(LineSum, IsRemovedIfItMatches) {
  const std::string line = R"({"id":"a","n":1})", summed = with_sum(line);
  EXPECT_TRUE(has_sum(summed));
  EXPECT_EQ(summed.substr(0, 8), R"({"sum":")");
  EXPECT_EQ(without_sum(summed), line);
}

TEST(LineSum, MatchesNoOtherLine) {
  std::string summed = with_sum(R"({"id":"a","n":1})");
  summed[summed.size() - 2] = '2';
  EXPECT_EQ(without_sum(summed), "");
  EXPECT_EQ(without_sum(R"({"id":"a"})"), "");
  EXPECT_EQ(without_sum(R"({"sum":"0)"), "");
  EXPECT_FALSE(has_sum(R"({"id":"a"})"));
}

// Vectors of FIPS 180-2, appendix B.
TEST(Sha256, GivesThePublishedDigests) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

// Digests from Python's hashlib.
TEST(Sha256, PadsTextsOfAnyLength) {
  const std::pair<std::size_t, const char*> digests[] = {
      {55, "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318"},
      {56, "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a"},
      {63, "7d3e74a05d7db15bce4ad9ec0658ea98e3f06eeecf16b4c6fff2da457ddc2f34"},
      {64, "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb"},
      {119, "31eba51c313a5c08226adf18d4a359cfdfd8d2e816b13f4af952f7ea6584dcfb"},
      {120, "2f3d335432c70b580af0e8e1b3674a7c020d683aa5f73aaaedfdc55af904c21c"}};
  for (const auto& [length, digest] : digests)
    EXPECT_EQ(sha256(std::string(length, 'a')), digest) << length;
}

}  // namespace
}  // namespace conddp
