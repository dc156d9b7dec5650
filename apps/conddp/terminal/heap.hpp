#pragma once

namespace conddp {

/// Sets the heap up for a command that computes: it grows in large steps and keeps what is freed,
/// and its first part may lie in huge pages. Otherwise the system spends a tenth of a short solve
/// on handing out pages of 4 kB one by one. Nothing is reserved but addresses.
void prepare_heap();

}  // namespace conddp
