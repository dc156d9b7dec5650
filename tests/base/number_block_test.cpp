#include "base/json/number_block.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "base/files/check_sum.hpp"

namespace conddp {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(NumberBlock, RepresentsAListOrATable) {
  const std::vector<double> numbers = {1, -0.1, kInfinite, kNone, 1e-300, 7};
  OrderedJson document = {
      {"list", number_block(numbers)},
      {"rows", {number_block(2, 3, numbers), number_block(std::vector<double>())}},
      {"text", "as it is"}};
  const OrderedJson lists = {
      {"list", {1.0, -0.1, nullptr, nullptr, 1e-300, 7.0}},
      {"rows", {{{1.0, -0.1, nullptr}, {nullptr, 1e-300, 7.0}}, OrderedJson::array()}},
      {"text", "as it is"}};
  EXPECT_EQ(with_lists(document), lists);
  EXPECT_EQ(with_lists(unpacked_document(packed_document(document))), lists);
}

TEST(NumberBlock, ReportsEntriesAndColumns) {
  const std::vector<double> numbers = {1, 2, 3, 4, 5, 6};
  const OrderedJson list = number_block(numbers), table = number_block(2, 3, numbers);
  EXPECT_EQ(entries_of(list), 6u);
  EXPECT_EQ(entries_of(table), 2u);
  EXPECT_EQ(entries_of(OrderedJson({1, 2, 3})), 3u);
  EXPECT_EQ(entries_of(OrderedJson("text")), std::nullopt);
  const auto block = NumberBlock::of(table);
  ASSERT_TRUE(block);
  EXPECT_TRUE(block->is_table());
  EXPECT_EQ(block->columns(), 3u);
  std::vector<double> row(3);
  block->copy_row(1, row.data());
  EXPECT_EQ(row, (std::vector<double>{4, 5, 6}));
  EXPECT_EQ(block->count_nan(), 0u);
  const OrderedJson some = number_block(std::vector<double>{1, kInfinite, kNone});
  EXPECT_EQ(NumberBlock::of(some)->count_nan(), 2u);
}

TEST(NumberBlock, DistinguishesBadBlocksFromBadDocuments) {
  EXPECT_FALSE(NumberBlock::of(OrderedJson::binary({1, 2, 3})));
  EXPECT_FALSE(NumberBlock::of(OrderedJson::binary({2, 0, 0, 0, 1, 0, 0, 0, 9})));
  EXPECT_FALSE(NumberBlock::of(OrderedJson({1, 2})));
  EXPECT_TRUE(unpacked_document("\xff\xff").is_discarded());
}

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

}  // namespace
}  // namespace conddp
