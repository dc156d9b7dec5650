#pragma once

#include "arguments/batch_arguments.hpp"

namespace conddp {

/// Writes the files of one item: its problem with all defaults and its solution. Returns the exit
/// status.
int show_item(const BatchArguments& arguments);

/// Writes the page of a run, and the files of the linked items. Returns the exit status.
int report_batch(const BatchArguments& arguments);

}  // namespace conddp
