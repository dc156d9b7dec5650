#include "ocp/terms/residual.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace conddp {

std::vector<int> column_range(int first, int count) {
  std::vector<int> columns(count);
  std::iota(columns.begin(), columns.end(), first);
  return columns;
}

void check_fit(const std::string& what, const Residual& residual, bool has_control, int nz) {
  if (residual.needs_control() && !has_control)
    throw std::invalid_argument(what + " needs a control, and this node has none");
  for (const RowBlock& block : residual.blocks())
    for (const int column : block.columns)
      if (column < 0 || column >= nz)
        throw std::invalid_argument(what + " depends on column " + std::to_string(column) +
                                    ", and a knot has " + std::to_string(nz));
}

std::vector<RowBlock> joined_blocks(std::vector<RowBlock> rows) {
  std::vector<RowBlock> blocks;
  for (RowBlock& row : rows) {
    std::sort(row.columns.begin(), row.columns.end());
    row.columns.erase(std::unique(row.columns.begin(), row.columns.end()), row.columns.end());
    const bool same = !blocks.empty() && blocks.back().columns == row.columns &&
                      blocks.back().affine == row.affine &&
                      blocks.back().affine_columns == row.affine_columns;
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
