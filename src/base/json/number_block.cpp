#include "base/json/number_block.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace conddp {
namespace {

/// Rows and columns, stored before the numbers.
using Head = std::array<std::uint32_t, 2>;

OrderedJson make_block(const Head& head, std::span<const double> numbers) {
  std::vector<std::uint8_t> bytes(sizeof(Head) + numbers.size_bytes());
  std::memcpy(bytes.data(), head.data(), sizeof(Head));
  std::uint8_t* out = bytes.data() + sizeof(Head);
  if (!numbers.empty()) std::memcpy(out, numbers.data(), numbers.size_bytes());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i])) std::memcpy(out + i * sizeof kNone, &kNone, sizeof kNone);
  return OrderedJson::binary(std::move(bytes));
}

OrderedJson list_of(const std::vector<double>& numbers, std::size_t first, std::size_t count) {
  OrderedJson list = OrderedJson::array();
  for (std::size_t i = first; i < first + count; ++i) list.push_back(finite_or_null(numbers[i]));
  return list;
}

OrderedJson lists_of(const NumberBlock& block) {
  std::vector<double> numbers(block.size() * (block.is_table() ? block.columns() : 1));
  block.copy(numbers.data());
  if (!block.is_table()) return list_of(numbers, 0, numbers.size());
  OrderedJson rows = OrderedJson::array();
  for (std::size_t row = 0; row < block.size(); ++row)
    rows.push_back(list_of(numbers, row * block.columns(), block.columns()));
  return rows;
}

}  // namespace

OrderedJson number_block(std::span<const double> list) {
  return make_block(
      {static_cast<std::uint32_t>(NumberBlock::kList), static_cast<std::uint32_t>(list.size())},
      list);
}

OrderedJson number_block(std::size_t rows, std::size_t columns, std::span<const double> table) {
  return make_block({static_cast<std::uint32_t>(rows), static_cast<std::uint32_t>(columns)},
                    table.first(rows * columns));
}

std::optional<NumberBlock> NumberBlock::of(const OrderedJson& value) {
  if (!value.is_binary()) return std::nullopt;
  const auto& bytes = value.get_binary();
  Head head{};
  if (bytes.size() < sizeof head) return std::nullopt;
  std::memcpy(head.data(), bytes.data(), sizeof head);
  NumberBlock found;
  found.rows_ = head[0];
  found.columns_ = head[1];
  found.numbers_ = bytes.data() + sizeof head;
  if ((bytes.size() - sizeof head) / sizeof(double) != found.count()) return std::nullopt;
  return found;
}

std::size_t NumberBlock::count_nan() const {
  std::size_t nan = 0;
  for (std::size_t i = 0; i < count(); ++i) nan += std::isnan(number(i));
  return nan;
}

void NumberBlock::copy(double* out) const {
  if (count() > 0) std::memcpy(out, numbers_, count() * sizeof(double));
}

void NumberBlock::copy_row(std::size_t row, double* out) const {
  if (columns_ > 0)
    std::memcpy(out, numbers_ + row * columns_ * sizeof(double), columns_ * sizeof(double));
}

std::optional<std::size_t> entries_of(const OrderedJson& list) {
  if (list.is_array()) return list.size();
  if (const auto block = NumberBlock::of(list)) return block->size();
  return std::nullopt;
}

OrderedJson with_lists(OrderedJson document) {
  if (const auto block = NumberBlock::of(document)) return lists_of(*block);
  if (document.is_structured())
    for (OrderedJson& part : document) part = with_lists(std::move(part));
  return document;
}

std::string packed_document(const OrderedJson& document) {
  std::string bytes;
  OrderedJson::to_cbor(document, bytes);
  return bytes;
}

OrderedJson unpacked_document(std::string_view bytes) {
  return OrderedJson::from_cbor(bytes, true, false);
}

}  // namespace conddp
