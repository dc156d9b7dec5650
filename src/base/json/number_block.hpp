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

/// A list of numbers, or a table of them by rows, stored as bytes in a single value of a document.
/// A document with blocks is made, read and stored many times faster than one with lists. JSON does
/// not support blocks: with_lists() converts them into lists, and JSON texts contain lists instead.
/// Numbers that are not finite are NaN in a block, null in a list.
OrderedJson number_block(std::span<const double> list);
OrderedJson number_block(std::size_t rows, std::size_t columns, std::span<const double> table);

/// A view of a block; valid as long as the value exists.
class NumberBlock {
 public:
  /// Nothing if the value is not a block.
  static std::optional<NumberBlock> of(const OrderedJson& value);

  /// Number of list entries, or of table rows.
  std::size_t size() const { return is_table() ? rows_ : columns_; }
  bool is_table() const { return rows_ != kList; }
  /// Number of columns of a table.
  std::size_t columns() const { return columns_; }
  /// The i-th of all numbers, row by row.
  double number(std::size_t i) const {
    double value = 0;
    std::memcpy(&value, numbers_ + i * sizeof value, sizeof value);
    return value;
  }
  /// The count of NaN values.
  std::size_t count_nan() const;
  /// Copies all numbers, row by row, to `out`, which must have room for them.
  void copy(double* out) const;
  /// Copies a row of a table to `out`, which must have room for columns() numbers.
  void copy_row(std::size_t row, double* out) const;

 private:
  static constexpr std::size_t kList = 0xffffffff;
  std::size_t count() const { return is_table() ? rows_ * columns_ : columns_; }

  std::size_t rows_ = kList, columns_ = 0;
  const std::uint8_t* numbers_ = nullptr;
  friend OrderedJson number_block(std::span<const double> list);
};

/// Size of a list or of a block; nothing if the value is neither.
std::optional<std::size_t> entries_of(const OrderedJson& list);

/// The document with lists instead of blocks.
OrderedJson with_lists(OrderedJson document);

/// Converts a document to and from CBOR (RFC 8949), which stores blocks natively. Invalid bytes
/// give a discarded value.
std::string packed_document(const OrderedJson& document);
OrderedJson unpacked_document(std::string_view bytes);

}  // namespace conddp
