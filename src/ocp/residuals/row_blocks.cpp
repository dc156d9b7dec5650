#include "ocp/residuals/row_blocks.hpp"

#include <algorithm>

namespace conddp {

std::vector<RowBlock> joined_blocks(std::vector<RowBlock> rows) {
  std::vector<RowBlock> blocks;
  for (RowBlock& row : rows) {
    std::sort(row.columns.begin(), row.columns.end());
    row.columns.erase(std::unique(row.columns.begin(), row.columns.end()), row.columns.end());
    const bool same = !blocks.empty() && blocks.back().columns == row.columns &&
                      blocks.back().affine == row.affine;
    if (same)
      ++blocks.back().rows;
    else
      blocks.push_back(std::move(row));
  }
  return blocks;
}

int PackedRow::place(int column) const {
  const auto at = std::lower_bound(block->columns.begin(), block->columns.end(), column);
  return first + static_cast<int>(at - block->columns.begin()) * block->rows;
}

std::vector<PackedRow> packed_rows(const Residual& residual) {
  std::vector<PackedRow> rows;
  int first = 0;
  for (const RowBlock& block : residual.blocks()) {
    for (int row = 0; row < block.rows; ++row) rows.push_back({&block, first + row});
    first += block.rows * static_cast<int>(block.columns.size());
  }
  return rows;
}

}  // namespace conddp
