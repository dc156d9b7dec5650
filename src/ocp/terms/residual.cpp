#include "ocp/terms/residual.hpp"

#include <numeric>

namespace conddp {

std::vector<int> column_range(int first, int count) {
  std::vector<int> columns(count);
  std::iota(columns.begin(), columns.end(), first);
  return columns;
}

}  // namespace conddp
