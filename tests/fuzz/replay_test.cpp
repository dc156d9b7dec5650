// Fuzz targets on their seeds and on reproducible mutations of them. The seeds include earlier
// findings of libFuzzer (scripts/fuzz).
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "fuzz/targets.hpp"
#include "support/random_numbers.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

const std::filesystem::path kFolder = source_tree() / "tests/fuzz";

std::vector<std::string> seeds(std::string_view target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder / target / "corpus"))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> texts;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    texts.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return texts;
}

/// Tokens of a libFuzzer dictionary: the text between double quotes, one a line.
std::vector<std::string> tokens(std::string_view target) {
  std::ifstream stream(kFolder / target / "dictionary");
  std::vector<std::string> found;
  for (std::string line; std::getline(stream, line);)
    if (line.size() > 2 && line.front() == '"' && line.back() == '"')
      found.push_back(line.substr(1, line.size() - 2));
  return found;
}

/// A seed with one mutation: a flipped bit, an inserted token, or a part removed, repeated, or
/// copied from elsewhere.
std::string mutated(const std::string& seed, const std::vector<std::string>& words,
                    const std::string& other, RandomNumbers& random) {
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random.index(static_cast<int>(n) + 1));
  };
  std::string text = seed;
  const std::size_t at = below(text.size());
  const std::size_t length = std::min<std::size_t>(below(40), text.size() - at);
  switch (random.index(6)) {
    case 0:
      if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << random.index(8)));
      break;
    case 1:
      if (!words.empty()) text.insert(at, words[below(words.size() - 1)]);
      break;
    case 2:
      text.erase(at, length);
      break;
    case 3:
      text.insert(at, text.substr(at, length));
      break;
    case 4:
      text.resize(at);
      break;
    default:
      text.replace(at, length, other.substr(below(other.size()), 40));
  }
  return text;
}

class Replay : public testing::TestWithParam<FuzzTarget> {};

TEST_P(Replay, SeedsKeepEveryPromise) {
  const std::vector<std::string> texts = seeds(GetParam().name);
  ASSERT_FALSE(texts.empty());
  for (const std::string& text : texts) GetParam().run(text);
}

TEST_P(Replay, MutationsKeepEveryPromise) {
  const std::vector<std::string> texts = seeds(GetParam().name);
  const std::vector<std::string> words = tokens(GetParam().name);
  ASSERT_FALSE(texts.empty());
  ASSERT_FALSE(words.empty());
  RandomNumbers random(20);
  constexpr int kRuns = 2000;
  for (int i = 0; i < kRuns; ++i) {
    const std::string& seed = texts[i % texts.size()];
    std::string text = seed;
    for (int changes = 1 + i % 3; changes > 0; --changes)
      text = mutated(text, words, texts[random.index(static_cast<int>(texts.size()))], random);
    GetParam().run(text);
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, Replay,
                         testing::ValuesIn(fuzz_targets().begin(), fuzz_targets().end()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace conddp
