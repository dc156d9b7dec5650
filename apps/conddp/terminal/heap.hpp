#pragma once

namespace conddp {

/// Prepares the heap for a command that computes: it grows in large steps and keeps freed memory,
/// and its first part may use huge pages. Otherwise the system spends a tenth of a short solve on
/// providing 4 kB pages one by one. Only addresses are reserved.
void prepare_heap();

}  // namespace conddp
