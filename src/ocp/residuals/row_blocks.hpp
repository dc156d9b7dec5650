#pragma once

#include <vector>

#include "ocp/terms/residual.hpp"

namespace conddp {

/// Sorts the columns of single rows, removes duplicates, and merges consecutive rows with the same
/// columns into blocks.
std::vector<RowBlock> joined_blocks(std::vector<RowBlock> rows);

/// The block of a residual that contains a row, and the row's place there.
struct PackedRow {
  const RowBlock* block;
  int first;  ///< its first derivative among those of the residual; stride to the next column:
              ///< block->rows

  /// Place of its derivative by one of the block's columns.
  int place(int column) const;
};
std::vector<PackedRow> packed_rows(const Residual& residual);

}  // namespace conddp
