#include "support/source_tree.hpp"

namespace conddp {

std::filesystem::path source_tree() { return CONDDP_SOURCE_DIR; }

}  // namespace conddp
