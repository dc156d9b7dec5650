#pragma once

#include <vector>

#include "ocp/terms/residual.hpp"

namespace conddp {

/// Sorts the columns of single rows, each once, and makes one block of rows with the same columns
/// that follow each other.
std::vector<RowBlock> joined_blocks(std::vector<RowBlock> rows);

/// Which block a row of a residual is in, and where.
struct PackedRow {
  const RowBlock* block;
  int first;  ///< its first derivative among those of the residual; one column further: block->rows

  /// Where its derivative by one of the block's columns is.
  int place(int column) const;
};
std::vector<PackedRow> packed_rows(const Residual& residual);

}  // namespace conddp
