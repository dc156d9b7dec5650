#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A list of numbers, or a table of them row by row, as one value of a document: their bytes. A
/// document with blocks is made, read and stored many times faster than one with lists. JSON has no
/// blocks: with_lists() turns them into lists, and JSON texts have lists in their place. What is
/// not finite is NaN in a block, null in a list.
OrderedJson number_block(std::span<const double> list);
OrderedJson number_block(std::size_t rows, std::size_t columns, std::span<const double> table);

/// A view of a block. It lives no longer than the value.
class NumberBlock {
 public:
  /// Nothing where the value is no block.
  static std::optional<NumberBlock> of(const OrderedJson& value);

  /// Entries of a list, or rows of a table.
  std::size_t size() const { return is_table() ? rows_ : columns_; }
  bool is_table() const { return rows_ != kList; }
  /// Columns of a table.
  std::size_t columns() const { return columns_; }
  /// One of all numbers, row by row.
  double number(std::size_t i) const {
    double value = 0;
    std::memcpy(&value, numbers_ + i * sizeof value, sizeof value);
    return value;
  }
  /// How many of all numbers are not numbers.
  std::size_t count_nan() const;
  /// All numbers, row by row; `out` has as many.
  void copy(double* out) const;
  /// A row of a table; `out` has as many numbers as there are columns.
  void copy_row(std::size_t row, double* out) const;

 private:
  static constexpr std::size_t kList = 0xffffffff;
  std::size_t count() const { return is_table() ? rows_ * columns_ : columns_; }

  std::size_t rows_ = kList, columns_ = 0;
  const std::uint8_t* numbers_ = nullptr;
  friend OrderedJson number_block(std::span<const double> list);
};

/// Entries of a list or of a block; nothing where the value is neither.
std::optional<std::size_t> entries_of(const OrderedJson& list);

/// The document with lists in the place of blocks.
OrderedJson with_lists(OrderedJson document);

/// A document in CBOR (RFC 8949), which holds blocks as they are, and back: a discarded value where
/// the bytes are none.
std::string packed_document(const OrderedJson& document);
OrderedJson unpacked_document(std::string_view bytes);

}  // namespace conddp
