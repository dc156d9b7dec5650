#pragma once

#include <string_view>

namespace conddp {

/// Writes a whole text to a blocking descriptor, and continues after interrupting signals. Returns
/// false on errors, with the reason in errno; part of the text may have been written.
bool write_all(int descriptor, std::string_view text);

}  // namespace conddp
