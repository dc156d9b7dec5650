#include "ocp/terms/residual.hpp"

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

}  // namespace conddp
